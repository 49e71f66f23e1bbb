#include "samara/codebooks/composition/window_chart.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/unit_labels.h"
#include "samara/codebooks/book/book_model.h"
#include "samara/models/interface/parametric_model.h"

namespace samara::codebooks {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

std::optional<int> find_name(const auto& list, const std::string& name) {
  const auto found = std::ranges::find_if(list, [&](const auto& item) { return item.name == name; });
  if (found == list.end()) return std::nullopt;
  return static_cast<int>(found - list.begin());
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
  if (is_axis(0) && is_axis(1) && is_axis(2) && is_axis(3)) return std::nullopt;
  const bool turns = std::ranges::count(info.symmetries, "rotation about z") > 0;
  // Upright the tilt is (qx, qy) beside qw, upside down (qw, qz) beside qx; the yaw is what is left.
  for (const bool is_upside_down : {false, true}) {
    const int held = is_upside_down ? 1 : 0, yaw = is_upside_down ? 2 : 3;
    const int first = is_upside_down ? 0 : 1, second = is_upside_down ? 3 : 2;
    const double length = models::held_start(state(held), book.model().fixed);
    const bool without_yaw =
        turns && !is_axis(yaw) && models::held_start(state(yaw), book.model().fixed) == 0.0;
    if (!is_axis(held) && length != 0.0 && is_axis(first) && is_axis(second) && (without_yaw || is_axis(yaw)))
      return ReducedAttitude(info, group->first, length, without_yaw, is_upside_down);
  }
  throw ArgumentError(fmt::format(
      "a flow map of \"{0}\" needs the axes \"{2}(0)\" and \"{3}(0)\", with \"{1}(0)\" fixed at 1 "
      "and \"{4}(0)\" {5}, or all four axes of the attitude; or, for bodies upside down, \"{1}(0)\" and "
      "\"{4}(0)\", with \"{2}(0)\" fixed at 1 and \"{3}(0)\" {5}",
      info.name, state(0).name, state(1).name, state(2).name, state(3).name,
      turns ? "at 0" : "an axis too, since the model notices the yaw"));
}

}  // namespace

WindowChart::Carried WindowChart::carry(const models::ModelInfo& info, std::size_t state,
                                        bool is_angle) const {
  const std::string& name = info.states[state].name;
  Carried result;
  const std::optional<int> output = find_name(book_->outputs(), name);
  if (!output) throw ArgumentError(fmt::format("a flow map needs the state \"{}\" among the outputs", name));
  result.output = *output;
  result.coordinate = find_name(book_->coordinates(), name + "(0)");
  if (result.coordinate) {
    const Coordinate& axis = book_->coordinates()[static_cast<std::size_t>(*result.coordinate)];
    result.lower = axis.lower;
    result.upper = axis.upper;
    result.wraps = is_angle;
    return result;
  }
  if (attitude_ && attitude_->holds(static_cast<int>(state))) {
    result.held = true;
    return result;
  }
  if (std::ranges::count(info.symmetries, "translation of " + name) == 0) {
    throw ArgumentError(
        fmt::format("a flow map needs an axis \"{}(0)\": the model \"{}\" notices where {} starts", name,
                    info.name, name));
  }
  result.origin = models::held_start(info.states[state], book_->model().fixed);
  return result;
}

WindowChart::WindowChart(const Codebook& book)
    : book_(&book), query_(book), model_(model_of(book)), workspace_(model_.make_workspace()) {
  const models::ModelInfo& info = model_.model().info();
  const std::vector<pgd::Axis> axes = book.pieces().front().outline().axes;
  std::vector<DrawnInterval> box;
  for (std::size_t k = 1; k < book.coordinates().size(); ++k) {
    const Coordinate& c = book.coordinates()[k];
    box.push_back({c.lower, c.upper, axes[k].transform()});
    model_parameters_.push_back(c.lower);
    if (c.role == pgd::AxisRole::initial) continue;
    parameters_.push_back(c);
    parameter_places_.push_back(static_cast<int>(k));
  }
  const Coordinate& time = book.time("a flow map");
  window_ = time.upper;
  if (time.lower != 0.0) {
    throw ArgumentError(
        fmt::format("a flow map needs a codebook from t = 0 on; this one begins at {}", time.lower));
  }
  symmetry_ = motion_symmetry(model_, box, window_);
  if (!symmetry_.autonomous) {
    throw ArgumentError(
        fmt::format("a flow map needs an autonomous model; \"{}\" depends on time", info.name));
  }
  attitude_ = reduced_attitude(book, info);
  for (std::size_t i = 0; i < info.states.size(); ++i) {
    states_.push_back(info.states[i].name);
    units_.push_back(info.states[i].unit);
    carried_.push_back(carry(info, i, symmetry_.angles[i]));
  }
  point_.resize(book.coordinates().size());
  values_.resize(book.output_count());
  gradient_.resize(book.output_count(), book.coordinate_count());
}

