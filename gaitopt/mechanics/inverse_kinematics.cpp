// Two legs of six joints between placements of pelvis and swing sole, as inverse_kinematics.py and
// double_support.py have them.
//
// With S the joints' axes in the world, of the stance leg and of the swing leg, the twists of
// pelvis and sole are
//
//     V_p = S_st dq_st        V_s = S_st dq_st + S_sw dq_sw
//
// so that two systems of six equations give the rates, and two with the transposed matrices the
// forces that weights of the joints are worth.
//
// At constant rates the end of a chain accelerates by the sum over i < j of S_i x S_j
// (Featherstone, 2008, chapter 3). A point that it carries, moved by joint j with u_j, has second
// derivatives w_i x u_j, with joint i nearer to the base than j or the same.
#include "kernels.hpp"

namespace gaitopt {
namespace {

using V = VectorOf<One>;
using M = MatrixOf<One>;
using P = PairOf<One>;

constexpr int LEG = 6;  // joints
constexpr double SMALL = 1e-4;  // rad: below it a series is exact

// Solve A X = B, (6, 6) by (6, count), with exchanges of rows: not finite where A is singular.
void solve(double (*A)[LEG], double *B, std::ptrdiff_t count) {
  for (int k = 0; k < LEG; ++k) {
    int pivot = k;
    for (int i = k + 1; i < LEG; ++i)
      if (std::abs(A[i][k]) > std::abs(A[pivot][k])) pivot = i;
    if (pivot != k) {
      std::swap_ranges(A[k], A[k] + LEG, A[pivot]);
      std::swap_ranges(B + k * count, B + (k + 1) * count, B + pivot * count);
    }
    for (int i = k + 1; i < LEG; ++i) {
      const double factor = A[i][k] / A[k][k];
      for (int j = k + 1; j < LEG; ++j) A[i][j] -= factor * A[k][j];
      for (std::ptrdiff_t c = 0; c < count; ++c) B[i * count + c] -= factor * B[k * count + c];
    }
  }
  for (int k = LEG - 1; k >= 0; --k)
    for (std::ptrdiff_t c = 0; c < count; ++c) {
      double sum = B[k * count + c];
      for (int j = k + 1; j < LEG; ++j) sum -= A[k][j] * B[j * count + c];
      B[k * count + c] = sum / A[k][k];
    }
}

// Rates of a leg's joints from twists of its end against its start, B (6, count), in their place;
// or, transposed, forces from weights of its joints.
void through_leg(const P *axes, bool transposed, double *B, std::ptrdiff_t count) {
  double A[LEG][LEG];
  for (int j = 0; j < LEG; ++j) {
    const V &l = axes[j].linear, &w = axes[j].angular;
    const double six[LEG] = {l.x, l.y, l.z, w.x, w.y, w.z};
    for (int i = 0; i < LEG; ++i) (transposed ? A[j][i] : A[i][j]) = six[i];
  }
  solve(A, B, count);
}

// The twist that displaces by rotation R and then p in a unit of time.
P logarithm(const M &R, const V &p) {
  // a multiple of the unit quaternion: the row of its products with the largest diagonal entry
  const double x = R.x.x, y = R.y.y, z = R.z.z;
  const double xy = R.x.y + R.y.x, xz = R.x.z + R.z.x, yz = R.y.z + R.z.y;
  const double ax = R.z.y - R.y.z, ay = R.x.z - R.z.x, az = R.y.x - R.x.y;
  const double rows[4][4] = {{1.0 + x - y - z, xy, xz, ax},
                             {xy, 1.0 - x + y - z, yz, ay},
                             {xz, yz, 1.0 - x - y + z, az},
                             {ax, ay, az, 1.0 + x + y + z}};
  int best = 3;
  for (int i = 0; i < 3; ++i)
    if (rows[i][i] > rows[best][best]) best = i;
  const double *q = rows[best], sign = q[3] < 0.0 ? -1.0 : 1.0;
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]), real = sign * q[3];
  const double angle = 2.0 * std::atan2(size, real);
  const V w = (sign * (angle < SMALL ? 2.0 / real : angle / size)) * constant<One>(q);
  const double bent = angle < SMALL ? 1.0 / 12.0
                                    : (1.0 - 0.5 * angle * real / size) / (angle * angle);
  return {p - 0.5 * cross(w, p) + bent * cross(w, cross(w, p)), w};
}

