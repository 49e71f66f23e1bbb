#include "samara/codebooks/composition/flow_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/unit_labels.h"
#include "samara/codebooks/book/box.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/composition/motion_symmetry.h"
#include "samara/codebooks/composition/reduced_attitude.h"
#include "samara/codebooks/query/query.h"
#include "samara/models/interface/parametric_model.h"

namespace samara::codebooks {

namespace {

/// A motion of more windows is a mistake in the time.
constexpr double kMostWindows = 1e7;
constexpr double kTurn = 2.0 * std::numbers::pi;

/// How a state goes from window to window.
struct Carried {
  int output = 0;                 ///< place in the codebook's outputs
  std::optional<int> coordinate;  ///< of "s(0)"; none: the state is only displaced, or held
  bool held = false;              ///< the same at the start of every window: of a reduced attitude
  double origin = 0.0;            ///< initial value in the codebook, of a state that is only displaced
  double lower = 0.0, upper = 0.0;
  bool wraps = false;  ///< an angle: full turns do not matter
};

std::optional<int> find_name(const auto& list, const std::string& name) {
  const auto found = std::ranges::find_if(list, [&](const auto& item) { return item.name == name; });
  if (found == list.end()) return std::nullopt;
  return static_cast<int>(found - list.begin());
}

/// Fixed or default.
double initial_value(const Codebook& book, const models::StateInfo& state) {
  const auto fixed = book.model().fixed.find(state.name + "(0)");
  return fixed == book.model().fixed.end() ? state.default_initial : fixed->second;
}

/// How the attitude of a model with a quaternion is to be reduced. None: every number of it is an axis, or
/// the model has none.
std::optional<ReducedAttitude> reduced_attitude(const Codebook& book, const models::ModelInfo& info) {
  const auto group =
      std::ranges::find(info.groups, models::StateGroupKind::quaternion, &models::StateGroup::kind);
  if (group == info.groups.end()) return std::nullopt;
  const auto state = [&](int k) { return info.states[static_cast<std::size_t>(group->first + k)]; };
  const auto is_axis = [&](int k) {
    return find_name(book.coordinates(), state(k).name + "(0)").has_value();
  };
  if (is_axis(0)) return std::nullopt;
  const double length = initial_value(book, state(0));
  const bool turns = std::ranges::count(info.symmetries, "rotation about z") > 0;
  const bool without_yaw = turns && !is_axis(3);
  const bool is_upright = !without_yaw || initial_value(book, state(3)) == 0.0;
  if (length != 0.0 && is_upright && is_axis(1) && is_axis(2) && (without_yaw || is_axis(3)))
    return ReducedAttitude(info, group->first, length, without_yaw);
  throw ArgumentError(fmt::format(
      "a flow map of \"{0}\" needs the axes \"{2}(0)\" and \"{3}(0)\", with \"{1}(0)\" fixed at 1 "
      "and \"{4}(0)\" {5}, "
      "or all four axes of the attitude",
      info.name, state(0).name, state(1).name, state(2).name, state(3).name,
      turns ? "at 0" : "an axis too, since the model notices the yaw"));
}

}  // namespace

struct FlowMap::Impl {
  /// A state that is outside the box.
  struct Leaving {
    std::size_t state = 0;
    double value = 0.0;              ///< reduced
    const HalfTurn* turn = nullptr;  ///< after which it is
  };
  /// Where a window begins.
  struct Window {
    Eigen::VectorXd start;             ///< all states as they are
    const HalfTurn* turn = nullptr;    ///< of the body, that brings it into the box; null: none is needed
    Eigen::VectorXd turned;            ///< after it
    Eigen::VectorXd reduced;           ///< without heading, where an attitude is reduced
    Eigen::MatrixXd reduced_by_start;  ///< where derivatives are wanted
    std::vector<double> shift;         ///< what the codebook's states are displaced by
  };

  const Codebook& book;
  Query query;
  std::vector<std::string> states;
  std::vector<std::string> units;
  std::vector<Carried> carried;
  std::optional<ReducedAttitude> attitude;
  std::vector<HalfTurn> turns;
  std::vector<Coordinate> parameters;
  std::vector<int> parameter_places;  ///< coordinates of the codebook
  double window = 0.0;

  std::vector<double> point;
  Eigen::VectorXd values;
  Eigen::MatrixXd gradient;
  Eigen::MatrixXd by_reduced, by_heading;

