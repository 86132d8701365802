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

struct WeightedMotions {
  Motions motion;
  const double *base;     // acceleration of the stance foot (N, 6)
  const double *weights;  // of wrench and torques (N, 6 + n)
};

struct HessianTables {
  double *qq, *qv, *vv, *qa;  // (N, n, n) each
  double *base;               // (N, n, 6)
};

void inverse_dynamics_hessian(const Bodies &robot, const WeightedMotions &given,
                              const HessianTables &found);

// Frames of the stance foot and the n bodies (n + 1, N, 4, 4), at angles (N, n).
void place_bodies(const Bodies &robot, const double *angles, std::ptrdiff_t count, double *frames);

// Four corners of a sole, moved by j joints.
struct WeightedCorners {
  std::ptrdiff_t count, joints;  // N, j
  const double *axes;            // (N, j, 6)
  const double *jacobian;        // (N, 4, 3, j)
  const double *weights;         // (N, 4, 3)
};

// What they bend (N, j, j).
void corner_hessian(const WeightedCorners &given, double *hessian);

// Points of the swing foot in its body's frame, at N instants.
struct FootPoints {
  std::ptrdiff_t instants, count;
  const double *frames;  // of that body: axes by rows, origin (N, 12)
  const double *axes;    // of the joints in the world (N, n, 6); or nothing
  const double *points;  // (c, 3)
};

// Where they are (N, c, 3) and, where axes are given, their derivatives in the angles (N, c, 3, n).
void move_points(const Bodies &robot, const FootPoints &points, double *found, double *slopes);

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

// A translation along, or a rotation about, a fixed axis of the frame before it.
struct Displacement {
  bool turns;
  int quantity;    // that drives it, -1 none
  double factor;   // amount per unit of it, or altogether
  double axis[3], point[3];
};

// Displacements of pelvis and swing sole from the stance sole, and centres of hips and ankles.
struct Placing {
  std::vector<Displacement> chains[2];
  int quantities = 0;             // that drive them, at least
  std::vector<double> hips, ankles;  // in pelvis and soles (2, 3)
};

// Where they are put.
struct Placements {
  double *frames;   // of pelvis and sole (2, 4, 4)
  double *axes[2];  // of the displacements of either, in the world (k, 6)
  double *legs;     // from ankles to hips (2, 3)
  double *points;   // hips, then the swing ankle (3, 3)
};

// Displacements of pelvis and swing sole; hips and the swing ankle, which they carry (3, 3).
struct DoubleSupport {
  std::ptrdiff_t size;  // G
  Chain chains[2];
  const double *points;
};

void place_support(const Placing &placing, const double *geometry, const Placements &found);

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

// An impact: the robot, m of whose n joints follow no other, and the sole on which it lands.
struct Landing {
  Bodies robot;
  int free = 0;                // m
  std::vector<int> motors;     // which of the m each of the n joints follows or is (n)
  std::vector<double> slopes;  // and with what share of its rate (n)
  std::vector<double> line;    // twist of the line on which it lands (6); none: flat

  int speeds() const { return 6 + free; }                                  // of V
  int size() const { return speeds() + 6 + (line.empty() ? 0 : 1); }       // of V+, I and w
  int inputs(bool moving) const { return 2 * free + (moving ? 6 : 0); }    // posture, V-
};

struct ImpactMotion {
  const double *angles;  // of all joints (n)
  const double *before;  // V- (6 + m)
  bool moving;           // whether the stance sole does, before
};

struct ImpactTables {
  double *result;   // V+, I and, on a line, w (size)
  double *kkt;      // the matrix of the linear system (size, size)
  double *inverse;  // its inverse
  double *axes;     // of the joints (n, 6)
  double *frame;    // of the landing sole: axes by rows, origin (12)
  double *inputs;   // derivatives of the result in posture, rates and twist (size, inputs); or nothing
};

void impact(const Landing &at, const ImpactMotion &motion, const ImpactTables &found);

struct WeightedImpact {
  const double *velocity, *impulse;      // V+ (6 + m), I (6)
  const double *axes, *frame, *inputs;   // as of ImpactTables
  bool moving;                           // as of ImpactMotion
  const double *adjoint;                 // l (size)
  const double *qq, *qa, *base;          // inertial second derivatives (n, n), (n, n), (n, 6)
};

// Hessian in posture, rates and twist (inputs, inputs).
void impact_hessian(const Landing &at, const WeightedImpact &given, double *hessian);

// A quantity or its derivatives: numbers of each entry at each instant, P that follow each other.
struct Quantities {
  const double *data;
  std::ptrdiff_t by_instant, by_entry;  // how far apart those are
};

// Rows that are sums of entries times constant factors.
struct LinearRows {
  struct Term {
    long source, instant, entry;
    double factor;
  };
  std::vector<std::ptrdiff_t> numbers;      // of each row, ascending
  std::vector<std::ptrdiff_t> first = {0};  // term of each row, and the end
  std::vector<Term> terms;

  // Add rows from a number on: of K instants, each with a matrix (r, e) of the entries, or all with
  // the same (apart = 0).
  void add(std::ptrdiff_t number, const long *sources, const long *entries, std::ptrdiff_t size,
           const long *instants, std::ptrdiff_t count, const double *matrix, std::ptrdiff_t height,
           std::ptrdiff_t apart);
};

// Rows that follow each other, of quantities (P = 1) or of their derivatives.
struct RowTable {
  std::ptrdiff_t number, count, width;  // of the first, m, P
  double *rows;                         // (m, P)
};

void linear_rows(const LinearRows &rows, const Quantities *from, const RowTable &found);

}  // namespace gaitopt
