// What is compiled, and the tables that it reads and writes: numbers row by row, N instants.
#pragma once

#include "bodies.hpp"

namespace gaitopt {

struct Motions {
  std::ptrdiff_t count;          // N
  const double *q, *dq, *ddq;    // (N, n) each
};

struct SupportTables {
  double *effort;      // wrench, then torques (N, 6 + n)
  double *foot_frame;  // of the swing foot: axes by rows, origin (N, 12)
  double *jacobian;    // of the effort in (q, dq, ddq) (N, 6 + n, 3 n); or nothing
  double *axes;        // of the joints (N, n, 6); likewise
};

void inverse_dynamics(const Bodies &robot, const Motions &motion, const SupportTables &found);

// Frames of the stance foot and the n bodies (n + 1, N, 4, 4), at angles (N, n).
void place_bodies(const Bodies &robot, const double *angles, std::ptrdiff_t count, double *frames);

// Segments that bodies carry, and pairs of them.
struct Capsules {
  std::ptrdiff_t count, pairs;
  const long *carriers;        // number of the body of each
  const double *segments;      // where each begins in its frame, and from there to its end (c, 6)
  const long *first, *second;  // their numbers, of each pair
  const double *squares;       // squared lengths of the first and of the second ones (2, pairs)
};

// Nearest points of pairs at N instants, those of each pair side by side: p, q, s, t, begin and
// between of capsule_distance.py (14, pairs N); frames (bodies, N, 4, 4).
void nearest(const Capsules &capsules, const double *frames, std::ptrdiff_t count, double *found);

// How Newton's method searches for a posture.
struct Search {
  int steps;       // at most
  double last;     // a step this small is the last one [rad]
  double largest;  // step of a joint [rad]
};

// A serial chain whose coordinates follow G quantities.
struct Chain {
  std::ptrdiff_t count;        // k
  const double *axes, *rates;  // (k, 6), (k, G)
};

// Displacements of pelvis and swing sole; hips and the swing ankle, which they carry (3, 3).
struct DoubleSupport {
  std::ptrdiff_t size;  // G
  Chain chains[2];
  const double *points;
};

// Move the angles of two legs of six joints until pelvis and swing sole are at their targets
// (2, 4, 4); false where they come to none.
bool close_legs(const Bodies &robot, const double *targets, const Search &search, double *q);

// What G quantities move: joints of two legs, whose axes (12, 6) are given or nothing, (12, G), and
// the legs from ankle to hip (2, 3, G).
void support_slopes(const DoubleSupport &support, const double *joints, double *rates,
                    double *legs);

// What they bend of weighed joints of two legs, which follow as a chain or are none, and of weighed
// legs from ankle to hip (G, G).
void support_hessian(const DoubleSupport &support, const Chain &joints, const double *q_weights,
                     const double *leg_weights, double *hessian);

}  // namespace gaitopt
