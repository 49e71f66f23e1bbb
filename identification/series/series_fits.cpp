#include "samara/identification/series/series_fits.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "samara/identification/fit/fit.h"
#include "samara/identification/series/series_knots.h"
#include "samara/identification/solve/held_noise.h"

namespace samara::identification {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
/// A standard error in half boxes beyond which the box says more: that of a uniform distribution.
const double kUniform = 1.0 / std::sqrt(3.0);

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
    replace(options.unknowns.shared);
    replace(options.unknowns.log_scale);
    options.starts.initial.erase(name);
    options.unknowns.box.erase(name);
    if (const auto prior = options.priors.coordinates.extract(name)) {
      const Prior& known = prior.mapped();
      CombinationPrior mean{.mean = known.mean, .deviation = standard_deviation(known)};
      for (const std::string& knot : names) mean.weights[knot] = 1.0 / knots.count();
      options.priors.combinations.push_back(std::move(mean));
    }
  }
  options.starts.count = 1;
  options.starts.global = {};
  // Coefficients begin near their best constants: joins need not be so loose.
  if (options.segments.stages.size() > 3)
    options.segments.stages.erase(options.segments.stages.begin(), options.segments.stages.end() - 3);
  return options;
}

const Coefficient& coefficient_of(const FitResult& fit, const std::string& name) {
  return *std::ranges::find(fit.coefficients, name, &Coefficient::name);
}

Eigen::VectorXd values_at(const FitResult& result, const std::vector<int>& at) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(at.size()));
  for (std::size_t k = 0; k < at.size(); ++k) {
    values[static_cast<Eigen::Index>(k)] = result.coefficients[static_cast<std::size_t>(at[k])].value;
  }
  return values;
}

}  // namespace

SeriesFits::SeriesFits(const std::shared_ptr<const models::Model>& model, const SeriesSpans& spans,
                       const FitOptions& options, const SeriesOptions& series, const FitResult& constant)
    : spans_(spans),
      series_(series),
      noise_(options.noise),
      options_(options_of_knots(options, spans.knots)),
      family_(knot_trajectories(model, options.unknowns.fixed, options.unknowns.box, options.solver.step,
                                spans.knots)),
      rows_(difference_rows(spans.knots.instants, series.order, spans.spacing)) {
  const SeriesKnots& knots = spans.knots;
  for (std::size_t c = 0; c < knots.coefficients.size(); ++c) {
    const Coefficient& best = coefficient_of(constant, knots.coefficients[c]);
    const double half_box = 0.5 * (best.upper - best.lower);
    constants_.push_back(best.value);
    sizes_.push_back(std::max(std::abs(best.value), 0.1 * half_box));
    half_boxes_.push_back(half_box);
    for (int k = 0; k < knots.count(); ++k) options_.starts.initial[knots.name(c, k)] = best.value;
  }
  for (const Coefficient& c : constant.coefficients) {
    if (std::ranges::count(knots.coefficients, c.name) == 0) options_.starts.initial[c.name] = c.value;
  }
}

bool SeriesFits::has_free_scales() const {
  return std::ranges::any_of(spans_.knots.coefficients,
                             [&](const std::string& name) { return !series_.scales.contains(name); });
}

double SeriesFits::scale(std::size_t c, double factor) const {
  const auto given = series_.scales.find(spans_.knots.coefficients[c]);
  return given == series_.scales.end() ? factor * sizes_[c] : given->second;
}

void SeriesFits::hold_levels(const FitResult& found) {
  hold_noise(found, options_);
}

FitResult SeriesFits::fit_with_levels(double factor) {
  options_.noise = noise_;
  FitResult result = fit_with(factor);
  options_.noise = {};
  return result;
}

FitResult SeriesFits::fit_with(double factor) {
  FitOptions options = options_;
  for (std::size_t c = 0; c < spans_.knots.coefficients.size(); ++c) {
    for (Eigen::Index row = 0; row < rows_.rows(); ++row) {
      CombinationPrior difference{.deviation = scale(c, factor)};
      for (int k = 0; k < spans_.knots.count(); ++k) {
        if (rows_(row, k) != 0.0) difference.weights[spans_.knots.name(c, k)] = rows_(row, k);
      }
      options.priors.combinations.push_back(std::move(difference));
    }
  }
  FitResult result = fit(*family_, spans_.captures, options);
  if (result.status != Termination::failed) {
    for (const Coefficient& c : result.coefficients) options_.starts.initial[c.name] = c.value;
  }
  return result;
}

