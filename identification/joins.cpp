#include "samara/identification/joins.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

namespace samara::identification {

namespace {

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::count(names, name) > 0;
}

/// Position of the coordinate of that name; the size of the list if there is none.
std::size_t position(const std::vector<FitCoordinate>& coordinates, const std::string& name) {
  return static_cast<std::size_t>(std::ranges::find(coordinates, name, &FitCoordinate::name) -
                                  coordinates.begin());
}

std::vector<std::string> names_of(const std::vector<FitCoordinate>& coordinates) {
  std::vector<std::string> names;
  for (const FitCoordinate& c : coordinates) names.push_back(c.name);
  return names;
}

/// Where the four initial values of the attitude begin among the own coordinates, if they are there.
/// @throws ArgumentError if only some are, or in another order.
std::optional<std::size_t> own_attitude(const FamilyInfo& family, const FitProblem& problem) {
  if (family.attitude.empty()) return {};
  const std::size_t first = position(problem.own, family.attitude[0] + "(0)");
  bool all = true;
  bool any = false;
  for (std::size_t k = 0; k < family.attitude.size(); ++k) {
    const std::size_t at = position(problem.own, family.attitude[k] + "(0)");
    any = any || at < problem.own.size();
    all = all && at == first + k;
  }
  if (!any) return {};
  if (all && first + 4 <= problem.own.size()) return first;
  throw ArgumentError(fmt::format(
      "of the initial attitude only a part is free in each capture; all of {}, one after the other, "
      "or none was expected",
      join(family.attitude)));
}

int requested_column(FitProblem& problem, const std::string& output) {
  const auto found = std::ranges::find(problem.requested, output);
  const auto column = static_cast<int>(found - problem.requested.begin());
  if (found == problem.requested.end()) problem.requested.push_back(output);
  return column;
}

/// What the output starts from where its initial value is held; 0 where nothing is said.
double held_start(const FitProblem& problem, const std::string& output) {
  const auto found = problem.fixed.find(output + "(0)");
  return found == problem.fixed.end() ? 0.0 : found->second;
}

void check_states(const FamilyInfo& family, const FitProblem& problem) {
  for (const FitOutput& output : family.outputs) {
    const bool own = position(problem.own, output.name + "(0)") < problem.own.size();
    if (own || contains(family.translations, output.name)) continue;
    throw ArgumentError(
        fmt::format("segments start with the state in which the one before them ends, but \"{}(0)\" is not a "
                    "free coordinate of each capture; a box for it was expected",
                    output.name));
  }
}

}  // namespace

void add_charts(const FamilyInfo& family, const FitOptions& options, FitProblem& problem) {
  std::vector<Chart::Kind> kinds(problem.shared.size(), Chart::Kind::linear);
  for (const std::string& name : options.log_scale) {
    const std::size_t at = position(problem.shared, name);
    if (at == problem.shared.size()) {
      throw ArgumentError(fmt::format("log_scale: \"{}\" is not a shared coordinate{}", name,
                                      suggestion(name, names_of(problem.shared))));
    }
    if (!(problem.shared[at].lower > 0.0)) {
      throw ArgumentError(
          fmt::format("log_scale: the box of \"{}\" begins at {}; a positive number was expected", name,
                      problem.shared[at].lower));
    }
    kinds[at] = Chart::Kind::logarithmic;
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
    const std::size_t shared = position(problem.shared, name);
    const std::size_t own = position(problem.own, name);
    const bool is_shared = shared < problem.shared.size();
    if (!is_shared && own == problem.own.size()) {
      std::vector<std::string> known = names_of(problem.shared);
      for (const std::string& other : names_of(problem.own)) known.push_back(other);
      throw ArgumentError(
          fmt::format("priors: \"{}\" is not a free coordinate{}", name, suggestion(name, known)));
    }
    if (!is_shared && problem.own_chart.is_part_of_quaternion(static_cast<int>(own))) {
      throw ArgumentError(fmt::format(
          "priors: \"{}\" is a part of an attitude; a coordinate that moves by itself was expected", name));
    }
    const FitCoordinate& c = is_shared ? problem.shared[shared] : problem.own[own];
    if (prior.logarithmic && !(c.lower > 0.0)) {
      throw ArgumentError(
          fmt::format("priors: \"{}\" has a logarithmic prior, but its box begins at {}; a positive number "
                      "was expected",
                      name, c.lower));
    }
    if (is_shared) {
      problem.priors.push_back({static_cast<int>(shared), prior});
    } else {
      problem.own_priors.push_back({static_cast<int>(own), prior});
    }
  }
}

void set_initial(const FitOptions& options, FitProblem& problem) {
  problem.initial.resize(problem.shared_count());
  for (std::size_t k = 0; k < problem.shared.size(); ++k) {
    problem.initial[static_cast<Eigen::Index>(k)] = 0.5 * (problem.shared[k].lower + problem.shared[k].upper);
  }
  for (const auto& [name, value] : options.initial) {
    const std::size_t at = position(problem.shared, name);
    if (at == problem.shared.size()) {
      throw ArgumentError(fmt::format("initial: \"{}\" is not a shared coordinate{}", name,
                                      suggestion(name, names_of(problem.shared))));
    }
    const FitCoordinate& c = problem.shared[at];
    if (!(value >= c.lower && value <= c.upper)) {
      throw ArgumentError(fmt::format("initial: \"{}\" is {}; a value in its box, {} to {}, was expected",
                                      name, value, c.lower, c.upper));
    }
    problem.initial[static_cast<Eigen::Index>(at)] = value;
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
      problem.joins.push_back({JoinRule::Kind::turn, own, column, 0.0});
    }
    if (attitude && k >= *attitude && k < *attitude + 4) continue;
    const std::string& name = problem.own[k].name;
    const std::string state = name.substr(0, name.size() - 3);  // without "(0)"
    problem.joins.push_back({JoinRule::Kind::state, own, requested_column(problem, state), 0.0});
  }
  for (const ComparedOutput& output : problem.outputs) {
    if (!output.offset) continue;
    const auto own = static_cast<int>(problem.own.size()) + *output.offset;
    const bool moves = contains(family.translations, output.name) &&
                       position(problem.own, output.name + "(0)") == problem.own.size();
    const int column = requested_column(problem, output.name);
    problem.joins.push_back({moves ? JoinRule::Kind::offset : JoinRule::Kind::constant, own, column,
                             held_start(problem, output.name)});
  }
  for (int k = problem.own_count() - problem.camera_count(); k < problem.own_count(); ++k) {
    problem.joins.push_back({JoinRule::Kind::constant, k, 0, 0.0});
  }
}

}  // namespace samara::identification
