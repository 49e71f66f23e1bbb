#include "samara/identification/problem/unknown_charts.h"

#include <optional>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

namespace samara::identification {

namespace {

/// Where the four initial values of the attitude begin among the own coordinates, if all are there, one after
/// the other. What is free of an attitude in part (the tilt alone, in codebooks) moves as any coordinate.
std::optional<std::size_t> own_attitude(const models::FamilyInfo& family, const FitProblem& problem) {
  if (family.attitude.empty()) return {};
  const std::optional<std::size_t> first = position(problem.own, family.attitude[0] + "(0)");
  if (!first || *first + family.attitude.size() > problem.own.size()) return {};
  for (std::size_t k = 0; k < family.attitude.size(); ++k) {
    if (problem.own[*first + k].name != family.attitude[k] + "(0)") return {};
  }
  return first;
}

}  // namespace

void add_charts(const models::FamilyInfo& family, const FitOptions& options, FitProblem& problem) {
  std::vector<Chart::Kind> kinds(problem.shared.size(), Chart::Kind::linear);
  for (const std::string& name : options.unknowns.log_scale) {
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
  const Chart::Kind turns = options.starts.round_body ? Chart::Kind::axis : Chart::Kind::quaternion;
  std::vector<Chart::Kind> own;
  for (std::size_t k = 0; k < static_cast<std::size_t>(problem.own_count()); ++k) {
    if (attitude && k > *attitude && k < *attitude + 4) continue;
    own.push_back(attitude && k == *attitude ? turns : Chart::Kind::linear);
  }
  problem.own_chart = Chart(own);
}

}  // namespace samara::identification
