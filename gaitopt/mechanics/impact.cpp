// The impact that swaps the legs, its derivatives and its Hessian, as impact.py has them.
//
// With K the matrix of its linear system, Z the columns of K's inverse that J V+ goes with, and all
// else that depends on the posture on one side, R = D (V+ - V-) - J' I,
//
//     (V+, I, w) = (V-, 0, 0) - Z J V-        d / dV- = (1, 0, 0) - Z J
//     d / dq = -K^-1 (dR/dq, d(J V+)/dq, 0)
//
// R is an inverse dynamics without gravity and rates, whose acceleration is the jump, less what the
// impulse on the landing foot does: inverse_dynamics.cpp with v = 0. J V+ changes with joint j by
// v x S_j, v the twist of the body that the joint sits on.
//
// The Hessian is that of l . (R, J V+) along the derivatives: what inverse_dynamics_hessian.py has
// of frame velocities, for those of V+ and of l, and the inertial part, which is given.
#include <cstdlib>

#include "kernels.hpp"

namespace gaitopt {
namespace {

constexpr int BASE = 6;  // entries of V and of I that belong to a foot

using Motion = PairOf<One>;
using Force = PairOf<One>;

GAITOPT_INLINE Motion unit(int i) {
  double six[6] = {};
  six[i] = 1.0;
  return pair_at(six);
}
GAITOPT_INLINE void add(const PairOf<One> &pair, double factor, double *first,
                        std::ptrdiff_t apart) {
  const double six[6] = {pair.linear.x,  pair.linear.y,  pair.linear.z,
                         pair.angular.x, pair.angular.y, pair.angular.z};
  for (int i = 0; i < 6; ++i) first[i * apart] += factor * six[i];
}

// The landing sole in the world.
struct Sole {
  MatrixOf<One> rotation;
  VectorOf<One> origin;
};

GAITOPT_INLINE Motion seen_from(const Sole &sole, const Motion &v) {
  return {transposed(sole.rotation, v.linear + cross(v.angular, sole.origin)),
          transposed(sole.rotation, v.angular)};
}
GAITOPT_INLINE Force in_world(const Sole &sole, const Force &f) {
  const VectorOf<One> push = sole.rotation * f.linear;
  return {push, sole.rotation * f.angular + cross(sole.origin, push)};
}

// Twist after, or whatever adds up like it, of each body from the base's and the rates of the free
// joints that follow it in the table.
GAITOPT_INLINE void add_up(const Landing &at, const double *velocity, const double *axes,
                           Motion *found) {
  for (int j = 0; j < at.robot.count; ++j) {
    const int parent = at.robot.parents[j];
    const double rate = at.slopes[j] * velocity[BASE + at.motors[j]];
    found[j] = (parent < 0 ? pair_at(velocity) : found[parent]) + rate * pair_at(axes + 6 * j);
  }
}
// That of the body which joint j sits on.
GAITOPT_INLINE Motion before(const Landing &at, const double *velocity, const Motion *bodies,
                             int j) {
  return at.robot.parents[j] < 0 ? pair_at(velocity) : bodies[at.robot.parents[j]];
}

// Invert a matrix in its place: Gauss and Jordan, with rows exchanged for the largest pivot.
GAITOPT_INLINE void invert(double *A, int size, int *pivots) {
  for (int k = 0; k < size; ++k) {
    int pivot = k;
    for (int i = k + 1; i < size; ++i)
      if (std::abs(A[i * size + k]) > std::abs(A[pivot * size + k])) pivot = i;
    pivots[k] = pivot;
    double *__restrict own = A + k * size;
    if (pivot != k) std::swap_ranges(own, own + size, A + pivot * size);
    const double scale = 1.0 / own[k];
    for (int j = 0; j < size; ++j) own[j] *= scale;
    own[k] = scale;
    for (int i = 0; i < size; ++i) {
      if (i == k) continue;
      double *__restrict other = A + i * size;
      const double along = other[k];
      for (int j = 0; j < size; ++j) other[j] -= along * own[j];
      other[k] = -along * scale;  // after the row: a number just written would hold that up
    }
  }
  for (int k = size - 1; k >= 0; --k)
    if (pivots[k] != k)
      for (int i = 0; i < size; ++i) std::swap(A[i * size + k], A[i * size + pivots[k]]);
}

// Part of a table whose rows have a width.
template <class T>
struct Block {
  T *first;
  std::ptrdiff_t width;
  GAITOPT_INLINE T *row(std::ptrdiff_t i) const { return first + i * width; }
};

// Subtract A (rows, inner) B (inner, columns).
GAITOPT_INLINE void subtract_product(Block<const double> A, Block<const double> B, int rows,
                                     int inner, int columns, Block<double> from) {
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < inner; ++k) {
      const double factor = A.row(i)[k];
      const double *__restrict right = B.row(k);
      double *__restrict found = from.row(i);
      for (int j = 0; j < columns; ++j) found[j] -= factor * right[j];
    }
}

struct Work {
  std::vector<BodyOf<One>> placed;
  std::vector<InertiaOf<One>> beyond;
  std::vector<Motion> motions;
  std::vector<Force> forces;
  std::vector<double> J, sides;
  std::vector<int> pivots;
  explicit Work(const Landing &at)
      : placed(at.robot.count), beyond(at.robot.count), motions(2 * at.robot.count),
        forces(at.robot.count), J(BASE * at.speeds()), sides((at.speeds() + BASE) * at.free),
        pivots(at.size()) {}
};

// Put the bodies in place, and write axes, sole, J and K.
GAITOPT_INLINE void assemble(const Landing &at, const double *angles, Work &work, double *axes,
                             Sole &sole, double *K) {
  const Bodies &robot = at.robot;
  const int n = robot.count, nv = at.speeds(), size = at.size();
  std::fill(K, K + size * size, 0.0);
  for (int j = 0; j < n; ++j) {
    BodyOf<One> &own = work.placed[j];
    place_joint<One>(robot, j, angles[j], work.placed.data());
    own.inertia = inertia_at(&robot.inertias[13 * (j + 1)], own.rotation, own.origin);
    work.beyond[j] = own.inertia;
    std::fill(axes + 6 * j, axes + 6 * j + 6, 0.0);
    add(own.axis, 1.0, axes + 6 * j, 1);
  }
  InertiaOf<One> whole = inertia_at(robot.inertias.data(), identity<One>(), nothing<One>());
  for (int j = n - 1; j >= 0; --j) {
    const int parent = robot.parents[j];
    InertiaOf<One> &outer = parent < 0 ? whole : work.beyond[parent];
    outer = outer + work.beyond[j];
  }
  const BodyOf<One> &foot = work.placed[robot.foot];
  const double *place = &robot.frames[12];
  sole = {foot.rotation * constant_matrix<One>(place),
          foot.rotation * constant<One>(place + 9) + foot.origin};

  for (int b = 0; b < BASE; ++b) {
    add(whole * unit(b), 1.0, K + b, size);
    add(seen_from(sole, unit(b)), 1.0, &work.J[b], nv);
  }
  for (int j = 0; j < n; ++j) {
    const Motion &S = work.placed[j].axis;
    const Force moment = work.beyond[j] * S;
    const int column = BASE + at.motors[j];
    add(moment, at.slopes[j], K + column, size);
    add(moment, at.slopes[j], K + column * size, 1);
    for (int i = j; i >= 0; i = robot.parents[i]) {
      const int row = BASE + at.motors[i];
      const double both = at.slopes[i] * at.slopes[j];
      if (i == j) {
        K[row * size + row] += both * (dot(S, moment) + robot.armature[j]);
        continue;
      }
      const double inertia = both * dot(work.placed[i].axis, moment);
      K[row * size + column] += inertia;
      K[column * size + row] += inertia;
    }
  }
  for (int j = robot.foot; j >= 0; j = robot.parents[j])
    add(seen_from(sole, work.placed[j].axis), at.slopes[j], &work.J[BASE + at.motors[j]], nv);
  for (int i = 0; i < BASE; ++i)
    for (int j = 0; j < nv; ++j) {
      const double entry = work.J[i * nv + j];
      K[(nv + i) * size + j] = entry;
      K[j * size + nv + i] = -entry;
    }
  if (at.line.empty()) return;
  for (int i = 0; i < BASE; ++i) {
    K[(nv + i) * size + size - 1] = -at.line[i];
    K[(size - 1) * size + nv + i] = at.line[i];
  }
}

// Derivatives of R and of J V+ in the posture, (6 + m, m) and (6, m).
GAITOPT_INLINE void by_posture(const Landing &at, const Sole &sole, const double *jump,
                               const double *axes, const double *result, Work &work) {
  const Bodies &robot = at.robot;
  const int n = robot.count, m = at.free, nv = at.speeds();
  Motion *acceleration = work.motions.data(), *velocity = acceleration + n;
  add_up(at, jump, axes, acceleration);
  add_up(at, result, axes, velocity);
  std::vector<Force> &forces = work.forces;
  for (int j = 0; j < n; ++j) forces[j] = work.placed[j].inertia * acceleration[j];
  forces[robot.foot] = forces[robot.foot] - in_world(sole, pair_at(result + nv));
  for (int j = n - 1; j >= 0; --j)
    if (robot.parents[j] >= 0) forces[robot.parents[j]] += forces[j];
  for (int j = 0; j < n; ++j) {
    const Motion &S = work.placed[j].axis, r = cross_motion(before(at, jump, acceleration, j), S);
    const Force moment = work.beyond[j] * S;
    const Force turned = work.beyond[j] * r + cross_force(S, forces[j]);
    const int column = at.motors[j];
    double *found = work.sides.data();
    add(turned, at.slopes[j], found + column, m);
    for (int i = j; i >= 0; i = robot.parents[i]) {
      const Motion &T = work.placed[i].axis;
      const double both = at.slopes[i] * at.slopes[j];
      found[(BASE + at.motors[i]) * m + column] += both * dot(T, turned);
      if (i == j) continue;
      const Motion turn = cross_motion(before(at, jump, acceleration, i), T);
      found[(BASE + column) * m + at.motors[i]] += both * dot(moment, turn);
    }
  }
  for (int j = robot.foot; j >= 0; j = robot.parents[j]) {
    const Motion moved = cross_motion(before(at, result, velocity, j), work.placed[j].axis);
    add(seen_from(sole, moved), at.slopes[j], &work.sides[nv * m + at.motors[j]], m);
  }
}

GAITOPT_ANY_PROCESSOR
void one_impact(const Landing &at, const ImpactMotion &motion, Work &work,
                const ImpactTables &found) {
  const int m = at.free, nv = at.speeds(), size = at.size();
  Sole sole;
  assemble(at, motion.angles, work, found.axes, sole, found.kkt);
  const VectorOf<One> rows[4] = {sole.rotation.x, sole.rotation.y, sole.rotation.z, sole.origin};
  for (int k = 0; k < 4; ++k) {
    found.frame[3 * k] = rows[k].x;
    found.frame[3 * k + 1] = rows[k].y;
    found.frame[3 * k + 2] = rows[k].z;
  }
  double *inverse = found.inverse;
  std::copy(found.kkt, found.kkt + size * size, inverse);
  invert(inverse, size, work.pivots.data());
  // (V+ - V-, I, w) solves the system with (0, -J V-, 0) on the right. One step of refinement: the
  // derivatives of R below are as good as R vanishes.
  std::vector<double> jump(size), right(size);
  for (int step = 0; step < 2; ++step) {
    std::fill(right.begin(), right.end(), 0.0);
    subtract_product({work.J.data(), nv}, {motion.before, 1}, BASE, nv, 1, {&right[nv], 1});
    subtract_product({found.kkt, size}, {jump.data(), 1}, size, size, 1, {right.data(), 1});
    for (double &entry : right) entry = -entry;
    subtract_product({inverse, size}, {right.data(), 1}, size, size, 1, {jump.data(), 1});
  }
  std::copy(jump.begin(), jump.end(), found.result);
  for (int j = 0; j < nv; ++j) found.result[j] += motion.before[j];
  if (found.inputs == nullptr) return;

  by_posture(at, sole, jump.data(), found.axes, found.result, work);
  const int width = at.inputs(motion.moving);
  std::fill(found.inputs, found.inputs + size * width, 0.0);
  for (int j = motion.moving ? 0 : BASE; j < nv; ++j)
    found.inputs[j * width + (j < BASE ? 2 * m + j : m + j - BASE)] = 1.0;
  subtract_product({inverse, size}, {work.sides.data(), m}, size, nv + BASE, m, {found.inputs, width});
  subtract_product({inverse + nv, size}, {work.J.data() + BASE, nv}, size, BASE, m,
                   {found.inputs + m, width});
  subtract_product({inverse + nv, size}, {work.J.data(), nv}, size, BASE, width - 2 * m,
                   {found.inputs + 2 * m, width});
}

GAITOPT_ANY_PROCESSOR
void one_hessian(const Landing &at, const WeightedImpact &given, double *found) {
  const Bodies &robot = at.robot;
  const int n = robot.count, m = at.free, nv = at.speeds(), size = at.size();
  const Sole sole = {constant_matrix<One>(given.frame), constant<One>(given.frame + 9)};
  const Force push = in_world(sole, pair_at(given.adjoint + nv));
  const Force impulse = in_world(sole, pair_at(given.impulse));
  std::vector<Motion> velocity(n), weight(n);
  add_up(at, given.velocity, given.axes, velocity.data());
  add_up(at, given.adjoint, given.axes, weight.data());
  // of l . (R, J V+) in the posture, in that and (V+, I, w), in that and the jump
  std::vector<double> twice(m * m), by_result(m * size), by_jump(m * nv);
  for (int i = 0; i < n; ++i) {
    const int row = at.motors[i];
    double *jumped = &by_jump[row * nv];
    for (int b = 0; b < BASE; ++b) jumped[b] += at.slopes[i] * given.base[i * BASE + b];
    for (int j = 0; j < n; ++j) {
      const double both = at.slopes[i] * at.slopes[j];
      jumped[BASE + at.motors[j]] += both * given.qa[i * n + j];
      twice[row * m + at.motors[j]] += both * given.qq[i * n + j];
    }
  }
  for (int j = robot.foot; j >= 0; j = robot.parents[j]) {
    const Motion S = pair_at(given.axes + 6 * j);
    const Force pushed = cross_force(S, push), struck = cross_force(S, impulse);
    const int column = at.motors[j];
    double *own = &by_result[column * size];
    add(pushed, at.slopes[j], own, 1);
    const Motion moved = cross_motion(before(at, given.adjoint, weight.data(), j), S);
    add(seen_from(sole, moved), -at.slopes[j], own + nv, 1);
    for (int i = j; i >= 0; i = robot.parents[i]) {
      const Motion T = pair_at(given.axes + 6 * i);
      const double both = at.slopes[i] * at.slopes[j];
      const double bent =
          dot(pushed, cross_motion(before(at, given.velocity, velocity.data(), i), T)) -
          dot(struck, cross_motion(before(at, given.adjoint, weight.data(), i), T));
      twice[at.motors[i] * m + column] += both * bent;
      if (i == j) continue;
      twice[column * m + at.motors[i]] += both * bent;
      own[BASE + at.motors[i]] += both * dot(pushed, T);
    }
  }
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < nv; ++j) by_result[i * size + j] += by_jump[i * nv + j];
  const int width = at.inputs(given.moving);
  std::vector<double> less(m * width);  // minus what the posture and all inputs have together
  subtract_product({by_result.data(), size}, {given.inputs, width}, m, size, width,
                   {less.data(), width});
  std::fill(found, found + width * width, 0.0);
  for (int i = 0; i < m; ++i) {
    double *mixed = &less[i * width];
    // the jump V+ - V- sees minus what was before
    for (int j = 0; j < m; ++j) mixed[m + j] += by_jump[i * nv + BASE + j];
    for (int b = 0; b < BASE && given.moving; ++b) mixed[2 * m + b] += by_jump[i * nv + b];
    for (int j = 0; j < m; ++j) found[i * width + j] += twice[i * m + j];
    for (int j = 0; j < width; ++j) {
      found[i * width + j] -= mixed[j];
      found[j * width + i] -= mixed[j];
    }
  }
}

}  // namespace

void impact(const Landing &at, const ImpactMotion &motion, const ImpactTables &found) {
  Work work(at);
  one_impact(at, motion, work, found);
}

void impact_hessian(const Landing &at, const WeightedImpact &given, double *hessian) {
  one_hessian(at, given, hessian);
}

}  // namespace gaitopt
