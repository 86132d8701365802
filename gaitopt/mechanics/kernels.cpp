// The compiled module: checks shapes and hands NumPy's tables over. See compiled.py.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <stdexcept>
#include <string>

#include "kernels.hpp"

namespace py = pybind11;

namespace gaitopt {
namespace {

// of another type, order or alignment they are copied
constexpr int ALIGNED = py::array::forcecast | py::detail::npy_api::NPY_ARRAY_ALIGNED_;
using Strided = py::array_t<double, ALIGNED>;
using Table = py::array_t<double, py::array::c_style | ALIGNED>;
using Numbers = py::array_t<long, py::array::c_style | ALIGNED>;

constexpr long MOST = 1L << 20;  // quantities, entries, instants or rows: sums of them are in range

// Refuse a table of another shape: nothing may be read beyond its end.
void expect(const py::array &table, const char *name, std::initializer_list<py::ssize_t> shape) {
  bool fits = table.ndim() == static_cast<py::ssize_t>(shape.size());
  py::ssize_t axis = 0;
  for (const py::ssize_t length : shape) fits = fits && table.shape(axis++) == length;
  if (fits) return;
  std::string asked;
  for (const py::ssize_t length : shape) asked += std::to_string(length) + ", ";
  throw std::invalid_argument(std::string(name) + " must have shape (" + asked + ")");
}

std::vector<double> copied(const Table &table) {
  return std::vector<double>(table.data(), table.data() + table.size());
}

Bodies bodies_of(const std::vector<int> &parents, int foot, const Table &placements,
                 const Table &axes, const Table &inertias, const Table &frames,
                 const Table &armature, const Table &gravity) {
  Bodies robot;
  const auto n = static_cast<py::ssize_t>(parents.size());
  expect(placements, "placements", {n, 12});
  expect(axes, "axes", {n, 3});
  expect(inertias, "inertias", {n + 1, 13});
  expect(frames, "frames", {2, 12});
  expect(armature, "armature", {n});
  expect(gravity, "gravity", {3});
  robot.count = static_cast<int>(n);
  robot.foot = foot;
  for (int j = 0; j < robot.count; ++j) {
    if (parents[j] < -1 || parents[j] >= j)
      throw std::invalid_argument("a joint must come after the one that carries it");
    robot.serial = robot.serial && parents[j] == j - 1;
  }
  if (foot < 0 || foot >= robot.count)
    throw std::invalid_argument("the swing foot must be moved by one of the joints");
  robot.parents = parents;
  robot.placements = copied(placements);
  robot.axes = copied(axes);
  robot.inertias = copied(inertias);
  robot.frames = copied(frames);
  robot.armature = copied(armature);
  std::copy(gravity.data(), gravity.data() + 3, robot.gravity.begin());
  return robot;
}

py::tuple support(const Bodies &robot, const Table &q, const Table &dq, const Table &ddq,
                  bool derivatives) {
  const py::ssize_t n = robot.count, count = q.ndim() == 2 ? q.shape(0) : 0;
  expect(q, "q", {count, n});
  expect(dq, "dq", {count, n});
  expect(ddq, "ddq", {count, n});
  py::array_t<double> effort({count, 6 + n}), frame({count, py::ssize_t{4}, py::ssize_t{3}});
  const py::ssize_t rows = derivatives ? count : 0;
  py::array_t<double> jacobian({rows, 6 + n, 3 * n}), axes({rows, n, py::ssize_t{6}});
  const Motions motion = {count, q.data(), dq.data(), ddq.data()};
  const SupportTables found = {effort.mutable_data(), frame.mutable_data(),
                               derivatives ? jacobian.mutable_data() : nullptr,
                               derivatives ? axes.mutable_data() : nullptr};
  inverse_dynamics(robot, motion, found);
  return py::make_tuple(effort, frame, jacobian, axes);
}

py::tuple bent_support(const Bodies &robot, const Table &q, const Table &dq, const Table &ddq,
                       const Table &base, const Table &weights) {
  const py::ssize_t n = robot.count, count = q.ndim() == 2 ? q.shape(0) : 0;
  expect(q, "q", {count, n});
  expect(dq, "dq", {count, n});
  expect(ddq, "ddq", {count, n});
  expect(base, "base", {count, 6});
  expect(weights, "weights", {count, 6 + n});
  py::array_t<double> qq({count, n, n}), qv({count, n, n}), vv({count, n, n}), qa({count, n, n});
  py::array_t<double> by_base({count, n, py::ssize_t{6}});
  const WeightedMotions given = {
      {count, q.data(), dq.data(), ddq.data()}, base.data(), weights.data()};
  const HessianTables found = {qq.mutable_data(), qv.mutable_data(), vv.mutable_data(),
                               qa.mutable_data(), by_base.mutable_data()};
  inverse_dynamics_hessian(robot, given, found);
  return py::make_tuple(qq, qv, vv, qa, by_base);
}

py::array_t<double> placed(const Bodies &robot, const Table &q) {
  const py::ssize_t n = robot.count, count = q.ndim() == 2 ? q.shape(0) : 0;
  expect(q, "q", {count, n});
  py::array_t<double> frames({n + 1, count, py::ssize_t{4}, py::ssize_t{4}});
  place_bodies(robot, q.data(), count, frames.mutable_data());
  return frames;
}

py::tuple foot_points(const Bodies &robot, const Table &frames, const Table &axes,
                      const Table &points) {
  const py::ssize_t instants = frames.ndim() == 3 ? frames.shape(0) : 0;
  const py::ssize_t count = points.ndim() == 2 ? points.shape(0) : 0, n = robot.count;
  const bool derivatives = axes.ndim() == 3 && axes.shape(0) > 0;
  const py::ssize_t rows = derivatives ? instants : 0;
  expect(frames, "frames", {instants, 4, 3});
  expect(axes, "axes", {rows, n, 6});
  expect(points, "points", {count, 3});
  py::array_t<double> found({instants, count, py::ssize_t{3}});
  py::array_t<double> slopes({rows, count, py::ssize_t{3}, n});
  const FootPoints given = {instants, count, frames.data(), derivatives ? axes.data() : nullptr,
                            points.data()};
  move_points(robot, given, found.mutable_data(), slopes.mutable_data());
  return py::make_tuple(found, slopes);
}

py::array_t<double> bent_corners(const Table &axes, const Table &jacobian, const Table &weights) {
  const bool stacked = axes.ndim() == 3;
  const py::ssize_t count = stacked ? axes.shape(0) : 0, n = stacked ? axes.shape(1) : 0;
  expect(axes, "axes", {count, n, 6});
  expect(jacobian, "jacobian", {count, 4, 3, n});
  expect(weights, "weights", {count, 4, 3});
  py::array_t<double> hessian({count, n, n});
  corner_hessian({count, n, axes.data(), jacobian.data(), weights.data()},
                 hessian.mutable_data());
  return hessian;
}

// Refuse numbers that are none of so many things.
void expect_below(const Numbers &numbers, const char *name, py::ssize_t count) {
  for (py::ssize_t i = 0; i < numbers.size(); ++i)
    if (numbers.data()[i] < 0 || numbers.data()[i] >= count)
      throw std::invalid_argument(std::string(name) + " must be from 0 to " +
                                  std::to_string(count - 1));
}

py::array_t<double> nearest_points(const Table &frames, const Numbers &carriers,
                                   const Table &segments, const Numbers &sides,
                                   const Table &squares) {
  const py::ssize_t bodies = frames.ndim() == 4 ? frames.shape(0) : 0;
  const py::ssize_t count = frames.ndim() == 4 ? frames.shape(1) : 0;
  const py::ssize_t capsules = carriers.size(), pairs = sides.ndim() == 2 ? sides.shape(1) : 0;
  expect(frames, "frames", {bodies, count, 4, 4});
  expect(carriers, "carriers", {capsules});
  expect(segments, "segments", {capsules, 6});
  expect(sides, "sides", {2, pairs});
  expect(squares, "squares", {2, pairs});
  expect_below(carriers, "carriers", bodies);
  expect_below(sides, "sides", capsules);
  py::array_t<double> points({py::ssize_t{14}, pairs * count});
  const Capsules all = {capsules,     pairs,        carriers.data(), segments.data(),
                        sides.data(), sides.data() + pairs, squares.data()};
  nearest(all, frames.data(), count, points.mutable_data());
  return points;
}

py::tuple legs_closed(const Bodies &robot, const Table &q, const Table &targets, int steps,
                      double last, double largest) {
  expect(q, "q", {12});
  expect(targets, "targets", {2, 4, 4});
  if (robot.foot != 11) throw std::invalid_argument("the legs must have six joints each");
  py::array_t<double> found(py::ssize_t{12});
  std::copy(q.data(), q.data() + 12, found.mutable_data());
  const bool closed =
      close_legs(robot, targets.data(), {steps, last, largest}, found.mutable_data());
  return py::make_tuple(found, closed);
}

Placing placing_of(const std::vector<int> &counts, const std::vector<int> &turns,
                   const std::vector<int> &quantities, const Table &facts, const Table &hips,
                   const Table &ankles) {
  Placing placing;
  if (counts.size() != 2 || counts[0] < 0 || counts[1] < 0)
    throw std::invalid_argument("there must be two chains of displacements");
  const std::size_t all = static_cast<std::size_t>(counts[0]) + counts[1];
  if (turns.size() != all || quantities.size() != all)
    throw std::invalid_argument("every displacement must turn or not, and have a quantity or -1");
  for (const int quantity : quantities)
    if (quantity < -1 || quantity > MOST)
      throw std::invalid_argument("there are not so many quantities");
  expect(facts, "facts", {static_cast<py::ssize_t>(all), 7});
  expect(hips, "hips", {2, 3});
  expect(ankles, "ankles", {2, 3});
  for (std::size_t k = 0; k < all; ++k) {
    const double *own = facts.data() + 7 * k;
    Displacement one = {turns[k] != 0, quantities[k], own[0], {}, {}};
    std::copy(own + 1, own + 4, one.axis);
    std::copy(own + 4, own + 7, one.point);
    placing.chains[static_cast<int>(k) < counts[0] ? 0 : 1].push_back(one);
    placing.quantities = std::max(placing.quantities, one.quantity + 1);
  }
  placing.hips = copied(hips);
  placing.ankles = copied(ankles);
  return placing;
}

py::tuple support_placed(const Placing &placing, const Table &geometry) {
  const py::ssize_t size = geometry.ndim() == 1 ? geometry.size() : 0;
  expect(geometry, "geometry", {std::max<py::ssize_t>(size, placing.quantities)});
  const auto chain = [&](int body) {
    const auto count = static_cast<py::ssize_t>(placing.chains[body].size());
    return py::array_t<double>({count, py::ssize_t{6}});
  };
  py::array_t<double> frames({2, 4, 4}), pelvis = chain(0), sole = chain(1);
  py::array_t<double> legs({2, 3}), points({3, 3});
  place_support(placing, geometry.data(),
                {frames.mutable_data(), {pelvis.mutable_data(), sole.mutable_data()},
                 legs.mutable_data(), points.mutable_data()});
  return py::make_tuple(frames, pelvis, sole, legs, points);
}

// The chains of a double support, each by its axes (k, 6) and rates (k, G).
DoubleSupport support_of(const Table (&axes)[2], const Table (&rates)[2], const Table &points) {
  const py::ssize_t size = rates[0].ndim() == 2 ? rates[0].shape(1) : 0;
  DoubleSupport support = {size, {}, points.data()};
  expect(points, "points", {3, 3});
  for (int body = 0; body < 2; ++body) {
    const py::ssize_t count = axes[body].ndim() == 2 ? axes[body].shape(0) : 0;
    expect(axes[body], "axes", {count, 6});
    expect(rates[body], "drives", {count, size});
    support.chains[body] = {count, axes[body].data(), rates[body].data()};
  }
  return support;
}

py::ssize_t joints_of(const Table &axes) {
  const py::ssize_t count = axes.ndim() == 2 && axes.shape(0) == 0 ? 0 : 12;
  expect(axes, "joint axes", {count, 6});
  return count;
}

py::tuple slopes_of(const Table &pelvis_axes, const Table &pelvis_drive, const Table &sole_axes,
                    const Table &sole_drive, const Table &points, const Table &joint_axes) {
  const DoubleSupport support =
      support_of({pelvis_axes, sole_axes}, {pelvis_drive, sole_drive}, points);
  const py::ssize_t count = joints_of(joint_axes);
  py::array_t<double> rates({count, support.size});
  py::array_t<double> legs({py::ssize_t{2}, py::ssize_t{3}, support.size});
  support_slopes(support, count == 0 ? nullptr : joint_axes.data(), rates.mutable_data(),
                 legs.mutable_data());
  return py::make_tuple(rates, legs);
}

py::array_t<double> hessian_of(const Table &pelvis_axes, const Table &pelvis_drive,
                               const Table &sole_axes, const Table &sole_drive,
                               const Table &points, const Table &joint_axes, const Table &rates,
                               const Table &q_weights, const Table &leg_weights) {
  const DoubleSupport support =
      support_of({pelvis_axes, sole_axes}, {pelvis_drive, sole_drive}, points);
  const py::ssize_t count = joints_of(joint_axes);
  expect(rates, "rates", {count, support.size});
  expect(q_weights, "q_weights", {count});
  expect(leg_weights, "leg_weights", {2, 3});
  py::array_t<double> hessian({support.size, support.size});
  support_hessian(support, {count, joint_axes.data(), rates.data()}, q_weights.data(),
                  leg_weights.data(), hessian.mutable_data());
  return hessian;
}

Landing landing_of(const Bodies &robot, const std::vector<int> &motors, const Table &slopes,
                   const std::optional<Table> &line) {
  Landing at;
  const py::ssize_t n = robot.count;
  expect(slopes, "slopes", {n});
  if (line) expect(*line, "line", {6});
  if (static_cast<int>(motors.size()) != robot.count)
    throw std::invalid_argument("each joint must follow a free one or be one");
  at.robot = robot;
  for (const int motor : motors) {
    if (motor < 0 || motor >= robot.count)
      throw std::invalid_argument("there are no more free joints than joints");
    at.free = std::max(at.free, motor + 1);
  }
  at.motors = motors;
  at.slopes = copied(slopes);
  if (line) at.line = copied(*line);
  return at;
}

py::tuple landed(const Landing &at, const Table &angles, const Table &rate,
                 const std::optional<Table> &twist, bool derivatives) {
  const py::ssize_t n = at.robot.count, size = at.size();
  expect(angles, "angles", {n});
  expect(rate, "rate", {at.free});
  if (twist) expect(*twist, "twist", {6});
  std::vector<double> before(at.speeds());
  if (twist) std::copy(twist->data(), twist->data() + 6, before.begin());
  std::copy(rate.data(), rate.data() + at.free, before.begin() + 6);
  const ImpactMotion motion = {angles.data(), before.data(), twist.has_value()};
  py::array_t<double> result(size), kkt({size, size}), inverse({size, size}),
      axes({n, py::ssize_t{6}}), frame({4, 3}),
      inputs({derivatives ? size : 0, py::ssize_t{at.inputs(motion.moving)}});
  const ImpactTables found = {result.mutable_data(),  kkt.mutable_data(),
                              inverse.mutable_data(), axes.mutable_data(),
                              frame.mutable_data(),   derivatives ? inputs.mutable_data() : nullptr};
  impact(at, motion, found);
  return py::make_tuple(result, inputs, kkt, inverse, axes, frame);
}

Table landed_hessian(const Landing &at, const Table &velocity, const Table &impulse,
                     const Table &inputs, const Table &axes, const Table &frame,
                     const Table &adjoint, const Table &qq, const Table &qa, const Table &base) {
  const py::ssize_t n = at.robot.count, size = at.size();
  const bool moving = inputs.ndim() == 2 && inputs.shape(1) == at.inputs(true);
  const py::ssize_t width = at.inputs(moving);
  expect(velocity, "velocity", {at.speeds()});
  expect(impulse, "impulse", {6});
  expect(inputs, "inputs", {size, width});
  expect(axes, "axes", {n, 6});
  expect(frame, "frame", {4, 3});
  expect(adjoint, "adjoint", {size});
  expect(qq, "qq", {n, n});
  expect(qa, "qa", {n, n});
  expect(base, "base", {n, 6});
  const WeightedImpact given = {velocity.data(), impulse.data(), axes.data(), frame.data(),
                                inputs.data(),   moving,         adjoint.data(),
                                qq.data(),       qa.data(),      base.data()};
  Table hessian({width, width});
  impact_hessian(at, given, hessian.mutable_data());
  return hessian;
}

// Rows with what they ask of the quantities.
struct AskedRows {
  LinearRows rows;
  std::vector<std::array<py::ssize_t, 2>> least;  // instants and entries of each quantity

