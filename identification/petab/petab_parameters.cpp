#include "samara/identification/petab/petab_parameters.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/limits.h"
#include "samara/base/text.h"
#include "samara/identification/captures/number_cells.h"
#include "samara/identification/petab/petab_cells.h"

namespace samara::identification {

namespace {

using io::DelimitedTable;

double numeric(const DelimitedTable& table, std::size_t row, const std::string& column,
               const std::string& cell) {
  if (const auto number = number_in(cell)) return in_size(table, row, column, *number);
  throw table.error(row, fmt::format("{} is {}; a finite number was expected", column, in_quotes(cell)));
}

/// A uniform prior is no term of the objective: where it is narrower than the bounds, it bounds.
void narrow(const DelimitedTable& table, std::size_t row, PetabParameter& p) {
  std::vector<double> ends = std::exchange(p.prior_numbers, {});
  if (!ends.empty() && !(ends.size() == 2 && ends[0] < ends[1]))
    throw table.error(row,
                      fmt::format("objectivePriorParameters of a uniform prior are {} numbers; a lower and a "
                                  "higher one, or none, were expected",
                                  ends.size()));
  const bool is_of_logarithms = std::exchange(p.prior, {}) == "parameterScaleUniform";
  if (ends.empty()) return;
  for (double& end : ends) {
    if (is_of_logarithms && p.scale == "log") end = std::exp(end);
    if (is_of_logarithms && p.scale == "log10") end = std::pow(10.0, end);
  }
  p.lower = std::max(p.lower, ends[0]);
  p.upper = std::min(p.upper, ends[1]);
  if (!(p.lower < p.upper)) throw table.error(row, "the uniform prior and the bounds have nothing in common");
}

void read_prior(const DelimitedTable& table, std::size_t row, const std::string& numbers, PetabParameter& p) {
  require_word(table, row, "objectivePriorType", p.prior,
               {"uniform", "parameterScaleUniform", "normal", "parameterScaleNormal", "logNormal"});
  p.prior_numbers = numbers_in(table, row, numbers);
  for (const double number : p.prior_numbers) in_size(table, row, "one of objectivePriorParameters", number);
  if (p.prior.empty()) {
    if (!p.prior_numbers.empty())
      throw table.error(row, "objectivePriorParameters stand there without an objectivePriorType");
    return;
  }
  if (p.prior == "uniform" || p.prior == "parameterScaleUniform") return narrow(table, row, p);
  const bool is_on_log_scale = p.scale == "log" || p.scale == "log10";
  if (p.prior_numbers.size() != 2 || !(p.prior_numbers[1] > 0.0))
    throw table.error(row, "objectivePriorParameters are not a mean and a standard deviation above 0");
  if (p.prior == "logNormal") {
    // A density of the parameter, exp(-(ln x - m)^2/(2 s^2))/x: completing the square, its -log is
    // (ln x - m + s^2)^2/(2 s^2) but for a constant.
    p.prior_numbers[0] -= p.prior_numbers[1] * p.prior_numbers[1];
  } else if (p.prior == "parameterScaleNormal") {
    if (p.scale == "log10")
      for (double& number : p.prior_numbers) number *= std::log(10.0);
    p.prior = is_on_log_scale ? "logNormal" : "normal";
  }
  const double most = std::log(kLargestInput);
  if (p.prior == "logNormal" && !(std::abs(p.prior_numbers[0]) <= most))
    throw table.error(
        row, fmt::format("the prior is highest at exp({:.6g}); exp({:.0f}) to exp({:.0f}) was expected",
                         p.prior_numbers[0], -most, most));
}

}  // namespace

PetabParameters read_petab_parameters(const std::filesystem::path& path) {
  PetabParameters parameters;
  const DelimitedTable table = read_tsv(path, {"parameterId", "estimate"});
  const auto ids = table.texts("parameterId"), estimates = table.texts("estimate");
  const auto scales = cells_or_empty(table, "parameterScale"),
             nominal = cells_or_empty(table, "nominalValue");
  const auto lower = cells_or_empty(table, "lowerBound"), upper = cells_or_empty(table, "upperBound");
  const auto priors = cells_or_empty(table, "objectivePriorType"),
             numbers = cells_or_empty(table, "objectivePriorParameters");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    PetabParameter p{
        .id = ids[row], .scale = scales[row], .prior = priors[row], .line = table.line_of_row(row)};
    if (p.id.empty() || std::ranges::count(parameters.rows, p.id, &PetabParameter::id) > 0)
      throw table.error(row,
                        fmt::format("the parameter {} stands there twice, or has no name", in_quotes(p.id)));
    require_word(table, row, "parameterScale", p.scale, {"lin", "log", "log10"});
    if (estimates[row] != "0" && estimates[row] != "1")
      throw table.error(row, fmt::format("estimate is {}; 0 or 1 was expected", in_quotes(estimates[row])));
    p.estimated = estimates[row] == "1";
    if (!nominal[row].empty()) p.nominal = numeric(table, row, "nominalValue", nominal[row]);
    if (p.estimated) {
      p.lower = numeric(table, row, "lowerBound", lower[row]);
      p.upper = numeric(table, row, "upperBound", upper[row]);
      if (!(p.lower < p.upper))
        throw table.error(
            row, fmt::format("the bounds are {} and {}; lower < upper was expected", p.lower, p.upper));
      if (p.nominal && !(*p.nominal >= p.lower && *p.nominal <= p.upper))
        throw table.error(row, fmt::format("nominalValue {} lies outside the bounds", *p.nominal));
      read_prior(table, row, numbers[row], p);
    } else if (!p.nominal) {
      throw table.error(row, fmt::format("{} is not estimated, and has no nominalValue", in_quotes(p.id)));
    }
    parameters.rows.push_back(std::move(p));
  }
  parameters.columns = table.header();
  for (const std::string& column : table.header()) parameters.cells.push_back(table.texts(column));
  return parameters;
}

}  // namespace samara::identification
