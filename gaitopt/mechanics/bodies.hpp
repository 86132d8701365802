// The bodies of a robot that is rooted at its stance foot, and where they are.
#pragma once

#include <vector>

#include "lanes.hpp"

namespace gaitopt {

// Facts of the n joints and of the body that each of them moves, and the weight of the stance foot.
struct Bodies {
  int count = 0;                  // n
  bool serial = true;             // whether it is one chain
  int foot = 0;                   // number of the joint that moves the swing foot
  std::vector<int> parents;       // of each joint, the one that carries it; -1 the stance foot
  std::vector<double> placements; // of the joints in their parents' frames: axes, origin (n, 12)
  std::vector<double> axes;       // of the joints in their frames (n, 3)
  std::vector<double> inertias;   // mass, centre, inertia about it by rows (n + 1, 13), foot first
  std::vector<double> frames;     // of pelvis and swing sole in those of their joints (2, 12)
  std::vector<double> armature;   // reflected inertias of the rotors [kg m2] (n)
  std::array<double, 3> gravity;  // in the axes of the stance foot [m/s2]
};

// A joint, with the body that it moves, in the world.
template <class N>
struct PlacedOf {
  MatrixOf<N> rotation;
  VectorOf<N> origin;
  PairOf<N> axis;
};

// A body, in the world.
template <class N>
struct BodyOf : PlacedOf<N> {
  InertiaOf<N> inertia;
};
using Body = BodyOf<Four>;

template <class N>
GAITOPT_INLINE InertiaOf<N> inertia_at(const double *facts, const MatrixOf<N> &R,
                                       const VectorOf<N> &origin) {
  const Number<N> mass = N::all(facts[0]);
  const VectorOf<N> c = R * constant<N>(facts + 1) + origin, h = mass * c;
  const MatrixOf<N> I = R * constant_matrix<N>(facts + 4);  // R I_c, and what follows R I_c R'
  const Number<N> square = dot(h, c);
  return {mass, h,
          {dot(I.x, R.x) + square - h.x * c.x, dot(I.x, R.y) - h.x * c.y, dot(I.x, R.z) - h.x * c.z,
           dot(I.y, R.y) + square - h.y * c.y, dot(I.y, R.z) - h.y * c.z,
           dot(I.z, R.z) + square - h.z * c.z}};
}

// Turn by an angle about a unit axis: Rodrigues' formula, 1 + sin [k] + (1 - cos) [k] [k].
template <class N>
GAITOPT_INLINE MatrixOf<N> turn(const VectorOf<N> &k, Number<N> angle) {
  const Number<N> cos = cosine(angle);
  const VectorOf<N> c = (N::all(1.0) - cos) * k, s = sine(angle) * k;
  return {{cos + c.x * k.x, c.x * k.y - s.z, c.x * k.z + s.y},
          {c.y * k.x + s.z, cos + c.y * k.y, c.y * k.z - s.x},
          {c.z * k.x - s.y, c.z * k.y + s.x, cos + c.z * k.z}};
}

// Put a joint in place at its angle, where the one that carries it is already.
template <class N, class Placed>
GAITOPT_INLINE void place_joint(const Bodies &robot, int joint, Number<N> angle, Placed *placed) {
  const int parent = robot.parents[joint];
  const double *at = &robot.placements[12 * joint];
  const VectorOf<N> k = constant<N>(&robot.axes[3 * joint]);
  MatrixOf<N> frame = constant_matrix<N>(at);
  VectorOf<N> origin = constant<N>(at + 9);
  if (parent >= 0) {
    origin = placed[parent].rotation * origin + placed[parent].origin;
    frame = placed[parent].rotation * frame;
  }
  const VectorOf<N> axis = frame * k;
  Placed &own = placed[joint];
  own.rotation = frame * turn<N>(k, angle);
  own.origin = origin;
  own.axis = {cross(origin, axis), axis};
}

// Put the bodies in place, joint after joint outwards; angles (N, n), placed: n of them.
GAITOPT_INLINE void place(const Bodies &robot, const double *angles, const Instants &here,
                          Body *placed) {
  for (int j = 0; j < robot.count; ++j) {
    Body &own = placed[j];
    place_joint<Four>(robot, j, here.load(angles, robot.count, j), placed);
    own.inertia = inertia_at(&robot.inertias[13 * (j + 1)], own.rotation, own.origin);
  }
}

// What all bodies beyond a joint have together.
struct Composite {
  Inertia inertia;
  Coriolis coriolis;
  Pair force;
};

// Twist and acceleration of a body, that of the stance foot's included.
struct Moving {
  Pair velocity, acceleration;
};

}  // namespace gaitopt