  // Of all entries of some quantities side by side, so many of each.
  void add(py::ssize_t number, const std::vector<long> &quantities, const std::vector<long> &widths,
           const Numbers &instants, const Table &matrix) {
    std::vector<long> sources, entries;
    if (quantities.size() != widths.size())
      throw std::invalid_argument("give a width for each quantity");
    for (std::size_t k = 0; k < quantities.size(); ++k) {
      if (quantities[k] < 0 || quantities[k] > MOST || widths[k] > MOST)
        throw std::invalid_argument("there are not so many quantities or entries");
      for (long entry = 0; entry < widths[k]; ++entry) {
        sources.push_back(quantities[k]);
        entries.push_back(entry);
      }
    }
    const bool each = matrix.ndim() == 3;
    const auto size = static_cast<py::ssize_t>(sources.size());
    const py::ssize_t count = instants.size();
    const py::ssize_t height = matrix.ndim() < 2 ? 0 : matrix.shape(each ? 1 : 0);
    expect(instants, "instants", {count});
    if (each)
      expect(matrix, "matrix", {count, height, size});
    else
      expect(matrix, "matrix", {height, size});
    expect_below(instants, "instants", MOST);
    if (number < (rows.numbers.empty() ? 0 : rows.numbers.back() + 1) || number > MOST)
      throw std::invalid_argument("rows are added in the order of their numbers, from 0");
    const py::ssize_t upto =
        count == 0 ? 0 : 1 + *std::max_element(instants.data(), instants.data() + count);
    for (py::ssize_t i = 0; i < size; ++i) {
      const auto source = static_cast<std::size_t>(sources[i]);
      if (source >= least.size()) least.resize(source + 1, {0, 0});
      least[source][0] = std::max(least[source][0], upto);
      least[source][1] = std::max<py::ssize_t>(least[source][1], entries[i] + 1);
    }
    rows.add(number, sources.data(), entries.data(), size, instants.data(), count, matrix.data(),
             height, each ? height * size : 0);
  }

