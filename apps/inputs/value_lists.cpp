#include "inputs/value_lists.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "inputs/assignments.h"
#include "samara/base/errors.h"
#include "samara/base/text.h"

namespace samara::apps {

namespace {

std::vector<std::string> split_at(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.emplace_back(trimmed(std::string_view(text).substr(begin, end - begin)));
    begin = end + 1;
  }
  return parts;
}

std::vector<double> values_of(const std::string& option, std::vector<std::string> parts,
                              const std::string& unit) {
  const std::string last = unit_behind(parts.back());
  std::vector<double> values;
  for (std::string& part : parts) {
    if (!last.empty() && unit_behind(part).empty()) part += " " + last;
    values.push_back(number_or_quantity(option, part, unit));
  }
  return values;
}

/// 0.3 for 3 times 0.1, which is 0.30000000000000004: the nearest number of 15 digits, as people write them.
double as_typed(double value) {
  return std::strtod(fmt::format("{:.15g}", value).c_str(), nullptr);
}

std::vector<double> range_of(const std::string& option, const std::string& text,
                             const std::vector<double>& ends) {
  const double from = ends[0], step = ends[1], to = ends[2];
  const double steps = (to - from) / step;
  if (!(steps >= 0.0) || !std::isfinite(steps)) {
    throw ArgumentError(
        fmt::format("{} is {}, and no steps of {} lead from {} to {}; FROM:STEP:TO was expected", option,
                    text, step, from, to));
  }
  constexpr double kMost = 1e7;
  if (steps >= kMost)
    throw ArgumentError(
        fmt::format("{} is {}, {:.3g} numbers; at most {} were expected", option, text, steps + 1.0, kMost));
  constexpr double kRounding = 1e-9;  // of a step
  const auto count = static_cast<long>(std::floor(steps + kRounding));
  std::vector<double> values;
  for (long k = 0; k <= count; ++k) {
    const double value = from + static_cast<double>(k) * step;
    values.push_back(std::abs(value - to) <= kRounding * std::abs(step) ? to : as_typed(value));
  }
  return values;
}

}  // namespace

std::string unit_behind(const std::string& text) {
  const NumberPrefix number = read_number(text);
  return number.problem == NumberProblem::none
             ? std::string(trimmed(std::string_view(text).substr(number.length)))
             : "";
}

std::vector<double> numbers_of(const std::string& option, const std::string& text, const std::string& unit) {
  if (text.find(':') == std::string::npos) return values_of(option, split_at(text, ','), unit);
  const std::vector<std::string> parts = split_at(text, ':');
  if (parts.size() != 3)
    throw ArgumentError(fmt::format("{} is {}; FROM:STEP:TO was expected", option, text));
  return range_of(option, text, values_of(option, parts, unit));
}

std::vector<double> numbers_of(const std::string& option, const std::vector<std::string>& texts,
                               const std::string& unit) {
  std::vector<double> all;
  for (const std::string& text : texts) {
    const std::vector<double> some = numbers_of(option, text, unit);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

Eigen::VectorXd even_times(Eigen::Index count, double from, double to) {
  Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(count, from, to);
  for (Eigen::Index k = 1; k + 1 < count; ++k) times[k] = as_typed(times[k]);
  return times;
}

}  // namespace samara::apps
