#include "samara/identification/coefficient_series.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/fit.h"
#include "samara/identification/reference_trajectories.h"
#include "samara/identification/series_knots.h"
#include "samara/identification/series_windows.h"
#include "samara/identification/step_trajectories.h"

namespace samara::identification {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Sizes of a difference between neighbours, over the constant value, that are tried: from no change that
/// could be seen to any.
constexpr std::array kFactors = {1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0};
/// A standard error in half boxes beyond which the box says more: that of a uniform distribution.
const double kUniform = 1.0 / std::sqrt(3.0);

/// @throws ArgumentError unless the coefficient is a free parameter with one value.
void check_coefficient(const models::ModelInfo& model, const FitOptions& options, const std::string& name) {
  std::vector<std::string> known;
  for (const models::ParameterInfo& parameter : model.parameters) known.push_back(parameter.name);
  if (std::ranges::count(known, name) == 0) {
    throw ArgumentError(
        fmt::format("series: model \"{}\" has no parameter \"{}\" that could change in time{}", model.name,
                    name, suggestion(name, known)));
  }
  if (options.fixed.contains(name) || options.known.contains(name) ||
      std::ranges::count(options.per_capture, name) > 0) {
    throw ArgumentError(fmt::format(
        "series: \"{}\" is fixed, known or of each capture's own; a coefficient of the box was expected",
        name));
  }
  if (!options.box.contains(name)) {
    throw ArgumentError(
        fmt::format("series: \"{}\" has no interval in the box, which is to hold at every instant", name));
  }
}

std::unique_ptr<TrajectoryFamily> constant_family(const std::shared_ptr<const models::Model>& model,
                                                  const FitOptions& options) {
  return options.step ? step_trajectories(model, options.fixed, options.box, *options.step)
                      : reference_trajectories(model, options.fixed, options.box);
}

/// A fit of the windows.
FitOptions options_of_windows(const FitOptions& options, const SeriesWindows& windows,
                              const SeriesOptions& series) {
  FitOptions result = options;
  result.window.reset();
  result.profiles = false;
  if (!windows.joined) {
    result.segments.length = std::numeric_limits<double>::max();
  } else if (!result.segments.length) {
    result.segments.length = series.window;
  }
  // A frame in m windows counts m times by 1/m.
  const double scale = std::sqrt(windows.overlap);
  result.loss.length_scale *= scale;
  for (auto& [name, value] : result.loss.scales) value *= scale;
  result.attitude_scale *= scale;
  return result;
}

/// What is said of a coefficient is said of its values at the instants: starts and logarithms of each, priors
/// of their mean.
FitOptions options_of_knots(FitOptions options, const SeriesKnots& knots) {
  for (std::size_t c = 0; c < knots.coefficients.size(); ++c) {
    const std::string& name = knots.coefficients[c];
    std::vector<std::string> names;
    for (int k = 0; k < knots.count(); ++k) names.push_back(knots.name(c, k));
    const auto replace = [&](std::vector<std::string>& list) {
      if (std::erase(list, name) > 0) list.insert(list.end(), names.begin(), names.end());
    };
    replace(options.shared);
    replace(options.log_scale);
    options.initial.erase(name);
    options.box.erase(name);
    if (const auto prior = options.priors.extract(name)) {
      const Prior& known = prior.mapped();
      CombinationPrior mean{.mean = known.mean,
                            .deviation = known.logarithmic ? known.mean * known.deviation : known.deviation};
      for (const std::string& knot : names) mean.weights[knot] = 1.0 / knots.count();
      options.combinations.push_back(std::move(mean));
    }
  }
  options.starts = 1;
  options.global = {};
  // Coefficients begin near their best constants: joins need not be so loose.
  if (options.segments.stages.size() > 3)
    options.segments.stages.erase(options.segments.stages.begin(), options.segments.stages.end() - 3);
  return options;
}

const Coefficient& coefficient_of(const FitResult& fit, const std::string& name) {
  return *std::ranges::find(fit.coefficients, name, &Coefficient::name);
}

/// Fits of one series at different smoothness.
class SeriesFits {
 public:
  SeriesFits(const std::shared_ptr<const models::Model>& model, const SeriesWindows& windows,
             const FitOptions& options, const SeriesOptions& series, const FitResult& constant)
      : windows_(windows),
        series_(series),
        options_(options_of_knots(options, windows.knots)),
        family_(knot_trajectories(model, options.fixed, options.box, options.step, windows.knots)),
        rows_(difference_rows(windows.knots.instants, series.order, windows.spacing)) {
    const SeriesKnots& knots = windows.knots;
    for (std::size_t c = 0; c < knots.coefficients.size(); ++c) {
      const Coefficient& best = coefficient_of(constant, knots.coefficients[c]);
      const double half_box = 0.5 * (best.upper - best.lower);
      constants_.push_back(best.value);
      sizes_.push_back(std::max(std::abs(best.value), 0.1 * half_box));
      half_boxes_.push_back(half_box);
      for (int k = 0; k < knots.count(); ++k) options_.initial[knots.name(c, k)] = best.value;
    }
    for (const Coefficient& c : constant.coefficients) {
      if (std::ranges::count(knots.coefficients, c.name) == 0) options_.initial[c.name] = c.value;
    }
  }

