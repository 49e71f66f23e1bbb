#include "samara/identification/problem/joins.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

namespace samara::identification {

namespace {

int requested_column(FitProblem& problem, const std::string& output) {
  const auto found = std::ranges::find(problem.requested, output);
  const auto column = static_cast<int>(found - problem.requested.begin());
  if (found == problem.requested.end()) problem.requested.push_back(output);
  return column;
}

/// The join of an output that the motion does not depend on, by its offset.
JoinRule join_of_offset(const models::FamilyInfo& family, const FitProblem& problem,
                        const std::string& output, int own, int column) {
  JoinRule rule{.kind = JoinRule::Kind::offset, .own = own, .column = column};
  const std::string start = output + "(0)";
  if (const auto slot = position(family.coordinates, start)) {
    rule.start_slot = static_cast<int>(*slot);
  } else if (const auto held = problem.fixed.find(start); held != problem.fixed.end()) {
    rule.start = held->second;
  }
  return rule;
}

/// What the motion does not depend on may begin anywhere, unless it is compared: then it needs an unknown.
void check_states(const models::FamilyInfo& family, const FitProblem& problem) {
  std::vector<std::string> outputs;
  for (const models::FamilyOutput& output : family.outputs) outputs.push_back(output.name);
  for (const std::string& state : family.states.empty() ? outputs : family.states) {
    if (position(problem.own, state + "(0)")) {
      if (contains(outputs, state)) continue;
      throw ArgumentError(
          fmt::format("segments start with the state in which the one before them ends, but \"{}\" is not "
                      "among the outputs of the {}",
                      state, family.source));
    }
    if (contains(family.translations, state)) {
      const auto compared = std::ranges::find(problem.outputs, state, &ComparedOutput::name);
      if (compared == problem.outputs.end() || compared->offset) continue;
      throw ArgumentError(
          fmt::format("segments start where the one before them ends, but of \"{0}\" each would start at the "
                      "same value; a box for \"{0}(0)\", free in each capture, or \"{0}\" among the offsets "
                      "was expected",
                      state));
    }
    throw ArgumentError(
        fmt::format("segments start with the state in which the one before them ends, but \"{}(0)\" is not a "
                    "free coordinate of each capture; a box for it was expected",
                    state));
  }
  if (!family.attitude.empty() && !problem.own_attitude) {
    throw ArgumentError(
        fmt::format("segments start with the attitude in which the one before them ends, whose parts are not "
                    "free one after the other; the order {} was expected",
                    join(family.attitude)));
  }
}

}  // namespace

void add_joins(const models::FamilyInfo& family, FitProblem& problem) {
  check_states(family, problem);
  const std::optional<std::size_t> attitude = problem.own_attitude;
  for (std::size_t k = 0; k < problem.own.size(); ++k) {
    const auto own = static_cast<int>(k);
    if (attitude && k == *attitude) {
      // The four stand one after the other where they are compared; elsewhere they are put so.
      int column = problem.attitude_column();
      if (!problem.attitude_scale) {
        column = static_cast<int>(problem.requested.size());
        for (const std::string& part : family.attitude) problem.requested.push_back(part);
      }
      problem.joins.push_back({.kind = JoinRule::Kind::turn, .own = own, .column = column});
    }
    if (attitude && k >= *attitude && k < *attitude + 4) continue;
    const std::string& name = problem.own[k].name;
    if (!problem.own[k].is_initial) {
      problem.joins.push_back({.kind = JoinRule::Kind::constant, .own = own});
      continue;
    }
    const std::string state = name.substr(0, name.size() - 3);  // without "(0)"
    problem.joins.push_back(
        {.kind = JoinRule::Kind::state, .own = own, .column = requested_column(problem, state)});
  }
  for (const ComparedOutput& output : problem.outputs) {
    if (!output.offset) continue;
    const auto own = static_cast<int>(problem.own.size()) + *output.offset;
    const bool moves =
        contains(family.translations, output.name) && !position(problem.own, output.name + "(0)");
    const int column = requested_column(problem, output.name);
    problem.joins.push_back(moves ? join_of_offset(family, problem, output.name, own, column)
                                  : JoinRule{.kind = JoinRule::Kind::constant, .own = own});
  }
  for (int k = problem.own_count() - problem.camera_count(); k < problem.own_count(); ++k) {
    problem.joins.push_back({JoinRule::Kind::constant, k, 0, 0.0});
  }
}

}  // namespace samara::identification