  explicit Impl(const Codebook& codebook);
  Carried carry(const models::ModelInfo& info, std::size_t state, bool is_angle) const;
  void check(std::span<const double> start, std::span<const double> q, std::span<const double> times) const;
  /// Loads the start of a window, after a half turn of the body where that is needed.
  /// @returns why it is outside the box, if it is: as it is, or for what a turn that helps the attitude leaves
  std::optional<Leaving> open(Window& at, bool with_derivatives);
  /// The same after one turn or none.
  std::optional<Leaving> load(Window& at, bool with_derivatives);
  /// States at a time of the window that was loaded, reduced as its start, and their derivatives by the
  /// states at its start and the parameters.
  void answer(double t, const Window& at, Eigen::VectorXd& x, Eigen::MatrixXd* by_start,
              Eigen::MatrixXd* by_parameters);
  /// The same as they are, from the start as it is.
  void answer_from(const Window& at, double t, Eigen::VectorXd& x, Eigen::MatrixXd* by_start,
                   Eigen::MatrixXd* by_parameters);
  std::string left_box(double t, const Leaving& leaving) const;
  void run(const Eigen::VectorXd& start, std::span<const double> times, bool with_derivatives,
           FlowMapResult& result);
};

Carried FlowMap::Impl::carry(const models::ModelInfo& info, std::size_t state, bool is_angle) const {
  const std::string& name = info.states[state].name;
  Carried result;
  const std::optional<int> output = find_name(book.outputs(), name);
  if (!output) throw ArgumentError(fmt::format("a flow map needs the state \"{}\" among the outputs", name));
  result.output = *output;
  result.coordinate = find_name(book.coordinates(), name + "(0)");
  if (result.coordinate) {
    const Coordinate& axis = book.coordinates()[static_cast<std::size_t>(*result.coordinate)];
    result.lower = axis.lower;
    result.upper = axis.upper;
    result.wraps = is_angle;
    return result;
  }
  if (attitude && attitude->holds(static_cast<int>(state))) {
    result.held = true;
    return result;
  }
  if (std::ranges::count(info.symmetries, "translation of " + name) == 0) {
    throw ArgumentError(
        fmt::format("a flow map needs an axis \"{}(0)\": the model \"{}\" notices where {} starts", name,
                    info.name, name));
  }
  result.origin = initial_value(book, info.states[state]);
  return result;
}

FlowMap::Impl::Impl(const Codebook& codebook) : book(codebook), query(codebook) {
  const models::ParametricModel model = model_of(book);
  const models::ModelInfo& info = model.model().info();
  std::vector<double> lower, upper;
  for (std::size_t k = 1; k < book.coordinates().size(); ++k) {
    const Coordinate& c = book.coordinates()[k];
    lower.push_back(c.lower);
    upper.push_back(c.upper);
    if (c.role == pgd::AxisRole::initial) continue;
    parameters.push_back(c);
    parameter_places.push_back(static_cast<int>(k));
  }
  const Coordinate& time = book.time("a flow map");
  window = time.upper;
  if (time.lower != 0.0) {
    throw ArgumentError(
        fmt::format("a flow map needs a codebook from t = 0 on; this one begins at {}", time.lower));
  }
  MotionSymmetry symmetry = motion_symmetry(model, lower, upper, 0.37 * window);
  turns = std::move(symmetry.turns);
  if (!symmetry.autonomous) {
    throw ArgumentError(
        fmt::format("a flow map needs an autonomous model; \"{}\" depends on time", info.name));
  }
  attitude = reduced_attitude(book, info);
  for (std::size_t i = 0; i < info.states.size(); ++i) {
    states.push_back(info.states[i].name);
    units.push_back(info.states[i].unit);
    carried.push_back(carry(info, i, symmetry.angles[i]));
  }
  point.resize(book.coordinates().size());
  values.resize(book.output_count());
  gradient.resize(book.output_count(), book.coordinate_count());
}

void FlowMap::Impl::check(std::span<const double> start, std::span<const double> q,
                          std::span<const double> times) const {
  if (start.size() != states.size() || q.size() != parameters.size()) {
    throw ArgumentError(fmt::format("a flow map of {} states and {} parameters was given {} and {}",
                                    states.size(), parameters.size(), start.size(), q.size()));
  }
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (!std::isfinite(start[i])) {
      throw ArgumentError(fmt::format("{}(0) is {}, expected a finite number", states[i], start[i]));
    }
  }
  require_inside(parameters, q);
  double before = 0.0;
  for (const double t : times) {
    if (!(std::isfinite(t) && t >= before)) {
      throw ArgumentError(
          fmt::format("the times of a flow map hold {} after {}, expected finite ones that do "
                      "not decrease, from 0 on",
                      t, before));
    }
    before = t;
  }
  if (before > kMostWindows * window) {
    throw ArgumentError(
        fmt::format("the times of a flow map go to {:.6g} s, expected at most {:.0e} windows of {:.6g} s",
                    before, kMostWindows, window));
  }
}