  /// Whether a factor means anything.
  bool has_free_scales() const {
    return std::ranges::any_of(windows_.knots.coefficients,
                               [&](const std::string& name) { return !series_.scales.contains(name); });
  }

  double scale(std::size_t c, double factor) const {
    const auto given = series_.scales.find(windows_.knots.coefficients[c]);
    return given == series_.scales.end() ? factor * sizes_[c] : given->second;
  }

  FitResult fit_with(double factor) {
    FitOptions options = options_;
    for (std::size_t c = 0; c < windows_.knots.coefficients.size(); ++c) {
      for (Eigen::Index row = 0; row < rows_.rows(); ++row) {
        CombinationPrior difference{.deviation = scale(c, factor)};
        for (int k = 0; k < windows_.knots.count(); ++k) {
          if (rows_(row, k) != 0.0) difference.weights[windows_.knots.name(c, k)] = rows_(row, k);
        }
        options.combinations.push_back(std::move(difference));
      }
    }
    FitResult result = fit(*family_, windows_.captures, options);
    if (result.status != FitStatus::failed) {
      for (const Coefficient& c : result.coefficients) options_.initial[c.name] = c.value;
    }
    return result;
  }

  /// What a fit says of all its values.
  struct Judgement {
    std::vector<int> free = {};       ///< coefficients of the fit that are at no bound
    Eigen::MatrixXd resolution = {};  ///< of the free ones
    Eigen::VectorXd variance = {};    ///< of the free ones, frames taken as independent
    double effective = 0.0;
    double criterion = kNaN;
  };

