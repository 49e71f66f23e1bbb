#include "samara/pgd/sampling/sampling_checks.h"

#include <cmath>
#include <set>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/sampling/leja.h"

namespace samara::pgd {

void check_sampling(const std::vector<SampledCoordinate>& coordinates,
                    const std::vector<OutputLabel>& outputs, const PointsFunction& function,
                    const SamplingOptions& o) {
  if (!function) throw ArgumentError("sampling of no function: an empty one was given");
  constexpr std::string_view kWhere = "sample";
  require(!coordinates.empty(), "the number of coordinates", coordinates.size(), "at least 1", kWhere);
  require(!outputs.empty(), "the number of outputs", outputs.size(), "at least 1", kWhere);
  std::set<std::string> names;
  for (const SampledCoordinate& c : coordinates) {
    if (!(std::isfinite(c.upper - c.lower) && c.lower < c.upper)) {
      throw ArgumentError(
          fmt::format("{} goes from {} to {}, expected an interval", c.label.name, c.lower, c.upper));
    }
    if (!in_domain(c.label.transform, c.lower) || !in_domain(c.label.transform, c.upper)) {
      throw ArgumentError(fmt::format("{} goes from {} to {}, which the transform {} does not allow",
                                      c.label.name, c.lower, c.upper, to_string(c.label.transform)));
    }
    if (!names.insert(c.label.name).second) {
      throw ArgumentError(fmt::format("two coordinates are named \"{}\"", c.label.name));
    }
  }
  require(o.tolerance > 0.0 && o.tolerance < 1.0, "tolerance", o.tolerance, "a number between 0 and 1",
          kWhere);
  require(o.max_calls >= 1, "max_calls", o.max_calls, "at least 1", kWhere);
  require(o.max_seconds >= 0.0, "max_seconds", o.max_seconds, "at least 0", kWhere);
  require(o.max_rank >= 1, "max_rank", o.max_rank, "at least 1", kWhere);
  require(o.max_nodes >= kFewestNodes && o.max_nodes <= kMostLejaPoints, "max_nodes", o.max_nodes, "3 to 128",
          kWhere);
  require(o.exploration_points >= 0, "exploration_points", o.exploration_points, "at least 0", kWhere);
  const auto rows = static_cast<Eigen::Index>(coordinates.size());
  if (o.start.size() > 0 && (o.start.rows() != rows || !o.start.allFinite())) {
    throw ArgumentError(fmt::format("SamplingOptions::start has {} coordinates, expected {} finite ones",
                                    o.start.rows(), rows));
  }
  const auto count = static_cast<Eigen::Index>(outputs.size());
  const bool floors = o.absolute.allFinite() && (o.absolute.array() >= 0.0).all();
  if (o.absolute.size() > 0 && (o.absolute.size() != count || !floors)) {
    throw ArgumentError(
        fmt::format("SamplingOptions::absolute has {} entries, expected {} finite ones of at least 0",
                    o.absolute.size(), count));
  }
}

}  // namespace samara::pgd
