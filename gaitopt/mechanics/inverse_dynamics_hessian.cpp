// Second derivatives of lambda . (inverse dynamics) of all instants, as inverse_dynamics_hessian.py
// has them of NumPy. With u, v, a the virtual motion, velocity and acceleration of the body that a
// joint sits on,
//
//     U_j = u x S_j        p_j = v x S_j        r_j = a x S_j + v x p_j
//
// and of all bodies beyond a joint I, 2 B and f as in inverse_dynamics.cpp, Z = (u x)' I + I (u x),
// y = I u and b = (2 B)' u, those of joint k with joint j that is k or before it are
//
//     d2 / dq_j dq_k = U_j . alpha + p_j . beta + r_j . gamma        d2 / dv_j dv_k = S_j . beta'
//     d2 / dq_j dv_k = U_j . alpha' + p_j . beta'    d2 / dv_j dq_k = 2 p_j . gamma + S_j . beta
//     d2 / dq_j da_k = U_j . I_k S_k        d2 / da_j dq_k = S_j . gamma        d2 / da_0 dq_k = gamma
//
//     alpha = S_k x* f_k + I_k r_k + 2 B_k p_k        alpha' = 2 B_k S_k + 2 I_k p_k
//     beta = (2 B_k)' U_k + Z_k p_k + p_k x* y_k + S_k x* b_k        beta' = Z_k S_k + S_k x* y_k
//     gamma = I_k U_k + S_k x* y_k
//
// docs/derivations.md, section 5.1, derives them.
#include "kernels.hpp"

namespace gaitopt {
namespace {

// Motions of the body that a joint carries, and what a turn of the joint makes of those before it.
struct Turning {
  Pair u, v, a;
  Pair U, p, r;
};

// What all bodies beyond a joint have together.
struct Bent {
  Inertia I;
  Coriolis B;       // 2 B
  Symmetric drift;  // below on the right in Z; beside it are products with y's linear part
  Pair y, f;
  Vector b;         // its angular part; the linear one is 0
};

GAITOPT_INLINE Bent operator+(const Bent &a, const Bent &b) {
  return {a.I + b.I, a.B + b.B, a.drift + b.drift, a.y + b.y, a.f + b.f, a.b + b.b};
}

GAITOPT_INLINE Bent own_terms(const Inertia &I, const Turning &at) {
  const Pair momentum = I * at.v;
  const Coriolis B = coriolis(I, at.v, momentum);
  const Pair f = I * at.a + cross_force(at.v, momentum);
  return {I, B, drift(I, all(-1.0) * at.u), I * at.u, f, transposed(B, at.u)};
}

// Z x
GAITOPT_INLINE Pair turned(const Bent &C, const Pair &x) {
  const Vector &l = C.y.linear;
  return {cross(l, x.angular), cross(x.linear, l) + C.drift * x.angular};
}

GAITOPT_ANY_PROCESSOR
void four_instants(const Bodies &robot, const WeightedMotions &given, std::ptrdiff_t first,
                   Body *placed, Turning *turning, Bent *beyond, const HessianTables &found) {
  const int n = robot.count;
  const Motions &motion = given.motion;
  const Instants here(first, motion.count);
  const Pair u_0 = load_pair(here, given.weights, 6 + n, 0);
  const Pair a_0 = load_pair(here, given.base, 6, 0);
  place(robot, motion.q, here, placed);
  for (int j = 0; j < n; ++j) {
    const int parent = robot.parents[j];
    const Pair &S = placed[j].axis;
    const Pair u = parent < 0 ? u_0 : turning[parent].u;
    const Pair v = parent < 0 ? no_pair() : turning[parent].v;
    const Pair a = parent < 0 ? a_0 : turning[parent].a;
    const Lane weight = here.load(given.weights, 6 + n, 6 + j);
    const Lane dq = here.load(motion.dq, n, j), ddq = here.load(motion.ddq, n, j);
    const Pair p = cross_motion(v, S);
    turning[j] = {u + weight * S, v + dq * S, a + ddq * S + dq * p,
                  cross_motion(u, S), p, cross_motion(a, S) + cross_motion(v, p)};
    beyond[j] = own_terms(placed[j].inertia, turning[j]);
  }
  for (int j = n - 1; j >= 0; --j) {
    const int parent = robot.parents[j];
    if (parent >= 0) beyond[parent] = beyond[parent] + beyond[j];
  }

  const std::ptrdiff_t size = n * n;
  for (int k = 0; k < n; ++k) {
    const Bent &C = beyond[k];
    const Pair &S = placed[k].axis, &p = turning[k].p, &U = turning[k].U;
    const Pair IS = C.I * S, Sy = cross_force(S, C.y);
    const Pair alpha = cross_force(S, C.f) + C.I * turning[k].r + C.B * p;
    const Pair alpha_v = C.B * S + all(2.0) * (C.I * p);
    Pair beta = turned(C, p) + cross_force(p, C.y);
    beta.angular += transposed(C.B, U) + cross(S.angular, C.b);
    const Pair beta_v = turned(C, S) + Sy, gamma = C.I * U + Sy;
    store_pair(here, found.base, 6 * n, 6 * k, 1, gamma);
    for (int j = k; j >= 0; j = robot.parents[j]) {
      const std::ptrdiff_t above = j * n + k, below = k * n + j;
      const Pair &T = placed[j].axis;
      const Turning &by = turning[j];
      const Lane qq = dot(by.p, beta) + dot(by.U, alpha) + dot(by.r, gamma);
      const Lane vv = dot(T, beta_v);
      here.store(found.qq, size, above, qq);
      here.store(found.vv, size, above, vv);
      here.store(found.qv, size, above, dot(by.p, beta_v) + dot(by.U, alpha_v));
      here.store(found.qa, size, above, dot(by.U, IS));
      if (j == k) continue;
      here.store(found.qq, size, below, qq);
      here.store(found.vv, size, below, vv);
      here.store(found.qv, size, below, all(2.0) * dot(gamma, by.p) + dot(beta, T));
      here.store(found.qa, size, below, dot(gamma, T));
    }
  }
}

}  // namespace

void inverse_dynamics_hessian(const Bodies &robot, const WeightedMotions &given,
                              const HessianTables &found) {
  const std::ptrdiff_t count = given.motion.count, size = count * robot.count * robot.count;
  if (!robot.serial)  // joints that move no body in common
    for (double *table : {found.qq, found.qv, found.vv, found.qa})
      std::fill(table, table + size, 0.0);
  std::vector<Body> placed(robot.count);
  std::vector<Turning> turning(robot.count);
  std::vector<Bent> beyond(robot.count);
  for (std::ptrdiff_t first = 0; first < count; first += LANES)
    four_instants(robot, given, first, placed.data(), turning.data(), beyond.data(), found);
}

}  // namespace gaitopt
