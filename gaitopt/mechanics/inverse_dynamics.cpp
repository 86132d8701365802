// Inverse dynamics of all instants and its derivatives, as single_support.py has them of Pinocchio.
//
// With S the joints' axes in the world, v and a the motion of the body that a joint sits on, and
//
//     p_j = v x S_j        r_j = a x S_j + v x p_j
//
// I, 2 B and f the inertia, Coriolis matrix and force of all bodies beyond a joint, torque i changes
// with joint j that is i or beyond it by
//
//     d / dq_j = S_i . (2 B_j p_j + I_j r_j + S_j x* f_j)
//     d / dv_j = S_i . (2 B_j S_j + 2 I_j p_j)        d / da_j = S_i . I_j S_j
//
// and with joint j before it by S_i . (2 B_i p_j + I_i r_j) and so on: what turns S_i turns f_i too
// (Singh, Russell and Wensing, Efficient analytical derivatives of rigid-body dynamics using
// spatial vector algebra, RA-L 7(2), 2022). The wrench on the foot is the force beyond all.
#include "kernels.hpp"

namespace gaitopt {
namespace {

// Composites of the bodies, whose motion is already that of `moving`.
GAITOPT_INLINE void gather(const Bodies &robot, const Body *placed, const Moving *moving,
                           Composite *beyond) {
  for (int j = 0; j < robot.count; ++j) {
    const Inertia &I = placed[j].inertia;
    const Pair momentum = I * moving[j].velocity;
    beyond[j] = {I, coriolis(I, moving[j].velocity, momentum),
                 I * moving[j].acceleration + cross_force(moving[j].velocity, momentum)};
  }
  for (int j = robot.count - 1; j >= 0; --j) {
    const int parent = robot.parents[j];
    if (parent < 0) continue;
    Composite &outer = beyond[parent];
    outer.inertia = outer.inertia + beyond[j].inertia;
    outer.coriolis = outer.coriolis + beyond[j].coriolis;
    outer.force += beyond[j].force;
  }
}

GAITOPT_ANY_PROCESSOR
void four_instants(const Bodies &robot, const Motions &motion, std::ptrdiff_t first, Body *placed,
                   Moving *moving, Composite *beyond, Pair *turned, const SupportTables &found) {
  const int n = robot.count;
  const Instants here(first, motion.count);
  const Pair rest = {all(-1.0) * constant(robot.gravity.data()), nothing()};
  place(robot, motion.q, here, placed);
  for (int j = 0; j < n; ++j) {
    const int parent = robot.parents[j];
    const Pair &S = placed[j].axis;
    const Pair v = parent < 0 ? no_pair() : moving[parent].velocity;
    const Pair a = parent < 0 ? rest : moving[parent].acceleration;
    const Lane dq = here.load(motion.dq, n, j), ddq = here.load(motion.ddq, n, j);
    turned[2 * j] = cross_motion(v, S);
    turned[2 * j + 1] = cross_motion(a, S) + cross_motion(v, turned[2 * j]);
    moving[j] = {v + dq * S, a + ddq * S + dq * turned[2 * j]};
  }
  gather(robot, placed, moving, beyond);

  Pair wrench = inertia_at(robot.inertias.data(), identity(), nothing()) * rest;
  for (int j = 0; j < n; ++j) {
    if (robot.parents[j] < 0) wrench += beyond[j].force;
    const Lane rotor = all(robot.armature[j]) * here.load(motion.ddq, n, j);
    here.store(found.effort, 6 + n, 6 + j, dot(placed[j].axis, beyond[j].force) + rotor);
  }
  store_pair(here, found.effort, 6 + n, 0, 1, wrench);
  const Body &last = placed[robot.foot];
  const Vector rows[4] = {last.rotation.x, last.rotation.y, last.rotation.z, last.origin};
  for (int k = 0; k < 4; ++k) {
    here.store(found.foot_frame, 12, 3 * k, rows[k].x);
    here.store(found.foot_frame, 12, 3 * k + 1, rows[k].y);
    here.store(found.foot_frame, 12, 3 * k + 2, rows[k].z);
  }
  if (found.jacobian == nullptr) return;

  const std::ptrdiff_t columns = 3 * n, width = (6 + n) * columns;
  for (int j = 0; j < n; ++j) {
    const Pair &S = placed[j].axis, &p = turned[2 * j], &r = turned[2 * j + 1];
    const Composite &C = beyond[j];
    const Pair moment = C.inertia * S;
    const Pair by_q = C.coriolis * p + C.inertia * r + cross_force(S, C.force);
    const Pair by_v = C.coriolis * S + all(2.0) * (C.inertia * p);
    store_pair(here, found.jacobian, width, j, columns, by_q);
    store_pair(here, found.jacobian, width, n + j, columns, by_v);
    store_pair(here, found.jacobian, width, 2 * n + j, columns, moment);
    store_pair(here, found.axes, 6 * n, 6 * j, 1, S);
    const Vector bent = transposed(C.coriolis, S);
    double *own = found.jacobian + 6 * columns;  // rows of the torques
    for (int i = j; i >= 0; i = robot.parents[i]) {
      const Pair &T = placed[i].axis;
      const Lane inertia = dot(T, moment);
      here.store(own, width, i * columns + j, dot(T, by_q));
      here.store(own, width, i * columns + n + j, dot(T, by_v));
      if (i == j) {
        here.store(own, width, i * columns + 2 * n + j, inertia + all(robot.armature[j]));
        continue;
      }
      const Pair &pi = turned[2 * i], &ri = turned[2 * i + 1];
      here.store(own, width, j * columns + i, dot(bent, pi.angular) + dot(moment, ri));
      here.store(own, width, j * columns + n + i, dot(bent, T.angular) + all(2.0) * dot(moment, pi));
      here.store(own, width, i * columns + 2 * n + j, inertia);
      here.store(own, width, j * columns + 2 * n + i, inertia);
    }
  }
}

}  // namespace

void inverse_dynamics(const Bodies &robot, const Motions &motion, const SupportTables &found) {
  if (found.jacobian != nullptr && !robot.serial) {  // joints that move no body in common
    const std::ptrdiff_t size = motion.count * (6 + robot.count) * 3 * robot.count;
    std::fill(found.jacobian, found.jacobian + size, 0.0);
  }
  std::vector<Body> placed(robot.count);
  std::vector<Moving> moving(robot.count);
  std::vector<Composite> beyond(robot.count);
  std::vector<Pair> turned(2 * robot.count);
  for (std::ptrdiff_t first = 0; first < motion.count; first += LANES)
    four_instants(robot, motion, first, placed.data(), moving.data(), beyond.data(),
                  turned.data(), found);
}

}  // namespace gaitopt
