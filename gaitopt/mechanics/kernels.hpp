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

}  // namespace gaitopt