std::optional<FlowMap::Impl::Leaving> FlowMap::Impl::open(Window& at, bool with_derivatives) {
  at.turn = nullptr;
  const auto is_of_attitude = [&](const Leaving& leaving) {
    return carried[leaving.state].wraps || (attitude && attitude->turns(static_cast<int>(leaving.state)));
  };
  std::optional<Leaving> first = load(at, with_derivatives);
  if (!first) return std::nullopt;
  for (const HalfTurn& turn : turns) {
    at.turn = &turn;
    const std::optional<Leaving> leaving = load(at, with_derivatives);
    if (!leaving) return std::nullopt;
    if (is_of_attitude(*first) && !is_of_attitude(*leaving)) first = leaving;
  }
  return first;
}

std::optional<FlowMap::Impl::Leaving> FlowMap::Impl::load(Window& at, bool with_derivatives) {
  at.turned = at.turn != nullptr ? at.turn->turned(at.start) : at.start;
  at.reduced =
      attitude ? attitude->reduced(at.turned, with_derivatives ? &at.reduced_by_start : nullptr) : at.turned;
  for (std::size_t i = 0; i < carried.size(); ++i) {
    const Carried& state = carried[i];
    double value = at.reduced[static_cast<Eigen::Index>(i)];
    if (!state.coordinate) {
      at.shift[i] = state.held ? 0.0 : value - state.origin;
      continue;
    }
    // Half turns and full ones leave an angle at the border by its last digits.
    const double slack = state.wraps ? 1e-9 * kTurn : 0.0;
    const bool is_inside = value >= state.lower - slack && value <= state.upper + slack;
    at.shift[i] = state.wraps && !is_inside ? kTurn * std::floor((value - state.lower + slack) / kTurn) : 0.0;
    value -= at.shift[i];
    if (!(value >= state.lower - slack && value <= state.upper + slack)) return Leaving{i, value, at.turn};
    point[static_cast<std::size_t>(*state.coordinate)] = std::clamp(value, state.lower, state.upper);
  }
  return std::nullopt;
}

void FlowMap::Impl::answer(double t, const Window& at, Eigen::VectorXd& x, Eigen::MatrixXd* by_start,
                           Eigen::MatrixXd* by_parameters) {
  point[0] = std::min(t, window);
  if (by_start == nullptr) {
    query.values(point, values);
  } else {
    query.values(point, values, gradient);
    by_start->setZero();
  }
  for (std::size_t i = 0; i < carried.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    x[row] = values[carried[i].output] + at.shift[i];
    if (by_start == nullptr) continue;
    for (std::size_t j = 0; j < carried.size(); ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      if (carried[j].coordinate)
        (*by_start)(row, column) = gradient(carried[i].output, *carried[j].coordinate);
    }
    if (!carried[i].coordinate && !carried[i].held) (*by_start)(row, row) = 1.0;
    for (std::size_t k = 0; k < parameter_places.size(); ++k) {
      (*by_parameters)(row, static_cast<Eigen::Index>(k)) = gradient(carried[i].output, parameter_places[k]);
    }
  }
}

void FlowMap::Impl::answer_from(const Window& at, double t, Eigen::VectorXd& x, Eigen::MatrixXd* by_start,
                                Eigen::MatrixXd* by_parameters) {
  answer(t, at, x, by_start, by_parameters);
  if (attitude) {
    const bool with_slopes = by_start != nullptr;
    x = attitude->restored(x, at.turned, with_slopes ? &by_reduced : nullptr,
                           with_slopes ? &by_heading : nullptr);
    if (with_slopes) {
      *by_start = by_reduced * *by_start * at.reduced_by_start + by_heading;
      *by_parameters = by_reduced * *by_parameters;
    }
  }
  if (at.turn == nullptr) return;
  x = at.turn->turned_back(x);
  if (by_start == nullptr) return;
  *by_start = at.turn->linear.transpose() * *by_start * at.turn->linear;
  *by_parameters = at.turn->linear.transpose() * *by_parameters;
}

