// Nearest points of pairs of segments at all instants, as capsule_distance.py has them.
//
// Of the lines, then each clamped to its segment (Ericson, Real-Time Collision Detection, 2005,
// section 5.1.9).
#include "kernels.hpp"

namespace gaitopt {
namespace {

constexpr double POINT = 1e-12;     // m2: a shorter segment is a point
constexpr double PARALLEL = 1e-12;  // squared sine of the angle

struct Segment {
  Vector start, along;
};

GAITOPT_INLINE Lane clamped(Lane share) {  // what is no number stays none
  share = share < all(0.0) ? all(0.0) : share;
  return share > all(1.0) ? all(1.0) : share;
}

GAITOPT_ANY_PROCESSOR
void four_instants(const Capsules &capsules, const double *frames, std::ptrdiff_t count,
                   std::ptrdiff_t first, Segment *placed, double *found) {
  const Instants here(first, count);
  for (std::ptrdiff_t c = 0; c < capsules.count; ++c) {
    const double *frame = frames + capsules.carriers[c] * count * 16;
    const double *local = capsules.segments + 6 * c;
    Lane row[3][4];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) row[i][j] = here.load(frame, 16, 4 * i + j);
    const Matrix R = {{row[0][0], row[0][1], row[0][2]},
                      {row[1][0], row[1][1], row[1][2]},
                      {row[2][0], row[2][1], row[2][2]}};
    const Vector origin = {row[0][3], row[1][3], row[2][3]};
    placed[c] = {R * constant(local) + origin, R * constant(local + 3)};
  }
  const std::ptrdiff_t all_pairs = capsules.pairs * count;
  for (std::ptrdiff_t pair = 0; pair < capsules.pairs; ++pair) {
    const Segment &one = placed[capsules.first[pair]], &other = placed[capsules.second[pair]];
    const Vector &p = one.along, &q = other.along;
    const double square_p = capsules.squares[pair];
    const double square_q = capsules.squares[capsules.pairs + pair];
    const Lane pp = all(square_p), qq = all(square_q), both = pp * qq;
    const Lane short_p = all(std::max(square_p, POINT)), short_q = all(std::max(square_q, POINT));
    Vector between = one.start - other.start;
    const Lane pq = dot(p, q), p_apart = dot(p, between), q_apart = dot(q, between);
    const Lane skewed = both - pq * pq;
    const auto level = square_p <= POINT || square_q <= POINT ? both == both
                                                              : skewed <= all(PARALLEL) * both;
    Lane s = (pq * q_apart - p_apart * qq) / (level ? all(1.0) : skewed);
    s = clamped(level ? -p_apart / short_p : s);
    const Lane t_free = (pq * s + q_apart) / short_q, t = clamped(t_free);
    s = t != t_free ? clamped((pq * t - p_apart) / short_p) : s;
    between = between + s * p;
    between = between - t * q;
    const Lane numbers[14] = {p.x, p.y, p.z, q.x, q.y, q.z, s, t, other.start.x, other.start.y,
                              other.start.z, between.x, between.y, between.z};
    for (int i = 0; i < 14; ++i) here.store(found + i * all_pairs + pair * count, 1, 0, numbers[i]);
  }
}

}  // namespace

void nearest(const Capsules &capsules, const double *frames, std::ptrdiff_t count, double *found) {
  std::vector<Segment> placed(capsules.count);
  for (std::ptrdiff_t first = 0; first < count; first += LANES)
    four_instants(capsules, frames, count, first, placed.data(), found);
}

}  // namespace gaitopt
