#include "samara/identification/design/precision.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

namespace samara::identification {

namespace {

Eigen::MatrixXd covariance_of(const Eigen::MatrixXd& information) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(information.rows(), information.cols());
  return Eigen::LLT<Eigen::MatrixXd>(information).solve(one);
}

}  // namespace

Precision::Precision(const KnownSoFar& known, const DesignOptions& options)
    : criterion_(options.criterion), draws_(options.draws) {
  for (const std::string& name : options.coefficients) {
    const auto found = std::ranges::find(known.names, name);
    if (found == known.names.end()) {
      throw ArgumentError(
          fmt::format("\"{}\" is not a coefficient of the fit{}", name, suggestion(name, known.names)));
    }
    of_.push_back(static_cast<int>(found - known.names.begin()));
    if (std::ranges::count(options.coefficients, name) > 1)
      throw ArgumentError(fmt::format("coefficients: \"{}\" stands there twice", name));
  }
  for (int k = 0; of_.size() < known.names.size() && options.coefficients.empty(); ++k) of_.push_back(k);
  // Of relative errors: variances are in units of errors so far.
  const Eigen::ArrayXd scales = known.values.array().abs().max(known.errors.array());
  weights_ = (known.errors.array() / scales).square();
  so_far_.assign(static_cast<std::size_t>(draws_), covariance_of(known.correlation));
}

double Precision::log_variance(const Informations& informations) const {
  double sum = 0.0;
  for (const Eigen::MatrixXd& information : informations) {
    const Eigen::MatrixXd covariance = covariance_of(information);
    if (criterion_ == DesignCriterion::determinant) {
      const Eigen::LLT<Eigen::MatrixXd> factor(covariance(of_, of_).eval());
      sum += 2.0 * factor.matrixLLT().diagonal().array().log().sum() / static_cast<double>(of_.size());
    } else {
      sum += covariance.diagonal()(of_).dot(weights_(of_)) / static_cast<double>(of_.size());
    }
  }
  const double mean = sum / draws_;
  const double result = criterion_ == DesignCriterion::determinant ? mean : std::log(mean);
  return std::isfinite(result) ? result : std::numeric_limits<double>::infinity();
}

double Precision::error(const Informations& informations) const {
  return std::exp(0.5 * (log_variance(informations) - log_variance(so_far_)));
}

Eigen::VectorXd Precision::errors(const Informations& informations) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(so_far_.front().rows());
  for (const Eigen::MatrixXd& information : informations) sum += covariance_of(information).diagonal();
  return (sum / draws_).cwiseSqrt();
}

void add(const Informations& more, Informations& sum) {
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += more[k];
}

void subtract(const Informations& less, Informations& sum) {
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] -= less[k];
}

Informations with_captures(const Precision& precision, const RowsOfCaptures& captures,
                           const std::function<bool(int frame, int output)>& keeps) {
  Informations sum = precision.so_far();
  for (const std::vector<CaptureRows>& capture : captures) {
    for (std::size_t draw = 0; draw < capture.size(); ++draw) {
      const CaptureRows& rows = capture[draw];
      if (rows.unknowns() > 0) sum[draw] += eliminated(rows.normal(keeps), rows.coefficients);
    }
  }
  return sum;
}

}  // namespace samara::identification