  Judgement judge(const FitResult& result, double factor) const {
    Judgement judgement;
    const auto count = static_cast<Eigen::Index>(result.coefficients.size());
    Eigen::MatrixXd differences = Eigen::MatrixXd::Zero(count, count);
    double penalty = 0.0;
    for (std::size_t c = 0; c < windows_.knots.coefficients.size(); ++c) {
      const std::vector<int> at = places(result, c);
      const double s = scale(c, factor);
      differences(at, at) += rows_.transpose() * rows_ / (s * s);
      penalty += (rows_ * values(result, at)).squaredNorm() / (s * s);
    }
    for (int k = 0; k < static_cast<int>(count); ++k) {
      if (!result.coefficients[static_cast<std::size_t>(k)].at_bound) judgement.free.push_back(k);
    }
    const std::vector<int>& free = judgement.free;
    Eigen::VectorXd size(static_cast<Eigen::Index>(free.size()));
    for (std::size_t k = 0; k < free.size(); ++k) {
      const Coefficient& c = result.coefficients[static_cast<std::size_t>(free[k])];
      size[static_cast<Eigen::Index>(k)] = 0.5 * (c.upper - c.lower);
    }
    const Eigen::MatrixXd whole = size.asDiagonal() * result.information(free, free) * size.asDiagonal();
    const Eigen::MatrixXd smooth = size.asDiagonal() * differences(free, free) * size.asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> factorised(whole);
    if (factorised.info() != Eigen::Success) return judgement;
    const Eigen::MatrixXd inverse = factorised.solve(Eigen::MatrixXd::Identity(whole.rows(), whole.cols()));
    judgement.resolution = inverse * (whole - smooth);
    judgement.effective = judgement.resolution.trace();

    const double residual_count = result.residual_count / windows_.overlap;
    const double own = own_unknowns(result);
    const double left = std::max(1.0, residual_count - own - judgement.effective);
    const double total = 2.0 * result.cost;
    judgement.variance =
        std::max(0.0, total - penalty) / left * inverse.diagonal().cwiseProduct(size.cwiseAbs2());
    const auto series = static_cast<double>(windows_.knots.coefficients.size());
    const double straight = static_cast<double>(count) - series * static_cast<double>(rows_.rows());
    const double log_determinant = 2.0 * Eigen::MatrixXd(factorised.matrixL()).diagonal().array().log().sum();
    judgement.criterion = (residual_count - own - straight) * std::log(total) + log_determinant +
                          2.0 * static_cast<double>(rows_.rows()) * free_scales() * std::log(factor);
    return judgement;
  }

  SeriesCoefficient describe(const FitResult& result, std::size_t c, double factor,
                             const Judgement& judgement, double growth) const {
    const std::vector<int> at = places(result, c);
    const Coefficient& first = result.coefficients[static_cast<std::size_t>(at.front())];
    const auto count = static_cast<Eigen::Index>(at.size());
    SeriesCoefficient series{.name = windows_.knots.coefficients[c],
                             .unit = first.unit,
                             .scale = scale(c, factor),
                             .constant = constants_[c],
                             .values = values(result, at),
                             .standard_errors = Eigen::VectorXd::Constant(count, kNaN),
                             .shares = Eigen::VectorXd::Zero(count)};
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto free = std::ranges::find(judgement.free, at[static_cast<std::size_t>(k)]);
      if (free == judgement.free.end()) {
        series.basis.push_back(InstantBasis::bound);
        continue;
      }
      const Eigen::Index place = free - judgement.free.begin();
      const double error =
          judgement.variance.size() > 0 ? growth * std::sqrt(judgement.variance[place]) : kNaN;
      if (!(error < kUniform * half_boxes_[c])) {
        series.basis.push_back(InstantBasis::nothing);
        continue;
      }
      series.standard_errors[k] = error;
      series.shares[k] = judgement.resolution(place, place);
      series.basis.push_back(series.shares[k] < 0.5 ? InstantBasis::neighbours : InstantBasis::frames);
    }
    return series;
  }

 private:
  double free_scales() const {
    return static_cast<double>(
        std::ranges::count_if(windows_.knots.coefficients,
                              [&](const std::string& name) { return !series_.scales.contains(name); }));
  }

  std::vector<int> places(const FitResult& result, std::size_t c) const {
    std::vector<int> at;
    for (int k = 0; k < windows_.knots.count(); ++k) {
      const auto found =
          std::ranges::find(result.coefficients, windows_.knots.name(c, k), &Coefficient::name);
      at.push_back(static_cast<int>(found - result.coefficients.begin()));
    }
    return at;
  }

  static Eigen::VectorXd values(const FitResult& result, const std::vector<int>& at) {
    Eigen::VectorXd values(static_cast<Eigen::Index>(at.size()));
    for (std::size_t k = 0; k < at.size(); ++k) {
      values[static_cast<Eigen::Index>(k)] = result.coefficients[static_cast<std::size_t>(at[k])].value;
    }
    return values;
  }

