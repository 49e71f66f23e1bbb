#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/query/query.h"

namespace samara::codebooks {

/// Answers at fixed times (the frames of a camera), for chosen outputs, again and again at other parameters:
/// what a fit asks for. Each call costs one product over the parameter axes and one small matrix product over
/// the prepared times.
class TrajectoryQuery {
 public:
  /// @param times s, inside the box
  /// @param outputs names; empty: all
  /// @throws ArgumentError for an unknown output or one named twice, or a codebook without time;
  /// OutsideBoxError for a time outside the box.
  TrajectoryQuery(const Codebook& book, std::vector<double> times,
                  const std::vector<std::string>& outputs = {});
  /// @throws as above, and as Query; time cannot be held
  TrajectoryQuery(const Codebook& book, std::vector<double> times, const QueryOptions& options);
  ~TrajectoryQuery();
  TrajectoryQuery(const TrajectoryQuery& other);
  TrajectoryQuery(TrajectoryQuery&&) noexcept;
  TrajectoryQuery& operator=(const TrajectoryQuery& other);
  TrajectoryQuery& operator=(TrajectoryQuery&&) noexcept;

  int time_count() const;
  int output_count() const;
  /// Number of free coordinates, time not counted.
  int parameter_count() const;
  /// Inner dimension of the product over the prepared times: ranks, or terms, of the largest piece.
  int inner_size() const;
  Precision precision() const;

  /// @param q the free coordinates after time, in order, SI
  /// @param values times x outputs
  /// @throws as Query::values
  void values(std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> values);

  /// @param derivatives times x (outputs * parameters): column o + outputs * k holds d(output o)/d(q_k)
  void values(std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> values,
              Eigen::Ref<Eigen::MatrixXd> derivatives);

  /// Residuals of observations and their Jacobian, for optimisers: residual i = (value_i - observed_i) /
  /// scale_i, with the times of the first output, then those of the second, ..
  /// @param observed,scales,residuals times * outputs numbers
  /// @param jacobian empty, or row by row (residuals x parameters), as ceres::CostFunction::Evaluate wants it
  void residuals(std::span<const double> q, std::span<const double> observed, std::span<const double> scales,
                 std::span<double> residuals, std::span<double> jacobian = {});

  /// Many trajectories at once.
  /// @param points parameters x points  @param values (times * outputs) x points, times running fastest
  /// @param threads 0: as many as the machine has
  /// @throws as Query::batch
  void batch(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Ref<Eigen::MatrixXd> values,
             int threads = 1);

  /// The same with derivatives, trajectory by trajectory as values() gives them.
  /// @param derivatives (times * outputs * parameters) x points: times run fastest, then outputs
  void batch(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Ref<Eigen::MatrixXd> values,
             Eigen::Ref<Eigen::MatrixXd> derivatives, int threads = 1);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace samara::codebooks
