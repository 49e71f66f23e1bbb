#include "samara/models/trajectories/model_symmetry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

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
  constexpr int kPoints = 8;
  const ModelInfo& info = equations.model().info();
  std::vector<double> x(info.states.size()), point(box.size());
  Eigen::VectorXd first(equations.state_count()), then(equations.state_count());
  const auto span_of = [](Eigen::VectorXd& f) {
    return std::span(f.data(), static_cast<std::size_t>(f.size()));
  };
  int number = 0;
  // Shares from -1/2 to 1/2 that follow no pattern of the equations.
  const auto next_share = [&] { return std::fmod(++number * std::numbers::phi, 1.0) - 0.5; };
  bool has_rates = false;
  for (int k = 0; k < kPoints; ++k) {
    // The middle of the box, then points off it and off their start: where a motion rests, or an amplitude is zero,
    // what depends on time may have no effect.
    const double off = k == 0 ? 0.0 : 1.0;
    for (std::size_t c = 0; c < box.size(); ++c)
      point[c] = box[c].lower + (0.5 + off * next_share()) * (box[c].upper - box[c].lower);
    equations.initial(point, x);
    const Scales scales = equations.scales(point);
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] += off * next_share() * state_scale(info.states[i], scales);
    for (const StateGroup& group : info.groups) {
      // The middle of the box of an attitude may be none.
      if (group.kind == StateGroupKind::quaternion) x[static_cast<std::size_t>(group.first)] += 1.0;
    }
    ParametricModel::Workspace workspace = equations.make_workspace();
    equations.rhs(0.0, x, point, span_of(first), workspace);
    if (!first.allFinite()) continue;  // a place without rates says nothing
    has_rates = true;
    for (const double t : kTimes) {
      equations.rhs(t, x, point, span_of(then), workspace);
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