std::optional<LeavingState> WindowChart::open(WindowStart& at, bool with_derivatives) {
  at.image = nullptr;
  std::optional<LeavingState> first = load(at, with_derivatives);
  if (!first) return std::nullopt;
  for (const MotionImage& image : symmetry_.images) {
    at.image = &image;
    const std::optional<LeavingState> leaving = load(at, with_derivatives);
    if (!leaving && is_kept(image, at.start)) return std::nullopt;
    if (!leaving) continue;
    if (is_of_attitude(first->state) && !is_of_attitude(leaving->state)) first = leaving;
  }
  return first;
}

bool WindowChart::is_kept(const MotionImage& image, const Eigen::VectorXd& start) {
  // Of many full turns the last digits of an angle are lost, and f with them.
  Eigen::VectorXd x = start;
  for (std::size_t i = 0; i < carried_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (carried_[i].wraps) x[row] -= kTurn * std::round(x[row] / kTurn);
  }
  const auto rate = [&](const Eigen::VectorXd& at) {
    Eigen::VectorXd f(at.size());
    const auto size = static_cast<std::size_t>(at.size());
    model_.rhs(0.0, {at.data(), size}, model_parameters_, {f.data(), size}, workspace_);
    return f;
  };
  return are_same_rates(rate(image.of(x)), image.linear * rate(x), symmetry_.sizes);
}

std::optional<LeavingState> WindowChart::load(WindowStart& at, bool with_derivatives) {
  at.inside = at.image != nullptr ? at.image->of(at.start) : at.start;
  at.reduced = attitude_ ? attitude_->reduced(at.inside, with_derivatives ? &at.reduced_by_start : nullptr)
                         : at.inside;
  for (std::size_t i = 0; i < carried_.size(); ++i) {
    const Carried& state = carried_[i];
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
    if (!(value >= state.lower - slack && value <= state.upper + slack))
      return LeavingState{i, value, at.image};
    point_[static_cast<std::size_t>(*state.coordinate)] = std::clamp(value, state.lower, state.upper);
  }
  return std::nullopt;
}

void WindowChart::answer_reduced(double t, const WindowStart& at, Eigen::VectorXd& x,
                                 Eigen::MatrixXd* by_start, Eigen::MatrixXd* by_parameters) {
  point_[0] = std::min(t, window_);
  if (by_start == nullptr) {
    query_.values(point_, values_);
  } else {
    query_.values(point_, values_, gradient_);
    by_start->setZero();
  }
  for (std::size_t i = 0; i < carried_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    x[row] = values_[carried_[i].output] + at.shift[i];
    if (by_start == nullptr) continue;
    for (std::size_t j = 0; j < carried_.size(); ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      if (carried_[j].coordinate)
        (*by_start)(row, column) = gradient_(carried_[i].output, *carried_[j].coordinate);
    }
    if (!carried_[i].coordinate && !carried_[i].held) (*by_start)(row, row) = 1.0;
    for (std::size_t k = 0; k < parameter_places_.size(); ++k) {
      (*by_parameters)(row, static_cast<Eigen::Index>(k)) =
          gradient_(carried_[i].output, parameter_places_[k]);
    }
  }
}

void WindowChart::answer(const WindowStart& at, double t, Eigen::VectorXd& x, Eigen::MatrixXd* by_start,
                         Eigen::MatrixXd* by_parameters) {
  answer_reduced(t, at, x, by_start, by_parameters);
  if (attitude_) {
    const bool with_slopes = by_start != nullptr;
    x = attitude_->restored(x, at.inside, with_slopes ? &by_reduced_ : nullptr,
                            with_slopes ? &by_heading_ : nullptr);
    if (with_slopes) {
      *by_start = by_reduced_ * *by_start * at.reduced_by_start + by_heading_;
      *by_parameters = by_reduced_ * *by_parameters;
    }
  }
  if (at.image == nullptr) return;
  x = at.image->back(x);
  if (by_start == nullptr) return;
  *by_start = at.image->linear.transpose() * *by_start * at.image->linear;
  *by_parameters = at.image->linear.transpose() * *by_parameters;
}

bool WindowChart::is_of_attitude(std::size_t state) const {
  return carried_[state].wraps || (attitude_ && attitude_->turns(static_cast<int>(state)));
}

void WindowChart::set_parameters(std::span<const double> q) {
  for (std::size_t k = 0; k < q.size(); ++k) {
    const auto place = static_cast<std::size_t>(parameter_places_[k]);
    point_[place] = q[k];
    model_parameters_[place - 1] = q[k];
  }
}

std::string WindowChart::words(const LeavingState& leaving) const {
  const Carried& state = carried_[leaving.state];
  const bool is_reduced = attitude_ && attitude_->turns(static_cast<int>(leaving.state));
  const std::string how = !is_reduced                   ? ""
                          : attitude_->is_without_yaw() ? ", without yaw,"
                                                        : ", with the number that is fixed made one,";
  const std::string after = leaving.image != nullptr ? fmt::format(" after {}", leaving.image->name)
                            : symmetry_.images.empty()
                                ? ""
                                : ", and what its motion does not notice does not bring it back";
  return fmt::format("{} = {:.6g}{}{} is outside [{}, {}]{}", states_[leaving.state], leaving.value,
                     unit_suffix(units_[leaving.state]), how, state.lower, state.upper, after);
}

}  // namespace samara::codebooks
