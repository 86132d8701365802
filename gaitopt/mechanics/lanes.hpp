// Spatial algebra for four instants at a time, or for one.
//
// A walk's instants need the same arithmetic, so that a number here is a lane: the four values that
// it has at four instants, which the processor adds and multiplies together. What is written with
// lanes reads as if it were for one instant; for what has a single one numbers are doubles.
//
// Motions and forces are about the world origin, linear part first, as in spatial.py.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

// One version for any processor and one for those of the last ten years, chosen as the library is
// loaded. Neither fuses products with sums (setup.py), so that both give the same numbers. Sines and
// cosines are those of the C library, whose last digit depends on the processor.
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__)
#define GAITOPT_ANY_PROCESSOR __attribute__((target_clones("avx2", "default")))
#else
#define GAITOPT_ANY_PROCESSOR
#endif
// into either version, and lanes are never handed over between functions
#define GAITOPT_INLINE __attribute__((always_inline)) inline

namespace gaitopt {

constexpr int LANES = 4;
// aligned as the widest processor asks for, whatever the compiler's own is
typedef double Lane __attribute__((vector_size(8 * LANES), aligned(8 * LANES)));

// Which four instants of N are looked at; those after the last one are the last one again.
struct Instants {
  std::array<std::ptrdiff_t, LANES> at;

  GAITOPT_INLINE Instants(std::ptrdiff_t first, std::ptrdiff_t count) {
    for (int lane = 0; lane < LANES; ++lane) at[lane] = std::min(first + lane, count - 1);
  }

  // Entry `column` of the rows of a table (N, width).
  GAITOPT_INLINE Lane load(const double *table, std::ptrdiff_t width, std::ptrdiff_t column) const {
    Lane found;
    for (int lane = 0; lane < LANES; ++lane) found[lane] = table[at[lane] * width + column];
    return found;
  }

