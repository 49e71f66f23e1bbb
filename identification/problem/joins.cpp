#include "samara/identification/problem/joins.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/trajectories/coordinate_names.h"

namespace samara::identification {

namespace {

/// Where the four initial values of the attitude begin among the own coordinates, if all are there, one after
/// the other. What is free of an attitude in part (the tilt alone, in codebooks) moves as any coordinate.
std::optional<std::size_t> own_attitude(const FamilyInfo& family, const FitProblem& problem) {
  if (family.attitude.empty()) return {};
  const std::optional<std::size_t> first = position(problem.own, family.attitude[0] + "(0)");
  if (!first || *first + family.attitude.size() > problem.own.size()) return {};
  for (std::size_t k = 0; k < family.attitude.size(); ++k) {
    if (problem.own[*first + k].name != family.attitude[k] + "(0)") return {};
  }
  return first;
}

int requested_column(FitProblem& problem, const std::string& output) {
  const auto found = std::ranges::find(problem.requested, output);
  const auto column = static_cast<int>(found - problem.requested.begin());
  if (found == problem.requested.end()) problem.requested.push_back(output);
  return column;
}

/// The join of an output that the motion does not depend on, by its offset.
JoinRule join_of_offset(const FamilyInfo& family, const FitProblem& problem, const std::string& output,
                        int own, int column) {
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
void check_states(const FamilyInfo& family, const FitProblem& problem) {
  std::vector<std::string> outputs;
  for (const FitOutput& output : family.outputs) outputs.push_back(output.name);
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
  if (!family.attitude.empty() && !own_attitude(family, problem)) {
    throw ArgumentError(
        fmt::format("segments start with the attitude in which the one before them ends, whose parts are not "
                    "free one after the other; the order {} was expected",
                    join(family.attitude)));
  }
}

}  // namespace

void add_charts(const FamilyInfo& family, const FitOptions& options, FitProblem& problem) {
  std::vector<Chart::Kind> kinds(problem.shared.size(), Chart::Kind::linear);
  for (const std::string& name : options.log_scale) {
    const std::optional<std::size_t> at = position(problem.shared, name);
    if (!at) {
      throw ArgumentError(fmt::format("log_scale: \"{}\" is not a shared coordinate{}", name,
                                      suggestion(name, names_of(problem.shared))));
    }
    if (!(problem.shared[*at].lower > 0.0)) {
      throw ArgumentError(
          fmt::format("log_scale: the box of \"{}\" begins at {}; a positive number was expected", name,
                      problem.shared[*at].lower));
    }
    kinds[*at] = Chart::Kind::logarithmic;
  }
  problem.shared_chart = Chart(kinds);

  const std::optional<std::size_t> attitude = own_attitude(family, problem);
  problem.own_attitude = attitude;
  const Chart::Kind turns = options.round_body ? Chart::Kind::axis : Chart::Kind::quaternion;
  std::vector<Chart::Kind> own;
  for (std::size_t k = 0; k < static_cast<std::size_t>(problem.own_count()); ++k) {
    if (attitude && k > *attitude && k < *attitude + 4) continue;
    own.push_back(attitude && k == *attitude ? turns : Chart::Kind::linear);
  }
  problem.own_chart = Chart(own);
}

void add_priors(const FitOptions& options, FitProblem& problem) {
  for (const auto& [name, prior] : options.priors) {
    if (options.known.contains(name)) continue;
    const std::optional<std::size_t> shared = position(problem.shared, name);
    const std::optional<std::size_t> own = position(problem.own, name);
    if (!shared && !own) {
      std::vector<std::string> known = names_of(problem.shared);
      for (const std::string& other : names_of(problem.own)) known.push_back(other);
      throw ArgumentError(
          fmt::format("priors: \"{}\" is not a free coordinate{}", name, suggestion(name, known)));
    }
    if (own && problem.own_chart.is_part_of_quaternion(static_cast<int>(*own))) {
      throw ArgumentError(fmt::format(
          "priors: \"{}\" is a part of an attitude; a coordinate that moves by itself was expected", name));
    }
    const FitCoordinate& c = shared ? problem.shared[*shared] : problem.own[*own];
    if (prior.logarithmic && !(c.lower > 0.0)) {
      throw ArgumentError(
          fmt::format("priors: \"{}\" has a logarithmic prior, but its box begins at {}; a positive number "
                      "was expected",
                      name, c.lower));
    }
    if (shared) {
      problem.priors.push_back({static_cast<int>(*shared), prior});
    } else {
      problem.own_priors.push_back({static_cast<int>(*own), prior});
    }
  }
  for (const CombinationPrior& prior : options.combinations) {
    SharedCombination combination{.mean = prior.mean, .deviation = prior.deviation};
    for (const auto& [name, weight] : prior.weights) {
      const std::optional<std::size_t> shared = position(problem.shared, name);
      if (!shared) {
        throw ArgumentError(fmt::format("combinations: \"{}\" is not a shared coordinate{}", name,
                                        suggestion(name, names_of(problem.shared))));
      }
      combination.terms.emplace_back(static_cast<int>(*shared), weight);
    }
    problem.combinations.push_back(std::move(combination));
  }
}

void set_initial(const FitOptions& options, FitProblem& problem) {
  problem.initial.resize(problem.shared_count());
  for (std::size_t k = 0; k < problem.shared.size(); ++k) {
    const FitCoordinate& c = problem.shared[k];
    problem.initial[static_cast<Eigen::Index>(k)] = problem.shared_chart.is_logarithmic(static_cast<int>(k))
                                                        ? std::sqrt(c.lower * c.upper)
                                                        : 0.5 * (c.lower + c.upper);
  }
  for (const auto& [name, value] : options.initial) {
    const std::optional<std::size_t> at = position(problem.shared, name);
    if (!at) {
      throw ArgumentError(fmt::format("initial: \"{}\" is not a shared coordinate{}", name,
                                      suggestion(name, names_of(problem.shared))));
    }
    const FitCoordinate& c = problem.shared[*at];
    if (!(value >= c.lower && value <= c.upper)) {
      throw ArgumentError(fmt::format("initial: \"{}\" is {}; a value in its box, {} to {}, was expected",
                                      name, value, c.lower, c.upper));
    }
    problem.initial[static_cast<Eigen::Index>(*at)] = value;
  }
}

void add_joins(const FamilyInfo& family, FitProblem& problem) {
  check_states(family, problem);
  const std::optional<std::size_t> attitude = own_attitude(family, problem);
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
