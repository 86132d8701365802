// Frames of the bodies at all postures, as forward_kinematics.py has them.
#include "kernels.hpp"

namespace gaitopt {
namespace {

GAITOPT_ANY_PROCESSOR
void four_postures(const Bodies &robot, const double *angles, std::ptrdiff_t count,
                   std::ptrdiff_t first, PlacedOf<Four> *placed, double *frames) {
  const Instants here(first, count);
  for (int j = 0; j < robot.count; ++j) {
    place_joint<Four>(robot, j, here.load(angles, robot.count, j), placed);
    const Matrix &R = placed[j].rotation;
    const Vector &p = placed[j].origin;
    const Lane zero = all(0.0);
    const Lane numbers[16] = {R.x.x, R.x.y, R.x.z, p.x, R.y.x, R.y.y, R.y.z, p.y,
                              R.z.x, R.z.y, R.z.z, p.z, zero,  zero,  zero,  all(1.0)};
    double *own = frames + (j + 1) * count * 16;
    for (int i = 0; i < 16; ++i) here.store(own, 16, i, numbers[i]);
  }
}

}  // namespace

void place_bodies(const Bodies &robot, const double *angles, std::ptrdiff_t count, double *frames) {
  for (std::ptrdiff_t k = 0; k < count; ++k)  // the stance foot is the world
    for (int i = 0; i < 16; ++i) frames[16 * k + i] = i % 5 == 0 ? 1.0 : 0.0;
  std::vector<PlacedOf<Four>> placed(robot.count);
  for (std::ptrdiff_t first = 0; first < count; first += LANES)
    four_postures(robot, angles, count, first, placed.data(), frames);
}

}  // namespace gaitopt
