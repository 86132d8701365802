// The bodies of a robot that is rooted at its stance foot, and where they are at four instants.
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
  std::vector<double> placements; // of each joint's frame in that of its parent: axes, origin (n, 12)
  std::vector<double> axes;       // of the joints in their frames (n, 3)
  std::vector<double> inertias;   // mass, centre, inertia about it by rows (n + 1, 13), foot first
  std::vector<double> armature;   // reflected inertias of the rotors [kg m2] (n)
  std::array<double, 3> gravity;  // in the axes of the stance foot [m/s2]
};

// A body at four instants, in the world.
struct Body {
  Matrix rotation;
  Vector origin;
  Pair axis;  // of the joint that moves it
  Inertia inertia;
};

GAITOPT_INLINE Inertia inertia_at(const double *facts, const Matrix &R, const Vector &origin) {
  const Lane mass = all(facts[0]);
  const Vector c = R * constant(facts + 1) + origin, h = mass * c;
  const Matrix I = R * constant_matrix(facts + 4);  // R I_c, and what follows R I_c R'
  const Lane square = dot(h, c);
  return {mass, h,
          {dot(I.x, R.x) + square - h.x * c.x, dot(I.x, R.y) - h.x * c.y, dot(I.x, R.z) - h.x * c.z,
           dot(I.y, R.y) + square - h.y * c.y, dot(I.y, R.z) - h.y * c.z,
           dot(I.z, R.z) + square - h.z * c.z}};
}

// Put the bodies in place, joint after joint outwards; angles (N, n), placed: n of them.
GAITOPT_INLINE void place(const Bodies &robot, const double *angles, const Instants &here,
                          Body *placed) {
  for (int j = 0; j < robot.count; ++j) {
    const int parent = robot.parents[j];
    const double *at = &robot.placements[12 * j], *axis = &robot.axes[3 * j];
    Matrix frame = constant_matrix(at);
    Vector origin = constant(at + 9);
    if (parent >= 0) {
      origin = placed[parent].rotation * origin + placed[parent].origin;
      frame = placed[parent].rotation * frame;
    }
    Lane sine, cosine;
    const Lane angle = here.load(angles, robot.count, j);
    for (int lane = 0; lane < LANES; ++lane) {
      sine[lane] = std::sin(angle[lane]);
      cosine[lane] = std::cos(angle[lane]);
    }
    // Rodrigues' formula: 1 + sin [k] + (1 - cos) [k] [k]
    const Vector k = constant(axis), c = (all(1.0) - cosine) * k, s = sine * k;
    const Matrix turn = {{cosine + c.x * k.x, c.x * k.y - s.z, c.x * k.z + s.y},
                         {c.y * k.x + s.z, cosine + c.y * k.y, c.y * k.z - s.x},
                         {c.z * k.x - s.y, c.z * k.y + s.x, cosine + c.z * k.z}};
    Body &own = placed[j];
    own.rotation = frame * turn;
    own.origin = origin;
    own.axis.angular = frame * k;
    own.axis.linear = cross(origin, own.axis.angular);
    own.inertia = inertia_at(&robot.inertias[13 * (j + 1)], own.rotation, origin);
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