// The twist that takes a frame of a placed body to where it ought to be, a matrix (4, 4).
P gap(const PlacedOf<One> &body, const double *frame, const double *target) {
  const M Q = body.rotation * constant_matrix<One>(frame);
  const M T = {constant<One>(target), constant<One>(target + 4), constant<One>(target + 8)};
  const V to = {target[3], target[7], target[11]};
  const M R = {Q * T.x, Q * T.y, Q * T.z};  // T Q'
  return logarithm(R, to - R * (body.rotation * constant<One>(frame + 9) + body.origin));
}

void put(const V &vector, double *xyz) {
  xyz[0] = vector.x;
  xyz[1] = vector.y;
  xyz[2] = vector.z;
}

void store(const P &pair, double *six) {
  put(pair.linear, six);
  put(pair.angular, six + 3);
}

// Add to a Hessian (G, G) what a chain bends, by the forces at its joints and by points that it
// carries to the end.
void add_bends(const Chain &chain, std::ptrdiff_t size, const P *forces, int points,
               const V *places, const V *weights, double *hessian) {
  std::vector<double> felt(chain.count * size, 0.0);
  for (std::ptrdiff_t j = 0; j < chain.count; ++j) {
    const P S = pair_at(chain.axes + 6 * j);
    const P force = -0.5 * cross_force(S, forces[j]);  // F . (S_i x S_j) = -S_i . (S_j x* F)
    V by_turns = nothing<One>();
    for (int p = 0; p < points; ++p)
      by_turns += cross(S.linear + cross(S.angular, places[p]), weights[p]);
    for (std::ptrdiff_t i = 0; i <= j; ++i) {
      const P before = pair_at(chain.axes + 6 * i);
      const double bend = (i < j ? -dot(before, force) : 0.0) + dot(before.angular, by_turns);
      for (std::ptrdiff_t g = 0; g < size; ++g) {
        felt[i * size + g] += bend * chain.rates[j * size + g];
        if (i < j) felt[j * size + g] += bend * chain.rates[i * size + g];
      }
    }
  }
  for (std::ptrdiff_t i = 0; i < chain.count; ++i)
    for (std::ptrdiff_t g = 0; g < size; ++g)
      for (std::ptrdiff_t h = 0; h < size; ++h)
        hessian[g * size + h] += chain.rates[i * size + g] * felt[i * size + h];
}

}  // namespace

bool close_legs(const Bodies &robot, const double *targets, const Search &search, double *q) {
  PlacedOf<One> placed[2 * LEG];
  P axes[2 * LEG];
  for (int steps = 0; steps < search.steps; ++steps) {
    for (int j = 0; j < 2 * LEG; ++j) {
      place_joint<One>(robot, j, q[j], placed);
      axes[j] = placed[j].axis;
    }
    const P pelvis = gap(placed[LEG - 1], robot.frames.data(), targets);
    const P sole = gap(placed[2 * LEG - 1], robot.frames.data() + 12, targets + 16);
    double step[2 * LEG], largest = 0.0;
    store(pelvis, step);
    store(sole - pelvis, step + LEG);
    through_leg(axes, false, step, 1);
    through_leg(axes + LEG, false, step + LEG, 1);
    for (const double one : step) {
      if (!std::isfinite(one)) return false;
      largest = std::max(largest, std::abs(one));
    }
    const double share = std::min(1.0, search.largest / std::max(largest, search.largest));
    for (int j = 0; j < 2 * LEG; ++j) q[j] += share * step[j];
    if (largest < search.last) return true;
  }
  return false;
}

void place_support(const Placing &placing, const double *geometry, const Placements &found) {
  M rotations[2];
  V origins[2];
  for (int body = 0; body < 2; ++body) {
    M R = identity<One>();
    V p = nothing<One>();
    double *axes = found.axes[body];
    for (const Displacement &one : placing.chains[body]) {
      const double amount = one.factor * (one.quantity < 0 ? 1.0 : geometry[one.quantity]);
      const V own = constant<One>(one.axis), axis = R * own;
      if (one.turns) {
        const V point = constant<One>(one.point), at = R * point + p;
        store({cross(at, axis), axis}, axes);
        R = R * turn(own, amount);
        p = at - R * point;
      } else {
        store({axis, nothing<One>()}, axes);
        p += amount * axis;
      }
      axes += 6;
    }
    const double frame[16] = {R.x.x, R.x.y, R.x.z, p.x, R.y.x, R.y.y, R.y.z, p.y,
                              R.z.x, R.z.y, R.z.z, p.z, 0.0,   0.0,   0.0,   1.0};
    std::copy(frame, frame + 16, found.frames + 16 * body);
    rotations[body] = R;
    origins[body] = p;
  }
  const double *hips = placing.hips.data(), *ankles = placing.ankles.data();
  const V points[3] = {rotations[0] * constant<One>(hips) + origins[0],
                       rotations[0] * constant<One>(hips + 3) + origins[0],
                       rotations[1] * constant<One>(ankles + 3) + origins[1]};
  const V legs[2] = {points[0] - constant<One>(ankles), points[1] - points[2]};
  for (int k = 0; k < 3; ++k) put(points[k], found.points + 3 * k);
  for (int k = 0; k < 2; ++k) put(legs[k], found.legs + 3 * k);
}

