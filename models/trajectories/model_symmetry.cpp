#include "samara/models/trajectories/model_symmetry.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "samara/models/equations/equation_model.h"

namespace samara::models {

std::vector<std::string> translated_outputs(const ModelInfo& model,
                                            const std::vector<FamilyOutput>& outputs) {
  std::vector<std::string> translated;
  for (const FamilyOutput& output : outputs) {
    if (std::ranges::count(model.symmetries, "translation of " + output.name) > 0)
      translated.push_back(output.name);
  }
  return translated;
}

std::vector<std::string> attitude_outputs(const ModelInfo& model, const std::vector<FamilyOutput>& outputs) {
  for (const StateGroup& group : model.groups) {
    if (group.kind != StateGroupKind::quaternion) continue;
    std::vector<std::string> names;
    for (int part = 0; part < 4; ++part) {
      names.push_back(model.states[static_cast<std::size_t>(group.first + part)].name);
      if (std::ranges::count(outputs, names.back(), &FamilyOutput::name) == 0) return {};
    }
    return names;
  }
  return {};
}

std::vector<PointOfMotion> points_of_motion(const ParametricModel& equations,
                                            const std::vector<FamilyCoordinate>& box) {
  constexpr int kPoints = 8;
  constexpr double kOff = 1e-3;  // of a scale: no function is asked where it would not come soon
  const ModelInfo& info = equations.model().info();
  std::vector<PointOfMotion> points;
  int number = 0;
  // Shares from 0 to 1 that follow no pattern of the equations.
  const auto next_share = [&] { return std::fmod(++number * std::numbers::phi, 1.0); };
  for (int k = 0; k < kPoints; ++k) {
    const bool is_middle = k == 0;
    PointOfMotion one{std::vector<double>(box.size()), std::vector<double>(info.states.size())};
    for (std::size_t c = 0; c < box.size(); ++c)
      one.q[c] = box[c].lower + (is_middle ? 0.5 : next_share()) * (box[c].upper - box[c].lower);
    equations.initial(one.q, one.x);
    const Scales scales = equations.scales(one.q);
    for (std::size_t i = 0; i < one.x.size() && !is_middle; ++i)
      one.x[i] += kOff * next_share() * state_scale(info.states[i], scales);
    for (const StateGroup& group : info.groups) {
      // The middle of the box of an attitude may be none.
      if (group.kind == StateGroupKind::quaternion) one.x[static_cast<std::size_t>(group.first)] += 1.0;
    }
    points.push_back(std::move(one));
  }
  return points;
}

std::vector<double> times_of_motion() {
  constexpr int kTimes = 32;
  std::vector<double> times;
  for (int k = 1; k <= kTimes; ++k)
    times.push_back(std::pow(10.0, 4.0 * std::fmod(k * std::numbers::phi, 1.0) - 2.0));
  return times;
}

bool is_autonomous(const ParametricModel& equations, const std::vector<FamilyCoordinate>& box) {
  // No times that are tried would meet what acts for a moment.
  const Equations* const text = equations_of(equations.model());
  if (text != nullptr && mention_time(*text)) return false;
  Eigen::VectorXd first(equations.state_count()), then(equations.state_count());
  const auto span_of = [](Eigen::VectorXd& f) {
    return std::span(f.data(), static_cast<std::size_t>(f.size()));
  };
  const std::vector<double> times = times_of_motion();
  ParametricModel::Workspace workspace = equations.make_workspace();
  bool has_rates = false;
  for (const auto& [q, x] : points_of_motion(equations, box)) {
    equations.rhs(0.0, x, q, span_of(first), workspace);
    if (!first.allFinite()) continue;  // a place without rates says nothing
    has_rates = true;
    for (const double t : times) {
      equations.rhs(t, x, q, span_of(then), workspace);
      if (!((then - first).norm() <= 1e-10 * std::max(then.norm(), first.norm()))) return false;
    }
  }
  return has_rates;
}

void describe_equations(const ParametricModel& equations, FamilyInfo& info) {
  const ModelInfo& model = equations.model().info();
  for (const StateInfo& state : model.states) info.states.push_back(state.name);
  info.translations = translated_outputs(model, info.outputs);
  info.attitude = attitude_outputs(model, info.outputs);
  info.autonomous = is_autonomous(equations, info.coordinates);
}

}  // namespace samara::models