  // Write those of them that a table is for, from a number on: of quantities (K, e) into rows (m,),
  // or of derivatives (K, e, P) into (m, P).
  void of(const std::vector<Strided> &quantities, Strided found, py::ssize_t number) const {
    const auto step = static_cast<py::ssize_t>(sizeof(double));
    const bool derivatives = found.ndim() == 2;
    const py::ssize_t width = derivatives ? found.shape(1) : 1;
    if (found.ndim() < 1 || found.ndim() > 2 || !(found.flags() & py::array::c_style))
      throw std::invalid_argument("found must be rows one by one");
    if (number < 0) throw std::invalid_argument("rows are numbered from 0");
    if (quantities.size() < least.size())
      throw std::invalid_argument("give " + std::to_string(least.size()) + " quantities");
    std::vector<Quantities> from;
    for (std::size_t k = 0; k < least.size(); ++k) {
      const Strided &one = quantities[k];
      const bool fits = one.ndim() == (derivatives ? 3 : 2) && one.shape(0) >= least[k][0] &&
                        one.shape(1) >= least[k][1];
      const bool follow = !derivatives || (one.ndim() == 3 && one.shape(2) == width &&
                                           (width < 2 || one.strides(2) == step));
      const bool whole = fits && one.strides(0) % step == 0 && one.strides(1) % step == 0;
      if (!(whole && follow))
        throw std::invalid_argument("quantity " + std::to_string(k) + " has another shape");
      from.push_back({one.data(), one.strides(0) / step, one.strides(1) / step});
    }
    const RowTable to = {number, found.shape(0), width, found.mutable_data()};
    linear_rows(rows, from.data(), to);
  }
};

}  // namespace
}  // namespace gaitopt

