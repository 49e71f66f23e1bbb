#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/design/capture_rows.h"
#include "samara/identification/design/design.h"
#include "samara/identification/problem/known_so_far.h"

/// Internal to identification/: what several captures leave open, by draws of the coefficients.
namespace samara::identification {

/// Per draw, coefficients x coefficients, in units of the errors so far.
using Informations = std::vector<Eigen::MatrixXd>;

/// What a set of captures is worth.
class Precision {
 public:
  Precision(const KnownSoFar& known, const DesignOptions& options);

  int draws() const { return draws_; }
  /// With no capture more.
  const Informations& so_far() const { return so_far_; }

  /// The logarithm of the mean variance, by the criterion: what a design makes small.
  double log_variance(const Informations& informations) const;
  /// The mean error over that so far.
  double error(const Informations& informations) const;
  /// Standard error of each coefficient, in units of those so far.
  Eigen::VectorXd errors(const Informations& informations) const;

 private:
  DesignCriterion criterion_;
  std::vector<int> of_;      ///< coefficients that count
  Eigen::VectorXd weights_;  ///< of their variances, in the trace
  int draws_;
  Informations so_far_;
};

void add(const Informations& more, Informations& sum);
void subtract(const Informations& less, Informations& sum);

/// Captures at releases, per capture and draw; empty rows where there is no trajectory.
using RowsOfCaptures = std::vector<std::vector<CaptureRows>>;

/// So far, and what captures add by the rows that are kept.
Informations with_captures(const Precision& precision, const RowsOfCaptures& captures,
                           const std::function<bool(int frame, int output)>& keeps);

}  // namespace samara::identification
