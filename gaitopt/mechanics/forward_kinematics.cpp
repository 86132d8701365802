// Frames of the bodies at all postures, points of the swing foot with their derivatives, and what
// weighed corners of a sole bend, as forward_kinematics.py has them: turning joint j turns all that
// joint k >= j moves, so that
//
//     sum of f_c . d2 p_c / dq_j dq_k = w_j . sum of (d p_c / dq_k) x f_c
#include "kernels.hpp"

namespace gaitopt {
namespace {

GAITOPT_ANY_PROCESSOR
void four_postures(const Bodies &robot, const double *angles, std::ptrdiff_t count,
                   std::ptrdiff_t first, PlacedOf<Four> *placed, double *frames) {
  const Instants here(first, count);
  for (int j = 0; j < robot.count; ++j) {
    place_joint<Four>(robot, j, here.load(angles, robot.count, j), placed);
    const Matrix &R = placed[j].rotation;
    const Vector &p = placed[j].origin;
    const Lane zero = all(0.0);
    const Lane numbers[16] = {R.x.x, R.x.y, R.x.z, p.x, R.y.x, R.y.y, R.y.z, p.y,
                              R.z.x, R.z.y, R.z.z, p.z, zero,  zero,  zero,  all(1.0)};
    double *own = frames + (j + 1) * count * 16;
    for (int i = 0; i < 16; ++i) here.store(own, 16, i, numbers[i]);
  }
}

GAITOPT_ANY_PROCESSOR
void four_bent(const WeightedCorners &given, std::ptrdiff_t first, double *hessian) {
  const std::ptrdiff_t n = given.joints;
  const Instants here(first, given.count);
  Vector forces[4];
  for (int c = 0; c < 4; ++c)
    forces[c] = {here.load(given.weights, 12, 3 * c), here.load(given.weights, 12, 3 * c + 1),
                 here.load(given.weights, 12, 3 * c + 2)};
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    Vector moment = nothing();
    for (int c = 0; c < 4; ++c) {
      const std::ptrdiff_t row = 3 * c * n + k;
      moment += cross({here.load(given.jacobian, 12 * n, row),
                       here.load(given.jacobian, 12 * n, row + n),
                       here.load(given.jacobian, 12 * n, row + 2 * n)},
                      forces[c]);
    }
    for (std::ptrdiff_t j = 0; j <= k; ++j) {
      const Lane bent = dot(load_pair(here, given.axes, 6 * n, 6 * j).angular, moment);
      here.store(hessian, n * n, j * n + k, bent);
      here.store(hessian, n * n, k * n + j, bent);
    }
  }
}

// Points p = R a + o of the swing foot; a joint of axis (l, w) that moves it moves them by l + w x p.
GAITOPT_ANY_PROCESSOR
void one_posture(const Bodies &robot, const double *frame, const double *axes,
                 const double *points, std::ptrdiff_t count, double *found, double *slopes) {
  const std::ptrdiff_t n = robot.count;
  const MatrixOf<One> R = constant_matrix<One>(frame);
  const VectorOf<One> origin = constant<One>(frame + 9);
  for (std::ptrdiff_t c = 0; c < count; ++c, found += 3) {
    const VectorOf<One> p = R * constant<One>(points + 3 * c) + origin;
    found[0] = p.x, found[1] = p.y, found[2] = p.z;
    if (axes == nullptr) continue;
    double *row = slopes + 3 * n * c;
    std::fill(row, row + 3 * n, 0.0);
    for (int j = robot.foot; j >= 0; j = robot.parents[j]) {
      const double *own = axes + 6 * j;
      const VectorOf<One> moved = constant<One>(own) + cross(constant<One>(own + 3), p);
      row[j] = moved.x, row[n + j] = moved.y, row[2 * n + j] = moved.z;
    }
  }
}

}  // namespace

void move_points(const Bodies &robot, const FootPoints &points, double *found, double *slopes) {
  const std::ptrdiff_t size = 3 * points.count;
  for (std::ptrdiff_t k = 0; k < points.instants; ++k)
    one_posture(robot, points.frames + 12 * k,
                points.axes == nullptr ? nullptr : points.axes + 6 * robot.count * k,
                points.points, points.count, found + size * k, slopes + robot.count * size * k);
}

void corner_hessian(const WeightedCorners &given, double *hessian) {
  for (std::ptrdiff_t first = 0; first < given.count; first += LANES)
    four_bent(given, first, hessian);
}

void place_bodies(const Bodies &robot, const double *angles, std::ptrdiff_t count, double *frames) {
  for (std::ptrdiff_t k = 0; k < count; ++k)  // the stance foot is the world
    for (int i = 0; i < 16; ++i) frames[16 * k + i] = i % 5 == 0 ? 1.0 : 0.0;
  std::vector<PlacedOf<Four>> placed(robot.count);
  for (std::ptrdiff_t first = 0; first < count; first += LANES)
    four_postures(robot, angles, count, first, placed.data(), frames);
}

}  // namespace gaitopt