PYBIND11_MODULE(kernels, module) {
  using namespace gaitopt;
  module.attr("SOURCES") = GAITOPT_SOURCES;
  py::class_<Bodies>(module, "Bodies")
      .def(py::init(&bodies_of), py::arg("parents"), py::arg("foot"), py::arg("placements"),
           py::arg("axes"), py::arg("inertias"), py::arg("frames"), py::arg("armature"),
           py::arg("gravity"))
      .def("close_legs", &legs_closed, py::arg("q"), py::arg("targets"), py::arg("steps"),
           py::arg("last"), py::arg("largest"))
      .def("inverse_dynamics", &support, py::arg("q"), py::arg("dq"), py::arg("ddq"),
           py::arg("derivatives"))
      .def("inverse_dynamics_hessian", &bent_support, py::arg("q"), py::arg("dq"), py::arg("ddq"),
           py::arg("base"), py::arg("weights"))
      .def("placed", &placed, py::arg("q"))
      .def("foot_points", &foot_points, py::arg("frames"), py::arg("axes"), py::arg("points"));
  module.def("corner_hessian", &bent_corners, py::arg("axes"), py::arg("jacobian"),
             py::arg("weights"));
  module.def("nearest", &nearest_points, py::arg("frames"), py::arg("carriers"),
             py::arg("segments"), py::arg("sides"), py::arg("squares"));
  py::class_<Placing>(module, "Placing")
      .def(py::init(&placing_of), py::arg("counts"), py::arg("turns"), py::arg("quantities"),
           py::arg("facts"), py::arg("hips"), py::arg("ankles"))
      .def("at", &support_placed, py::arg("geometry"));
  module.def("support_slopes", &slopes_of, py::arg("pelvis_axes"), py::arg("pelvis_drive"),
             py::arg("sole_axes"), py::arg("sole_drive"), py::arg("points"),
             py::arg("joint_axes"));
  module.def("support_hessian", &hessian_of, py::arg("pelvis_axes"), py::arg("pelvis_drive"),
             py::arg("sole_axes"), py::arg("sole_drive"), py::arg("points"),
             py::arg("joint_axes"), py::arg("rates"), py::arg("q_weights"),
             py::arg("leg_weights"));
  py::class_<Landing>(module, "Landing")
      .def(py::init(&landing_of), py::arg("robot"), py::arg("motors"), py::arg("slopes"),
           py::arg("line"))
      .def("impact", &landed, py::arg("angles"), py::arg("rate"), py::arg("twist"),
           py::arg("derivatives"))
      .def("hessian", &landed_hessian, py::arg("velocity"), py::arg("impulse"), py::arg("inputs"),
           py::arg("axes"), py::arg("frame"), py::arg("adjoint"), py::arg("qq"), py::arg("qa"),
           py::arg("base"));
  py::class_<AskedRows>(module, "LinearRows")
      .def(py::init<>())
      .def("add", &AskedRows::add, py::arg("number"), py::arg("quantities"),
           py::arg("widths"), py::arg("instants"), py::arg("matrix"))
      .def("of", &AskedRows::of, py::arg("quantities"), py::arg("found").noconvert(),
           py::arg("number") = 0);
}
