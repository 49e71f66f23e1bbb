#include "samara/models/trajectories/model_symmetry.h"

#include <algorithm>
#include <array>
#include <cmath>

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

bool is_autonomous(const ParametricModel& equations, const std::vector<FamilyCoordinate>& box) {
  constexpr std::array kTimes = {0.37, 1.3, 7.9, 61.0};  // s
  std::vector<double> middle;
  for (const FamilyCoordinate& c : box) middle.push_back(0.5 * (c.lower + c.upper));
  std::vector<double> x(static_cast<std::size_t>(equations.state_count()));
  equations.initial(middle, x);
  for (const StateGroup& group : equations.model().info().groups) {
    // The middle of the box of an attitude may be none.
    if (group.kind == StateGroupKind::quaternion) x[static_cast<std::size_t>(group.first)] += 1.0;
  }
  ParametricModel::Workspace workspace = equations.make_workspace();
  Eigen::VectorXd first(equations.state_count());
  Eigen::VectorXd then(equations.state_count());
  const auto span_of = [](Eigen::VectorXd& f) {
    return std::span(f.data(), static_cast<std::size_t>(f.size()));
  };
  equations.rhs(0.0, x, middle, span_of(first), workspace);
  return std::ranges::all_of(kTimes, [&](double t) {
    equations.rhs(t, x, middle, span_of(then), workspace);
    // The middle of the box may be a place without rates: that says nothing.
    return !((then - first).norm() > 1e-10 * std::max(then.norm(), first.norm()));
  });
}

void describe_equations(const ParametricModel& equations, FamilyInfo& info) {
  const ModelInfo& model = equations.model().info();
  for (const StateInfo& state : model.states) info.states.push_back(state.name);
  info.translations = translated_outputs(model, info.outputs);
  info.attitude = attitude_outputs(model, info.outputs);
  info.autonomous = is_autonomous(equations, info.coordinates);
}

}  // namespace samara::models
