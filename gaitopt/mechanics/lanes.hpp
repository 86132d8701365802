// Spatial algebra for four instants at a time.
//
// A walk's instants need the same arithmetic, so that a number here is a lane: the four values that
// it has at four instants, which the processor adds and multiplies together. What is written with
// lanes reads as if it were for one instant.
//
// Motions and forces are about the world origin, linear part first, as in spatial.py.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

// One version for any processor and one for those of the last ten years, chosen as the library is
// loaded. Neither fuses products with sums (setup.py), so that both give the same numbers.
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

struct Vector {
  Lane x, y, z;
};

GAITOPT_INLINE Vector operator+(const Vector &a, const Vector &b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
GAITOPT_INLINE Vector operator-(const Vector &a, const Vector &b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
GAITOPT_INLINE Vector operator*(Lane s, const Vector &a) { return {s * a.x, s * a.y, s * a.z}; }
GAITOPT_INLINE Vector &operator+=(Vector &a, const Vector &b) { return a = a + b; }
GAITOPT_INLINE Lane dot(const Vector &a, const Vector &b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
GAITOPT_INLINE Vector cross(const Vector &a, const Vector &b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
GAITOPT_INLINE Vector constant(const double *xyz) { return {all(xyz[0]), all(xyz[1]), all(xyz[2])}; }
GAITOPT_INLINE Vector nothing() { return {all(0.0), all(0.0), all(0.0)}; }

// A matrix by its rows.
struct Matrix {
  Vector x, y, z;
};

GAITOPT_INLINE Vector operator*(const Matrix &A, const Vector &v) {
  return {dot(A.x, v), dot(A.y, v), dot(A.z, v)};
}
GAITOPT_INLINE Matrix operator+(const Matrix &A, const Matrix &B) {
  return {A.x + B.x, A.y + B.y, A.z + B.z};
}
// A' v
GAITOPT_INLINE Vector transposed(const Matrix &A, const Vector &v) {
  return v.x * A.x + v.y * A.y + v.z * A.z;
}
// u A, row after row
GAITOPT_INLINE Matrix operator*(const Matrix &A, const Matrix &B) {
  return {transposed(B, A.x), transposed(B, A.y), transposed(B, A.z)};
}
GAITOPT_INLINE Matrix constant_matrix(const double *rows) {
  return {constant(rows), constant(rows + 3), constant(rows + 6)};
}
GAITOPT_INLINE Matrix identity() {
  const Lane zero = all(0.0), one = all(1.0);
  return {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}};
}

// A symmetric matrix.
struct Symmetric {
  Lane xx, xy, xz, yy, yz, zz;
};

GAITOPT_INLINE Symmetric operator+(const Symmetric &A, const Symmetric &B) {
  return {A.xx + B.xx, A.xy + B.xy, A.xz + B.xz, A.yy + B.yy, A.yz + B.yz, A.zz + B.zz};
}
GAITOPT_INLINE Vector operator*(const Symmetric &A, const Vector &v) {
  return {A.xx * v.x + A.xy * v.y + A.xz * v.z, A.xy * v.x + A.yy * v.y + A.yz * v.z,
          A.xz * v.x + A.yz * v.y + A.zz * v.z};
}

// A motion or a force.
struct Pair {
  Vector linear, angular;
};

GAITOPT_INLINE Pair operator+(const Pair &a, const Pair &b) {
  return {a.linear + b.linear, a.angular + b.angular};
}
GAITOPT_INLINE Pair operator-(const Pair &a, const Pair &b) {
  return {a.linear - b.linear, a.angular - b.angular};
}
GAITOPT_INLINE Pair operator*(Lane s, const Pair &a) { return {s * a.linear, s * a.angular}; }
GAITOPT_INLINE Pair &operator+=(Pair &a, const Pair &b) { return a = a + b; }
GAITOPT_INLINE Lane dot(const Pair &a, const Pair &b) {
  return dot(a.linear, b.linear) + dot(a.angular, b.angular);
}
// v x y of motions
GAITOPT_INLINE Pair cross_motion(const Pair &v, const Pair &y) {
  return {cross(v.angular, y.linear) + cross(v.linear, y.angular), cross(v.angular, y.angular)};
}
// v x* f of a motion and a force
GAITOPT_INLINE Pair cross_force(const Pair &v, const Pair &f) {
  return {cross(v.angular, f.linear), cross(v.angular, f.angular) + cross(v.linear, f.linear)};
}
GAITOPT_INLINE Pair no_pair() { return {nothing(), nothing()}; }

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
struct Inertia {
  Lane mass;
  Vector moment;
  Symmetric second;
};

GAITOPT_INLINE Inertia operator+(const Inertia &a, const Inertia &b) {
  return {a.mass + b.mass, a.moment + b.moment, a.second + b.second};
}
// Momentum along a motion.
GAITOPT_INLINE Pair operator*(const Inertia &I, const Pair &v) {
  return {I.mass * v.linear - cross(I.moment, v.angular),
          cross(I.moment, v.linear) + I.second * v.angular};
}

// 2 B of Featherstone's Coriolis matrix B along a velocity, with 2 B y = -I (v x y) + y x* (I v) +
// v x* (I y). It leaves the linear part of y out: above there is -2 f x, f the linear momentum.
struct Coriolis {
  Vector momentum;
  Matrix below;
};

GAITOPT_INLINE Coriolis operator+(const Coriolis &a, const Coriolis &b) {
  return {a.momentum + b.momentum, a.below + b.below};
}
GAITOPT_INLINE Pair operator*(const Coriolis &B, const Pair &y) {
  return {all(-2.0) * cross(B.momentum, y.angular), B.below * y.angular};
}
// 2 B' y, whose linear part is 0.
GAITOPT_INLINE Vector transposed(const Coriolis &B, const Pair &y) {
  return all(2.0) * cross(B.momentum, y.linear) + transposed(B.below, y.angular);
}
GAITOPT_INLINE Coriolis coriolis(const Inertia &I, const Pair &v, const Pair &momentum) {
  // -[h][v] - [v][h] + X + X' - [l], X = [w] J; [a][b] = b a' - (a . b) 1
  const Vector &h = I.moment, &u = v.linear, &w = v.angular, &l = momentum.angular;
  const Symmetric &J = I.second;
  const Vector columns[3] = {
      cross(w, {J.xx, J.xy, J.xz}), cross(w, {J.xy, J.yy, J.yz}), cross(w, {J.xz, J.yz, J.zz})};
  const Lane twice = all(2.0) * dot(h, u);
  const Lane xx = twice + all(2.0) * (columns[0].x - h.x * u.x);
  const Lane yy = twice + all(2.0) * (columns[1].y - h.y * u.y);
  const Lane zz = twice + all(2.0) * (columns[2].z - h.z * u.z);
  const Lane xy = columns[1].x + columns[0].y - h.x * u.y - h.y * u.x;
  const Lane xz = columns[2].x + columns[0].z - h.x * u.z - h.z * u.x;
  const Lane yz = columns[2].y + columns[1].z - h.y * u.z - h.z * u.y;
  return {momentum.linear,
          {{xx, xy + l.z, xz - l.y}, {xy - l.z, yy, yz + l.x}, {xz + l.y, yz - l.x, zz}}};
}

}  // namespace gaitopt