  GAITOPT_INLINE void store(double *table, std::ptrdiff_t width, std::ptrdiff_t column,
                            Lane value) const {
    for (int lane = 0; lane < LANES; ++lane) table[at[lane] * width + column] = value[lane];
  }
};

GAITOPT_INLINE Lane all(double value) { return Lane{value, value, value, value}; }
GAITOPT_INLINE Lane sine(Lane angle) {
  for (int lane = 0; lane < LANES; ++lane) angle[lane] = std::sin(angle[lane]);
  return angle;
}
GAITOPT_INLINE double sine(double angle) { return std::sin(angle); }
GAITOPT_INLINE Lane cosine(Lane angle) {
  for (int lane = 0; lane < LANES; ++lane) angle[lane] = std::cos(angle[lane]);
  return angle;
}
GAITOPT_INLINE double cosine(double angle) { return std::cos(angle); }

// Of how many instants a number is: N of what follows.
struct Four {
  using Number = Lane;
  static GAITOPT_INLINE Lane all(double value) { return gaitopt::all(value); }
};
struct One {
  using Number = double;
  static GAITOPT_INLINE double all(double value) { return value; }
};
template <class N>
using Number = typename N::Number;

template <class N>
struct VectorOf {
  Number<N> x, y, z;
};
using Vector = VectorOf<Four>;

template <class N>
GAITOPT_INLINE VectorOf<N> operator+(const VectorOf<N> &a, const VectorOf<N> &b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class N>
GAITOPT_INLINE VectorOf<N> operator-(const VectorOf<N> &a, const VectorOf<N> &b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class N>
GAITOPT_INLINE VectorOf<N> operator*(Number<N> s, const VectorOf<N> &a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class N>
GAITOPT_INLINE VectorOf<N> &operator+=(VectorOf<N> &a, const VectorOf<N> &b) { return a = a + b; }
template <class N>
GAITOPT_INLINE Number<N> dot(const VectorOf<N> &a, const VectorOf<N> &b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class N>
GAITOPT_INLINE VectorOf<N> cross(const VectorOf<N> &a, const VectorOf<N> &b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class N = Four>
GAITOPT_INLINE VectorOf<N> constant(const double *xyz) {
  return {N::all(xyz[0]), N::all(xyz[1]), N::all(xyz[2])};
}
template <class N = Four>
GAITOPT_INLINE VectorOf<N> nothing() {
  return {N::all(0.0), N::all(0.0), N::all(0.0)};
}

// A matrix by its rows.
template <class N>
struct MatrixOf {
  VectorOf<N> x, y, z;
};
using Matrix = MatrixOf<Four>;

template <class N>
GAITOPT_INLINE VectorOf<N> operator*(const MatrixOf<N> &A, const VectorOf<N> &v) {
  return {dot(A.x, v), dot(A.y, v), dot(A.z, v)};
}
template <class N>
GAITOPT_INLINE MatrixOf<N> operator+(const MatrixOf<N> &A, const MatrixOf<N> &B) {
  return {A.x + B.x, A.y + B.y, A.z + B.z};
}
// A' v
template <class N>
GAITOPT_INLINE VectorOf<N> transposed(const MatrixOf<N> &A, const VectorOf<N> &v) {
  return v.x * A.x + v.y * A.y + v.z * A.z;
}
// A B, row after row
template <class N>
GAITOPT_INLINE MatrixOf<N> operator*(const MatrixOf<N> &A, const MatrixOf<N> &B) {
  return {transposed(B, A.x), transposed(B, A.y), transposed(B, A.z)};
}
template <class N = Four>
GAITOPT_INLINE MatrixOf<N> constant_matrix(const double *rows) {
  return {constant<N>(rows), constant<N>(rows + 3), constant<N>(rows + 6)};
}
template <class N = Four>
GAITOPT_INLINE MatrixOf<N> identity() {
  const Number<N> zero = N::all(0.0), one = N::all(1.0);
  return {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}};
}

// A symmetric matrix.
template <class N>
struct SymmetricOf {
  Number<N> xx, xy, xz, yy, yz, zz;
};
using Symmetric = SymmetricOf<Four>;

template <class N>
GAITOPT_INLINE SymmetricOf<N> operator+(const SymmetricOf<N> &A, const SymmetricOf<N> &B) {
  return {A.xx + B.xx, A.xy + B.xy, A.xz + B.xz, A.yy + B.yy, A.yz + B.yz, A.zz + B.zz};
}
template <class N>
GAITOPT_INLINE VectorOf<N> operator*(const SymmetricOf<N> &A, const VectorOf<N> &v) {
  return {A.xx * v.x + A.xy * v.y + A.xz * v.z, A.xy * v.x + A.yy * v.y + A.yz * v.z,
          A.xz * v.x + A.yz * v.y + A.zz * v.z};
}

// A motion or a force.
template <class N>
struct PairOf {
  VectorOf<N> linear, angular;
};
using Pair = PairOf<Four>;

template <class N>
GAITOPT_INLINE PairOf<N> operator+(const PairOf<N> &a, const PairOf<N> &b) {
  return {a.linear + b.linear, a.angular + b.angular};
}
template <class N>
GAITOPT_INLINE PairOf<N> operator-(const PairOf<N> &a, const PairOf<N> &b) {
  return {a.linear - b.linear, a.angular - b.angular};
}
template <class N>
GAITOPT_INLINE PairOf<N> operator*(Number<N> s, const PairOf<N> &a) {
  return {s * a.linear, s * a.angular};
}
template <class N>
GAITOPT_INLINE PairOf<N> &operator+=(PairOf<N> &a, const PairOf<N> &b) { return a = a + b; }
template <class N>
GAITOPT_INLINE Number<N> dot(const PairOf<N> &a, const PairOf<N> &b) {
  return dot(a.linear, b.linear) + dot(a.angular, b.angular);
}
// v x y of motions
template <class N>
GAITOPT_INLINE PairOf<N> cross_motion(const PairOf<N> &v, const PairOf<N> &y) {
  return {cross(v.angular, y.linear) + cross(v.linear, y.angular), cross(v.angular, y.angular)};
}
// v x* f of a motion and a force
template <class N>
GAITOPT_INLINE PairOf<N> cross_force(const PairOf<N> &v, const PairOf<N> &f) {
  return {cross(v.angular, f.linear), cross(v.angular, f.angular) + cross(v.linear, f.linear)};
}
template <class N = Four>
GAITOPT_INLINE PairOf<N> no_pair() {
  return {nothing<N>(), nothing<N>()};
}

GAITOPT_INLINE PairOf<One> pair_at(const double *six) {
  return {constant<One>(six), constant<One>(six + 3)};
}
GAITOPT_INLINE Pair load_pair(const Instants &here, const double *table, std::ptrdiff_t width,
                              std::ptrdiff_t first) {
  Lane six[6];
  for (int i = 0; i < 6; ++i) six[i] = here.load(table, width, first + i);
  return {{six[0], six[1], six[2]}, {six[3], six[4], six[5]}};
}
GAITOPT_INLINE void store_pair(const Instants &here, double *table, std::ptrdiff_t width,
                               std::ptrdiff_t first, std::ptrdiff_t apart, const Pair &value) {
  const Lane six[6] = {value.linear.x,  value.linear.y,  value.linear.z,
                       value.angular.x, value.angular.y, value.angular.z};
  for (int i = 0; i < 6; ++i) here.store(table, width, first + i * apart, six[i]);
}

// Inertia of bodies about the world origin: mass, mass times centre, second moments.
template <class N>
struct InertiaOf {
  Number<N> mass;
  VectorOf<N> moment;
  SymmetricOf<N> second;
};
using Inertia = InertiaOf<Four>;

template <class N>
GAITOPT_INLINE InertiaOf<N> operator+(const InertiaOf<N> &a, const InertiaOf<N> &b) {
  return {a.mass + b.mass, a.moment + b.moment, a.second + b.second};
}
// Momentum along a motion.
template <class N>
GAITOPT_INLINE PairOf<N> operator*(const InertiaOf<N> &I, const PairOf<N> &v) {
  return {I.mass * v.linear - cross(I.moment, v.angular),
          cross(I.moment, v.linear) + I.second * v.angular};
}

// 2 B of Featherstone's Coriolis matrix B along a velocity, with 2 B y = -I (v x y) + y x* (I v) +
// v x* (I y). It leaves the linear part of y out: above there is -2 f x, f the linear momentum.
template <class N>
struct CoriolisOf {
  VectorOf<N> momentum;
  MatrixOf<N> below;
};
using Coriolis = CoriolisOf<Four>;

template <class N>
GAITOPT_INLINE CoriolisOf<N> operator+(const CoriolisOf<N> &a, const CoriolisOf<N> &b) {
  return {a.momentum + b.momentum, a.below + b.below};
}
template <class N>
GAITOPT_INLINE PairOf<N> operator*(const CoriolisOf<N> &B, const PairOf<N> &y) {
  return {N::all(-2.0) * cross(B.momentum, y.angular), B.below * y.angular};
}
// 2 B' y, whose linear part is 0.
template <class N>
GAITOPT_INLINE VectorOf<N> transposed(const CoriolisOf<N> &B, const PairOf<N> &y) {
  return N::all(2.0) * cross(B.momentum, y.linear) + transposed(B.below, y.angular);
}
// Change of the second moments along a motion, X + X' of X = [w] J - [h] [u].
template <class N>
GAITOPT_INLINE SymmetricOf<N> drift(const InertiaOf<N> &I, const PairOf<N> &v) {
  // [a][b] = b a' - (a . b) 1
  const VectorOf<N> &h = I.moment, &u = v.linear, &w = v.angular;
  const SymmetricOf<N> &J = I.second;
  const VectorOf<N> columns[3] = {
      cross(w, {J.xx, J.xy, J.xz}), cross(w, {J.xy, J.yy, J.yz}), cross(w, {J.xz, J.yz, J.zz})};
  const Number<N> twice = N::all(2.0) * dot(h, u);
  return {twice + N::all(2.0) * (columns[0].x - h.x * u.x),
          columns[1].x + columns[0].y - h.x * u.y - h.y * u.x,
          columns[2].x + columns[0].z - h.x * u.z - h.z * u.x,
          twice + N::all(2.0) * (columns[1].y - h.y * u.y),
          columns[2].y + columns[1].z - h.y * u.z - h.z * u.y,
          twice + N::all(2.0) * (columns[2].z - h.z * u.z)};
}
template <class N>
GAITOPT_INLINE CoriolisOf<N> coriolis(const InertiaOf<N> &I, const PairOf<N> &v,
                                     const PairOf<N> &momentum) {
  const SymmetricOf<N> D = drift(I, v);  // less [l]
  const VectorOf<N> &l = momentum.angular;
  return {momentum.linear,
          {{D.xx, D.xy + l.z, D.xz - l.y}, {D.xy - l.z, D.yy, D.yz + l.x},
           {D.xz + l.y, D.yz - l.x, D.zz}}};
}

}  // namespace gaitopt
