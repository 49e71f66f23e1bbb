#include "motion/pattern_points.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "inputs/assignments.h"
#include "motion/motion_answers.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/streams.h"
#include "samara/io/csv.h"
#include "samara/motion/sweeps/pattern_map.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

constexpr long kMostDraws = 1'000'000;

/// Points that lead to the pattern, a row each. @throws ArgumentError if no fall has it
Eigen::MatrixXd drawn_points(const PatternsArguments& arguments, const motion::PatternMap& map,
                             Eigen::Index coordinates) {
  const motion::Pattern pattern = motion::pattern_of(arguments.draw);
  const long count = arguments.count.value_or(1);
  if (count < 1 || count > kMostDraws)
    throw ArgumentError(fmt::format("--count is {}, expected 1 to {}", count, kMostDraws));
  Eigen::MatrixXd points(count, coordinates);
  for (long n = 0; n < count; ++n) {
    // Each has a stream of its own, so that the first ones do not depend on how many there are.
    Stream stream(arguments.seed.value_or(1), static_cast<std::uint64_t>(n));
    points.row(n) = map.draw(pattern, stream).transpose();
  }
  return points;
}

/// The point of the call. @throws ArgumentError for a coordinate that is unknown or missing
Eigen::VectorXd given_point(const PatternsArguments& arguments, const motion::Sweep& sweep) {
  std::map<std::string, std::string> units;
  for (std::size_t k = 0; k < sweep.names.size(); ++k) units[sweep.names[k]] = sweep.units[k];
  const std::map<std::string, double> values = parse_assignments(arguments.set, units);
  Eigen::VectorXd point(static_cast<Eigen::Index>(sweep.names.size()));
  for (std::size_t k = 0; k < sweep.names.size(); ++k) {
    const auto found = values.find(sweep.names[k]);
    if (found == values.end())
      throw ArgumentError(fmt::format("--clamp has no value of {}: --set of all of {} was expected",
                                      sweep.names[k], join(sweep.names)));
    point[static_cast<Eigen::Index>(k)] = found->second;
  }
  return point;
}

std::string points_csv(const motion::Sweep& sweep, const Eigen::MatrixXd& points) {
  std::vector<std::string> header;
  for (std::size_t k = 0; k < sweep.names.size(); ++k)
    header.push_back(fmt::format("{}[{}]", sweep.names[k], sweep.units[k]));
  return io::format_csv(header, points);
}

Json points_json(const PatternsArguments& arguments, const motion::Sweep& sweep,
                 const motion::PatternMap& map, const Eigen::MatrixXd& points) {
  Json object = {{"schema", "samara-pattern-points/1"},
                 {"wanted", arguments.draw.empty() ? arguments.clamp : arguments.draw},
                 {"release", release_text(sweep, arguments.release.value_or(0))},
                 {"coordinates", sweep.names},
                 {"units", sweep.units},
                 {"points", Json::array()}};
  if (!arguments.draw.empty()) object["seed"] = arguments.seed.value_or(1);
  for (const auto& row : points.rowwise()) {
    const motion::MapAnswer there = map.at(row.transpose());
    object["points"].push_back({{"values", std::vector<double>(row.begin(), row.end())},
                                {"pattern", to_string(there.pattern)},
                                {"probability", there.probability},
                                {"distance_to_border", number_or_null(there.distance_to_border)}});
  }
  return object;
}

}  // namespace

bool asks_for_points(const PatternsArguments& arguments) {
  return !arguments.draw.empty() || !arguments.clamp.empty();
}

void check_point_words(const PatternsArguments& arguments) {
  if (!arguments.draw.empty() && !arguments.clamp.empty())
    throw ArgumentError("--draw and --clamp were given: one of them was expected");
  if (arguments.draw.empty() && (arguments.count || arguments.seed))
    throw ArgumentError("--count and --seed are of draws: --draw was expected");
  if (!asks_for_points(arguments) && arguments.release)
    throw ArgumentError("--release is of points of the map: --draw or --clamp was expected");
  if (!arguments.draw.empty() && !arguments.set.empty())
    throw ArgumentError("--set is of the point that --clamp moves, and --draw was given: none was expected");
  if (asks_for_points(arguments) && !arguments.report.empty())
    throw ArgumentError("--report is of the whole sweep: neither --draw nor --clamp was expected with it");
  if (asks_for_points(arguments) && arguments.clusters)
    throw ArgumentError("--clusters is of the whole sweep: neither --draw nor --clamp was expected with it");
}

int points_of_map(const PatternsArguments& arguments, const motion::Sweep& sweep) {
  const motion::PatternMap map(sweep, arguments.release.value_or(0));
  Eigen::MatrixXd points;
  if (!arguments.draw.empty()) {
    points = drawn_points(arguments, map, static_cast<Eigen::Index>(sweep.names.size()));
  } else {
    const Eigen::VectorXd point = given_point(arguments, sweep);
    points = map.clamp(motion::pattern_of(arguments.clamp), point).transpose();
    if (points.row(0) == point.transpose()) narrate("the point leads to this pattern as it is");
  }
  write_answer(arguments.output, arguments.json ? json_line(points_json(arguments, sweep, map, points))
                                                : points_csv(sweep, points));
  return kDone;
}

}  // namespace samara::apps
