#include "samara/identification/petab/petab_result.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace samara::identification {

namespace {

struct Found {
  double value = 0.0;
  std::optional<double> error = {};
};

/// What the fit says of a parameter; nothing of one that it held.
std::optional<Found> found_of(const PetabParameter& p, const FitResult& fit) {
  if (!p.noise_of.empty()) {
    for (const NoiseLevel& level : fit.noise) {
      if (level.estimated && std::ranges::count(level.outputs, p.noise_of) > 0)
        return Found{level.value, level.standard_error()};
    }
    return {};
  }
  if (p.condition.empty()) {
    const auto c = std::ranges::find(fit.coefficients, p.coordinate, &Coefficient::name);
    if (c == fit.coefficients.end()) return {};
    return Found{c->value, c->standard_error ? c->standard_error : c->naive_standard_error};
  }
  for (const CaptureFit& capture : fit.captures) {
    const auto label = capture.labels.find(kPetabCondition);
    if (label == capture.labels.end() || label->second != p.condition) continue;
    const auto own = std::ranges::find(capture.nuisances, p.coordinate, &Nuisance::name);
    if (own != capture.nuisances.end()) return Found{own->value, own->standard_error};
  }
  return {};
}

/// A cell of a table that tabs part.
std::string tsv_cell(const std::string& cell) {
  if (cell.find_first_of("\t\"\r\n") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::string tsv_line(std::vector<std::string> cells) {
  for (std::string& cell : cells) cell = tsv_cell(cell);
  return fmt::format("{}\n", fmt::join(cells, "\t"));
}

std::size_t column_named(std::vector<std::string>& columns, const std::string& name) {
  const auto found = std::ranges::find(columns, name);
  const auto place = static_cast<std::size_t>(found - columns.begin());
  if (found == columns.end()) columns.push_back(name);
  return place;
}

}  // namespace

std::string petab_parameters(const PetabProblem& problem, const FitResult& fit) {
  std::vector<std::string> columns = problem.parameter_columns;
  const std::size_t value_column = column_named(columns, "nominalValue"),
                    error_column = column_named(columns, "standardError");
  std::string text = tsv_line(columns);
  for (std::size_t row = 0; row < problem.parameters.size(); ++row) {
    const PetabParameter& p = problem.parameters[row];
    std::vector<std::string> cells(columns.size());
    for (std::size_t c = 0; c < problem.parameter_cells.size(); ++c)
      cells[c] = problem.parameter_cells[c][row];
    cells[error_column].clear();
    if (const std::optional<Found> found = p.estimated ? found_of(p, fit) : std::nullopt) {
      // Within the bounds, as readers of such tables want it: noise is estimated without them.
      const double value = std::clamp(found->value, p.lower, p.upper);
      cells[value_column] = fmt::format("{}", value);
      const bool has_error =
          found->error && std::isfinite(*found->error) && (p.noise_of.empty() || value == found->value);
      if (has_error) cells[error_column] = fmt::format("{}", *found->error);
    }
    text += tsv_line(cells);
  }
  return text;
}

std::vector<std::string> petab_noise_outside_bounds(const PetabProblem& problem, const FitResult& fit) {
  std::vector<std::string> sentences;
  for (const PetabParameter& p : problem.parameters) {
    if (!p.estimated || p.noise_of.empty()) continue;
    const std::optional<Found> found = found_of(p, fit);
    if (!found || (found->value >= p.lower && found->value <= p.upper)) continue;
    sentences.push_back(
        fmt::format("the noise level {} was estimated as {:.4g}, outside its bounds of {} to {}: levels are "
                    "estimated without "
                    "bounds, and the PEtab table gets the nearest one",
                    p.id, found->value, p.lower, p.upper));
  }
  return sentences;
}

std::string petab_simulations(const PetabProblem& problem, const FitResult& fit) {
  std::string text = "observableId\tsimulationConditionId\ttime\tsimulation\n";
  for (const CaptureFit& capture : fit.captures) {
    const std::string& condition = capture.labels.at(kPetabCondition);
    for (Eigen::Index frame = 0; frame < capture.times.size(); ++frame) {
      // The turns of attitudes are residuals without a column.
      for (Eigen::Index column = 0; column < capture.measured.cols(); ++column) {
        if (std::isnan(capture.measured(frame, column))) continue;
        const std::string& output = capture.residuals[static_cast<std::size_t>(column)].output;
        text += fmt::format("{}\t{}\t{}\t{}\n", problem.observables.at(output), condition,
                            capture.times[frame], capture.model(frame, column));
      }
    }
  }
  return text;
}

}  // namespace samara::identification