void support_slopes(const DoubleSupport &support, const double *joints, double *rates,
                    double *legs) {
  const std::ptrdiff_t size = support.size;
  std::vector<double> twists(12 * size, 0.0);
  for (int body = 0; body < 2; ++body) {
    const Chain &chain = support.chains[body];
    for (std::ptrdiff_t j = 0; j < chain.count; ++j)
      for (int i = 0; i < 6; ++i)
        for (std::ptrdiff_t g = 0; g < size; ++g)
          twists[(6 * body + i) * size + g] += chain.axes[6 * j + i] * chain.rates[j * size + g];
  }
  for (std::ptrdiff_t g = 0; g < size; ++g) {
    P twist[2];
    for (int body = 0; body < 2; ++body) {
      double six[6];
      for (int i = 0; i < 6; ++i) six[i] = twists[(6 * body + i) * size + g];
      twist[body] = pair_at(six);
    }
    const auto moved = [&](int body, int point) {
      const V at = constant<One>(support.points + 3 * point);
      return twist[body].linear + cross(twist[body].angular, at);
    };
    const V each[2] = {moved(0, 0), moved(0, 1) - moved(1, 2)};
    for (int leg = 0; leg < 2; ++leg) {
      legs[(3 * leg + 0) * size + g] = each[leg].x;
      legs[(3 * leg + 1) * size + g] = each[leg].y;
      legs[(3 * leg + 2) * size + g] = each[leg].z;
    }
  }
  if (joints == nullptr) return;
  P axes[2 * LEG];
  for (int j = 0; j < 2 * LEG; ++j) axes[j] = pair_at(joints + 6 * j);
  for (std::ptrdiff_t k = 0; k < LEG * size; ++k) {
    rates[k] = twists[k];
    rates[LEG * size + k] = twists[LEG * size + k] - twists[k];
  }
  through_leg(axes, false, rates, size);
  through_leg(axes + LEG, false, rates + LEG * size, size);
}

void support_hessian(const DoubleSupport &support, const Chain &joints, const double *q_weights,
                     const double *leg_weights, double *hessian) {
  const std::ptrdiff_t size = support.size;
  std::fill(hessian, hessian + size * size, 0.0);
  P forces[2] = {no_pair<One>(), no_pair<One>()};
  if (joints.count > 0) {
    P axes[2 * LEG], transmitted[2 * LEG];
    double worth[2 * LEG];
    std::copy(q_weights, q_weights + 2 * LEG, worth);
    for (int j = 0; j < 2 * LEG; ++j) axes[j] = pair_at(joints.axes + 6 * j);
    through_leg(axes, true, worth, 1);
    through_leg(axes + LEG, true, worth + LEG, 1);
    const P both = pair_at(worth), sole = pair_at(worth + LEG);
    for (int j = 0; j < 2 * LEG; ++j) transmitted[j] = -1.0 * (j < LEG ? both : sole);
    add_bends(joints, size, transmitted, 0, nullptr, nullptr, hessian);
    forces[0] = both - sole;
    forces[1] = sole;
  }
  const V of_stance = constant<One>(leg_weights), of_swing = constant<One>(leg_weights + 3);
  const V weights[3] = {of_stance, of_swing, -1.0 * of_swing};
  V points[3];
  for (int p = 0; p < 3; ++p) points[p] = constant<One>(support.points + 3 * p);
  for (int body = 0; body < 2; ++body) {
    const Chain &chain = support.chains[body];
    const std::vector<P> transmitted(chain.count, forces[body]);
    const int first = body == 0 ? 0 : 2;
    add_bends(chain, size, transmitted.data(), body == 0 ? 2 : 1, points + first, weights + first,
              hessian);
  }
}

}  // namespace gaitopt