SeriesFits::Judgement SeriesFits::judge(const FitResult& result, double factor) const {
  Judgement judgement;
  const auto count = static_cast<Eigen::Index>(result.coefficients.size());
  Eigen::MatrixXd differences = Eigen::MatrixXd::Zero(count, count);
  double penalty = 0.0;
  for (std::size_t c = 0; c < spans_.knots.coefficients.size(); ++c) {
    const std::vector<int> at = places(result, c);
    const double s = scale(c, factor);
    differences(at, at) += rows_.transpose() * rows_ / (s * s);
    penalty += (rows_ * values_at(result, at)).squaredNorm() / (s * s);
  }
  for (int k = 0; k < static_cast<int>(count); ++k) {
    if (!result.coefficients[static_cast<std::size_t>(k)].at_bound) judgement.free.push_back(k);
  }
  const std::vector<int>& free = judgement.free;
  Eigen::VectorXd half_box(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Coefficient& c = result.coefficients[static_cast<std::size_t>(k)];
    half_box[k] = 0.5 * (c.upper - c.lower);
  }
  const Eigen::VectorXd size = half_box(free);
  const Eigen::MatrixXd of_all = half_box.asDiagonal() * result.information * half_box.asDiagonal();
  const Eigen::MatrixXd whole = of_all(free, free);
  const Eigen::MatrixXd smooth = size.asDiagonal() * differences(free, free) * size.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> factorised(whole);
  if (factorised.info() != Eigen::Success) return judgement;
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(whole.rows(), whole.cols());
  const Eigen::MatrixXd inverse = factorised.solve(one);
  judgement.resolution = inverse * (whole - smooth);
  judgement.effective = judgement.resolution.trace();

  const double residual_count = result.residual_count / spans_.overlap;
  const double own = own_unknowns(result);
  const double left = std::max(1.0, residual_count - own - judgement.effective);
  const double total = 2.0 * result.cost;
  judgement.variance =
      std::max(0.0, total - penalty) / left * inverse.diagonal().cwiseProduct(size.cwiseAbs2());
  const auto series = static_cast<double>(spans_.knots.coefficients.size());
  const double straight = static_cast<double>(count) - series * static_cast<double>(rows_.rows());
  // Of what is free and of all values of the series: a smoothness at which more of them lie at bounds would win by
  // their number alone.
  std::vector<int> compared = free;
  for (std::size_t c = 0; c < spans_.knots.coefficients.size(); ++c) {
    const std::vector<int> at = places(result, c);
    compared.insert(compared.end(), at.begin(), at.end());
  }
  std::ranges::sort(compared);
  compared.erase(std::ranges::unique(compared).begin(), compared.end());
  const Eigen::LLT<Eigen::MatrixXd> of_compared(of_all(compared, compared));
  if (of_compared.info() != Eigen::Success) return judgement;
  const double log_determinant = 2.0 * Eigen::MatrixXd(of_compared.matrixL()).diagonal().array().log().sum();
  judgement.criterion = (residual_count - own - straight) * std::log(total) + log_determinant +
                        2.0 * static_cast<double>(rows_.rows()) * free_scales() * std::log(factor);
  return judgement;
}

SeriesCoefficient SeriesFits::describe(const FitResult& result, std::size_t c, double factor,
                                       const Judgement& judgement, double growth) const {
  const std::vector<int> at = places(result, c);
  const Coefficient& first = result.coefficients[static_cast<std::size_t>(at.front())];
  const auto count = static_cast<Eigen::Index>(at.size());
  SeriesCoefficient series{.name = spans_.knots.coefficients[c],
                           .unit = first.unit,
                           .scale = scale(c, factor),
                           .constant = constants_[c],
                           .values = values_at(result, at),
                           .standard_errors = Eigen::VectorXd::Constant(count, kUnknown),
                           .shares = Eigen::VectorXd::Zero(count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto free = std::ranges::find(judgement.free, at[static_cast<std::size_t>(k)]);
    if (free == judgement.free.end()) {
      series.basis.push_back(InstantBasis::bound);
      continue;
    }
    const Eigen::Index place = free - judgement.free.begin();
    const double error =
        judgement.variance.size() > 0 ? growth * std::sqrt(judgement.variance[place]) : kUnknown;
    if (!(error < kUniform * half_boxes_[c])) {
      series.basis.push_back(InstantBasis::nothing);
      continue;
    }
    series.standard_errors[k] = error;
    const Coefficient& value = result.coefficients[static_cast<std::size_t>(at[static_cast<std::size_t>(k)])];
    if (value.integration_shift) {
      const double shift = std::abs(*value.integration_shift) / error;
      series.integration_shift = std::max(shift, series.integration_shift.value_or(0.0));
    }
    series.shares[k] = judgement.resolution(place, place);
    series.basis.push_back(series.shares[k] < 0.5 ? InstantBasis::neighbours : InstantBasis::frames);
  }
  return series;
}

double SeriesFits::free_scales() const {
  return static_cast<double>(std::ranges::count_if(
      spans_.knots.coefficients, [&](const std::string& name) { return !series_.scales.contains(name); }));
}

std::vector<int> SeriesFits::places(const FitResult& result, std::size_t c) const {
  std::vector<int> at;
  for (int k = 0; k < spans_.knots.count(); ++k) {
    const auto found = std::ranges::find(result.coefficients, spans_.knots.name(c, k), &Coefficient::name);
    at.push_back(static_cast<int>(found - result.coefficients.begin()));
  }
  return at;
}

double SeriesFits::own_unknowns(const FitResult& result) const {
  const std::vector<std::string>& attitude = family_->info().attitude;
  double count = 0.0;
  for (const CaptureFit& capture : result.captures) {
    for (const Nuisance& n : capture.nuisances) {
      if (n.at_bound || (!attitude.empty() && n.name == attitude.front() + "(0)")) continue;
      count += 1.0;
    }
  }
  return count / spans_.overlap;
}

}  // namespace samara::identification
