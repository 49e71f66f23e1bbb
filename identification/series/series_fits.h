#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/series/coefficient_series.h"
#include "samara/identification/series/series_spans.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Internal to identification/.
namespace samara::identification {

/// Fits of one series at different smoothness, each from where the one before it ended.
class SeriesFits {
 public:
  /// @param spans, series must outlive it
  /// @param options of the spans
  /// @param constant the fit where nothing changes
  SeriesFits(const std::shared_ptr<const models::Model>& model, const SeriesSpans& spans,
             const FitOptions& options, const SeriesOptions& series, const FitResult& constant);

  /// Whether a factor means anything.
  bool has_free_scales() const;
  /// Of the differences of a coefficient.
  double scale(std::size_t c, double factor) const;

  /// Whether noise levels are to be found.
  bool estimates_noise() const { return noise_.estimated; }
  /// Loss scales of the following fits: the levels that a fit has found.
  void hold_levels(const FitResult& found);

  /// With the loss scales that are held.
  FitResult fit_with(double factor);
  /// With noise levels of its own.
  FitResult fit_with_levels(double factor);

  /// What a fit says of all its values.
  struct Judgement {
    std::vector<int> free = {};       ///< coefficients of the fit that are at no bound
    Eigen::MatrixXd resolution = {};  ///< of the free ones
    Eigen::VectorXd variance = {};    ///< of the free ones, frames taken as independent
    double effective = 0.0;
    double criterion = std::numeric_limits<double>::quiet_NaN();
  };

  Judgement judge(const FitResult& result, double factor) const;
  SeriesCoefficient describe(const FitResult& result, std::size_t c, double factor,
                             const Judgement& judgement, double growth) const;

 private:
  double free_scales() const;
  std::vector<int> places(const FitResult& result, std::size_t c) const;
  /// Of all spans, by their share; a quaternion moves in three directions.
  double own_unknowns(const FitResult& result) const;

  const SeriesSpans& spans_;
  const SeriesOptions& series_;
  NoiseOptions noise_;
  FitOptions options_;
  std::unique_ptr<models::TrajectoryFamily> family_;
  Eigen::MatrixXd rows_;
  std::vector<double> constants_, sizes_, half_boxes_;  ///< of the coefficients
};

}  // namespace samara::identification
