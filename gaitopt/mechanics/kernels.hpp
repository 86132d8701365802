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

}  // namespace gaitopt