  /// Of all windows, by their share; a quaternion moves in three directions.
  double own_unknowns(const FitResult& result) const {
    const std::vector<std::string>& attitude = family_->info().attitude;
    double count = 0.0;
    for (const CaptureFit& capture : result.captures) {
      for (const Nuisance& n : capture.nuisances) {
        if (n.at_bound || (!attitude.empty() && n.name == attitude.front() + "(0)")) continue;
        count += 1.0;
      }
    }
    return count / windows_.overlap;
  }

  const SeriesWindows& windows_;
  const SeriesOptions& series_;
  FitOptions options_;
  std::unique_ptr<TrajectoryFamily> family_;
  Eigen::MatrixXd rows_;
  std::vector<double> constants_, sizes_, half_boxes_;  ///< of the coefficients
};

/// The fit of the best smoothness.
struct Chosen {
  double factor = 1.0;
  FitResult fit = {};
  SeriesFits::Judgement judgement = {};
};

Chosen choose(SeriesFits& fits, std::vector<SmoothnessTrial>& trials) {
  Chosen best;
  int worse = 0;
  for (const double factor : kFactors) {
    FitResult result = fits.fit_with(factor);
    if (result.status == FitStatus::failed) {
      trials.push_back({factor, kNaN, 0.0});
      if (best.fit.status == FitStatus::failed) best.fit = std::move(result);
      continue;
    }
    SeriesFits::Judgement judgement = fits.judge(result, factor);
    trials.push_back({factor, judgement.criterion, judgement.effective});
    const bool first = best.fit.status == FitStatus::failed;
    if (first || judgement.criterion < best.judgement.criterion) {
      best = {factor, std::move(result), std::move(judgement)};
      worse = 0;
    } else if (++worse == 2) {
      break;
    }
  }
  return best;
}

/// By how much errors grow where residuals are correlated; whiteness.h.
double growth_of_errors(const FitResult& result) {
  if (!result.whiteness || !result.whiteness->p_value || *result.whiteness->p_value > 0.05) return 1.0;
  const double r = std::clamp(result.whiteness->median_lag1, 0.0, 0.95);
  return std::sqrt((1.0 + r) / (1.0 - r));
}

/// Everything a simulation of the first capture needs besides the series.
void add_replay(const models::ModelInfo& model, const FitResult& result, const SeriesKnots& knots,
                const FitOptions& options, CoefficientSeries& series) {
  std::map<std::string, std::string> units;
  for (const models::ParameterInfo& parameter : model.parameters) units[parameter.name] = parameter.unit;
  for (const models::StateInfo& state : model.states) units[state.name + "(0)"] = state.unit;
  series.replay = options.fixed;
  for (const Coefficient& c : result.coefficients) {
    if (units.contains(c.name) && std::ranges::count(knots.coefficients, c.name) == 0)
      series.replay[c.name] = c.value;
  }
  // The state of a running mean of frames is before the first of them.
  if (options.averaged_frames == 1) {
    constexpr std::string_view kOffset = "offset of ";
    for (const Nuisance& n : result.captures.front().nuisances) {
      if (units.contains(n.name)) series.replay[n.name] = n.value;
      if (n.name.starts_with(kOffset)) series.replay[n.name.substr(kOffset.size()) + "(0)"] += n.value;
    }
  }
  for (const auto& [name, value] : series.replay) series.replay_units[name] = units.at(name);
}

void add_series_warnings(CoefficientSeries& series) {
  series.warnings = series.fit.warnings;
  if (series.factor == kFactors.front()) {
    series.warnings.push_back(
        "the captures show no change of the coefficients in time: the smoothest series that was tried is the "
        "likeliest");
  }
  if (series.factor == kFactors.back()) {
    series.warnings.push_back(
        "the roughest series that was tried is the likeliest: values at neighbouring instants are not held "
        "together, and a shorter window may be needed");
  }
  if (series.correlation_factor > 1.0) {
    series.warnings.push_back(
        fmt::format("residuals are correlated from frame to frame; standard errors are {:.2g} times those of "
                    "independent frames",
                    series.correlation_factor));
  }
  for (const SeriesCoefficient& c : series.coefficients) {
    const auto nothing = std::ranges::count(c.basis, InstantBasis::nothing);
    if (nothing > 0) {
      series.warnings.push_back(fmt::format("the captures do not determine {} at {} of {} instants", c.name,
                                            nothing, c.values.size()));
    }
  }
}

}  // namespace