std::string FlowMap::Impl::left_box(double t, const Leaving& leaving) const {
  const Carried& state = carried[leaving.state];
  const bool is_reduced = attitude && attitude->turns(static_cast<int>(leaving.state));
  return fmt::format("the flow map left the box at t = {:.6g}: {} = {:.6g}{}{} is outside [{}, {}]{}", t,
                     states[leaving.state], leaving.value, unit_suffix(units[leaving.state]),
                     !is_reduced                  ? ""
                     : attitude->is_without_yaw() ? ", without yaw,"
                                                  : ", with qw made one,",
                     state.lower, state.upper,
                     leaving.turn != nullptr ? fmt::format(" after a half turn {}", leaving.turn->name)
                     : turns.empty()         ? ""
                                             : ", and a half turn of the body does not bring it back");
}

void FlowMap::Impl::run(const Eigen::VectorXd& start, std::span<const double> times, bool with_derivatives,
                        FlowMapResult& result) {
  const Eigen::Index n = start.size();
  const auto m = static_cast<Eigen::Index>(parameters.size());
  Window at;
  at.start = start;
  at.shift.resize(states.size());
  Eigen::VectorXd end(n);
  Eigen::MatrixXd by_start(n, n), by_parameters(n, m);
  // d(x at the start of the window)/d(start, parameters)
  Eigen::MatrixXd so_far = Eigen::MatrixXd::Zero(n, n + m);
  so_far.leftCols(n).setIdentity();
  Eigen::MatrixXd* const A = with_derivatives ? &by_start : nullptr;
  Eigen::MatrixXd* const B = with_derivatives ? &by_parameters : nullptr;
  const auto composed = [&] {
    Eigen::MatrixXd all = by_start * so_far;
    all.rightCols(m) += by_parameters;
    return all;
  };
  std::size_t next = 0;
  for (long k = 0; next < times.size(); ++k) {
    const double begin = static_cast<double>(k) * window;
    if (const std::optional<Leaving> leaving = open(at, with_derivatives)) {
      result.status = FlowMapStatus::left_box;
      result.left = states[leaving->state];
      result.message = left_box(begin, *leaving);
      return;
    }
    // The end of the last window serves the times at its border: rounding must not open another one.
    for (; next < times.size() && times[next] - begin <= window * (1.0 + 1e-12); ++next) {
      answer_from(at, times[next] - begin, end, A, B);
      result.states.row(static_cast<Eigen::Index>(next)) = end.transpose();
      if (with_derivatives) result.derivatives[next] = composed();
      result.reached = times[next];
    }
    if (next == times.size()) break;
    answer_from(at, window, end, A, B);
    if (with_derivatives) so_far = composed();
    at.start = end;
  }
  result.message = fmt::format("{} times up to {:.6g}", times.size(), result.reached);
}

FlowMap::FlowMap(const Codebook& book) : impl_(std::make_unique<Impl>(book)) {}
FlowMap::~FlowMap() = default;
FlowMap::FlowMap(FlowMap&&) noexcept = default;
FlowMap& FlowMap::operator=(FlowMap&&) noexcept = default;

const std::vector<std::string>& FlowMap::states() const {
  return impl_->states;
}
const std::vector<Coordinate>& FlowMap::parameters() const {
  return impl_->parameters;
}
double FlowMap::window() const {
  return impl_->window;
}

FlowMapResult FlowMap::run(std::span<const double> start, std::span<const double> parameters,
                           std::span<const double> times, bool with_derivatives) {
  impl_->check(start, parameters, times);
  const auto states = static_cast<Eigen::Index>(start.size());
  const auto count = static_cast<Eigen::Index>(times.size());
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  FlowMapResult result;
  result.states.setConstant(count, states, kUnknown);
  if (with_derivatives) {
    const auto columns = states + static_cast<Eigen::Index>(parameters.size());
    result.derivatives.assign(times.size(), Eigen::MatrixXd::Constant(states, columns, kUnknown));
  }
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    impl_->point[static_cast<std::size_t>(impl_->parameter_places[k])] = parameters[k];
  }
  impl_->run(Eigen::Map<const Eigen::VectorXd>(start.data(), states), times, with_derivatives, result);
  return result;
}

}  // namespace samara::codebooks
