#pragma once

#include <memory>
#include <string>
#include <vector>

#include "samara/codebooks/query/derived_query.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"

/// What the queries of the interface in C are made of: one class each for points and trajectories, whose outputs
/// may be stored or derived, and whose answers lie in memory as C has them; internal to codebooks/.
namespace samara::codebooks {

/// @throws as Query and DerivedQuery
class PointAnswers {
 public:
  PointAnswers(const Codebook& book, const QueryOptions& options);

  const std::vector<Coordinate>& coordinates() const;
  const std::vector<pgd::OutputLabel>& outputs() const { return outputs_; }
  Precision precision() const { return precision_; }

  void values(const double* x, double* values);
  /// @param gradient outputs x coordinates, row by row
  void values(const double* x, double* values, double* gradient);
  /// @param gradients null, or those of each point one after the other
  void batch(Eigen::Index count, const double* points, double* values, double* gradients, int threads);

 private:
  std::vector<pgd::OutputLabel> outputs_;
  Precision precision_;
  std::unique_ptr<Query> stored_;  ///< one of the two
  std::unique_ptr<DerivedQuery> derived_;
  Eigen::MatrixXd gradient_;  ///< column by column, before it is handed out row by row
};

/// @throws as TrajectoryQuery and DerivedQuery
class FrameAnswers {
 public:
  FrameAnswers(const Codebook& book, std::vector<double> times, const QueryOptions& options);

  Eigen::Index times() const { return std::ssize(times_); }
  Eigen::Index outputs() const { return outputs_; }
  Eigen::Index parameters() const { return parameters_; }

  /// @param values times x outputs, and derivatives times x (outputs * parameters), or null, column by column
  void values(const double* q, double* values, double* derivatives);
  void batch(Eigen::Index count, const double* points, double* values, double* derivatives, int threads);

 private:
  std::vector<double> times_;
  Eigen::Index outputs_ = 0, parameters_ = 0;
  std::unique_ptr<TrajectoryQuery> stored_;  ///< one of the two
  std::unique_ptr<PointAnswers> derived_;
  std::vector<double> point_, row_, slopes_;  ///< of one time
};

}  // namespace samara::codebooks