std::string to_string(InstantBasis basis) {
  switch (basis) {
    case InstantBasis::frames:
      return "frames";
    case InstantBasis::neighbours:
      return "neighbours";
    case InstantBasis::bound:
      return "bound";
    case InstantBasis::nothing:
      return "nothing";
  }
  return {};
}

void validate(const SeriesOptions& options) {
  if (options.coefficients.empty()) {
    throw ArgumentError(
        "series.coefficients is empty; at least one parameter that changes along the captures was expected");
  }
  const auto require_positive = [](const std::string& field, double value) {
    if (!(value > 0.0 && std::isfinite(value)))
      throw ArgumentError(fmt::format("{} is {}; more than 0 was expected", field, value));
  };
  require_positive("series.window", options.window);
  if (options.stride) require_positive("series.stride", *options.stride);
  if (options.stride && *options.stride > options.window) {
    throw ArgumentError(
        fmt::format("series.stride is {}, and series.window {}; a stride of at most the window "
                    "was expected",
                    *options.stride, options.window));
  }
  if (options.order != 1 && options.order != 2)
    throw ArgumentError(fmt::format("series.order is {}; 1 or 2 was expected", options.order));
  for (const auto& [name, scale] : options.scales) {
    require_positive(fmt::format("the smoothness of \"{}\" in series", name), scale);
    if (std::ranges::count(options.coefficients, name) > 0) continue;
    throw ArgumentError(fmt::format("series has a smoothness of \"{}\", which is none of its coefficients{}",
                                    name, suggestion(name, options.coefficients)));
  }
}

CoefficientSeries fit_series(const std::shared_ptr<const models::Model>& model,
                             std::span<const Capture> captures, const FitOptions& options,
                             const SeriesOptions& series) {
  validate(options);
  validate(series);
  const models::ModelInfo& info = model->info();
  for (const std::string& name : series.coefficients) check_coefficient(info, options, name);
  const SeriesWindows windows = series_windows(captures, options, series);
  const FitOptions windowed = options_of_windows(options, windows, series);

  CoefficientSeries result{.model = info.name,
                           .time_unit = models::time_unit(info),
                           .joined = windows.joined,
                           .windows = windows.count,
                           .instants = windows.knots.instants};
  result.constant = fit(*constant_family(model, options), windows.captures, windowed);
  result.message = fmt::format("with constant coefficients: {}", result.constant.message);
  if (result.constant.status == FitStatus::failed) return result;

  SeriesFits fits(model, windows, windowed, series, result.constant);
  Chosen chosen;
  if (fits.has_free_scales()) {
    chosen = choose(fits, result.trials);
    result.factor = chosen.factor;
  } else {
    chosen.fit = fits.fit_with(1.0);
    if (chosen.fit.status != FitStatus::failed) chosen.judgement = fits.judge(chosen.fit, 1.0);
  }
  result.fit = std::move(chosen.fit);
  result.status = result.fit.status;
  result.message = result.fit.message;
  if (result.status == FitStatus::failed) return result;
  result.effective = chosen.judgement.effective;
  result.correlation_factor = growth_of_errors(result.fit);
  for (std::size_t c = 0; c < series.coefficients.size(); ++c) {
    result.coefficients.push_back(
        fits.describe(result.fit, c, chosen.factor, chosen.judgement, result.correlation_factor));
  }
  add_replay(info, result.fit, windows.knots, options, result);
  add_series_warnings(result);
  return result;
}

}  // namespace samara::identification
