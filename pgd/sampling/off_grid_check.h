#pragma once

#include <set>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/fields/train_field.h"
#include "samara/pgd/sampling/sample_table.h"
#include "samara/pgd/tensors/random.h"

namespace samara::pgd {

/// Errors at points, over the scales of the outputs.
struct PointErrors {
  Eigen::VectorXd largest;  ///< per point, over the outputs
  double root_mean_square = 0.0;

  double worst() const { return largest.maxCoeff(); }
  /// Numbers of the points, the worst first.
  std::vector<Eigen::Index> descending() const;
};

/// Compares interpolants with the function at points that lie on no grid, and forgets none of them.
class OffGridCheck {
 public:
  OffGridCheck(const std::vector<SampledCoordinate>& coordinates, SampledFunction& function,
               std::uint64_t seed)
      : coordinates_(coordinates), function_(function), random_(seed) {}

  /// Uniform in the box, coordinates x count.
  Eigen::MatrixXd random_points(int count);

  /// Those of many candidates at which the latest two interpolants differ most: uniform ones, and ones near
  /// pivots in most coordinates, so that narrow features are looked at where they are. No point is given
  /// twice, of those that were called before neither.
  Eigen::MatrixXd suspicious_points(int count, const TrainField& latest, const TrainField& before,
                                    const Eigen::MatrixXd& pivots);

  /// Calls the function at points and remembers them. @param uniform how many, of the last, are uniform in
  /// the box @throws SamplingStopped
  void call(const Eigen::MatrixXd& points, Eigen::Index uniform = 0);

  int count() const { return static_cast<int>(points_.cols()); }
  /// All points called so far.
  const Eigen::MatrixXd& points() const { return points_; }
  /// Those of the points that were uniform in the box, and the errors there.
  Eigen::MatrixXd uniform_points() const { return points_(Eigen::all, uniform_); }
  Eigen::VectorXd uniform_errors(const TrainField& field) const;
  /// Errors at points that are called, but not remembered. @throws SamplingStopped
  Eigen::VectorXd errors_at(const TrainField& field, const Eigen::MatrixXd& points);
  /// Errors at the last `count` points called.
  PointErrors errors(const TrainField& field, int count) const;

 private:
  Eigen::MatrixXd candidates(int count, const Eigen::MatrixXd& pivots);
  PointErrors compare(const TrainField& field, const Eigen::MatrixXd& points,
                      const Eigen::MatrixXd& values) const;

  const std::vector<SampledCoordinate>& coordinates_;
  SampledFunction& function_;
  Random random_;
  Eigen::MatrixXd points_, values_;
  std::set<std::string> called_;       ///< points by their bytes
  std::vector<Eigen::Index> uniform_;  ///< columns of points that were uniform
};

}  // namespace samara::pgd
