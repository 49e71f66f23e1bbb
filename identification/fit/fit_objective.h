#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/termination.h"
#include "samara/identification/problem/evidence.h"

namespace samara::models {
class TrajectoryFamily;
}

/// What a fit minimised, for other optimisers and samplers.
///
/// Unknowns q are all of the fit, SI: first the shared coefficients, then for every capture (segment after segment,
/// where it is cut) its own coordinates, offsets, and what is unknown of its camera. The cost of the fit is half the
/// sum of squares of
///
///     r_i(q) = sign(e_i) sqrt(rho(e_i)),   e_i = (model - measured)/scale,
///
/// over all frames and outputs, the loss rho within, then of priors and joins, which have none. Where segments are
/// joined, joins weigh as in the last stage; where noise was estimated, scales are those that it found.
///
///     FitRequest request{.source = "coin.h5", .captures = {"coin.toml"}, .with_objective = true};
///     const FitReport report = fit_files(request);
///     report.objective->residuals(report.objective->answer(), residuals);
namespace samara::identification {

struct FitProblem;
struct FitPoint;
class SegmentResidual;

/// One unknown of a fit.
struct FitUnknown {
  std::string name;  ///< of the coefficient; or of the capture, and after a colon of its own unknown
  std::string unit;
  double lower = 0.0, upper = 0.0;  ///< of its box; infinite where it has none
};

/// Holds scratch space: calls wait for one another.
class FitObjective {
 public:
  /// @param family must outlive this
  /// @param like residuals whose weights at joins are taken over
  /// @param dispersion as Uncertainty::dispersion
  FitObjective(const models::TrajectoryFamily& family, const FitProblem& problem,
               const std::vector<SegmentResidual>& like, const FitPoint& answer, double dispersion);
  ~FitObjective();
  FitObjective(const FitObjective&) = delete;
  FitObjective& operator=(const FitObjective&) = delete;

  const std::vector<FitUnknown>& unknowns() const;
  /// Where the fit ended.
  const Eigen::VectorXd& answer() const;
  Eigen::Index residual_count() const;

  /// @param jacobian residuals x unknowns, not finite where an output has no derivative; null if not wanted
  /// @returns false where there is no trajectory or an output is not finite: then nothing that was written is to be
  ///   used
  /// @throws ArgumentError if q, or an answer, has the wrong size, or q is not finite
  bool residuals(std::span<const double> q, Eigen::Ref<Eigen::VectorXd> values,
                 Eigen::MatrixXd* jacobian = nullptr) const;

  /// Logarithm of the density of posterior.h by q, but for a constant: the cost of the captures over the
  /// dispersion of their residuals at the answer, and the cost of priors and joins, both negative. Uniform in
  /// the box where nothing else is known (in the logarithm of what moves by factors), -infinity outside it and
  /// where there is no trajectory or an output is not finite. Of the four numbers of an attitude only the direction
  /// counts.
  /// @param gradient by the unknowns, not finite where an output has no derivative; null if not wanted
  double log_posterior(std::span<const double> q, Eigen::VectorXd* gradient = nullptr) const;

  /// The evidence of the model by Laplace's method (D. MacKay, Information Theory, Inference, and Learning Algorithms,
  /// 2003, ch. 27 and 28; R. E. Kass, A. E. Raftery, J. Am. Stat. Assoc. 90 (1995) 773-795, section 4.1): with E the
  /// -log of likelihood times prior, both normalised, at its minimum, and H the second derivative of E there,
  ///
  ///     ln evidence = -E + d/2 ln 2 pi - 1/2 ln det H.
  ///
  /// Unknowns are those of log_posterior() and a factor of the noise of all outputs, before the captures equally likely
  /// by its logarithm from 1/1000 to 1000 loss scales. H is that of the descent (Gauss and Newton). It is off by about
  /// (d + 1)^2/(4 values) for normal data, whose noise is not known, and by what walls cut off.
  /// @returns no evidence where a prior is none (an unknown without a finite box, such as an offset) or of several
  ///   unknowns together, where the loss is no density (Cauchy's), where captures are cut into segments, where the
  ///   answer is no minimum or nearer than two deviations to a wall, and where something is not determined
  Outcome<Evidence> evidence() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace samara::identification
