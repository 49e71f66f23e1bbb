#pragma once

#include <set>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/random.h"
#include "samara/pgd/sample_table.h"
#include "samara/pgd/train_field.h"

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

  /// Half of them uniform in the box. The other half are those of many candidates at which the latest two
  /// interpolants differ most: uniform ones, and ones near pivots in most coordinates. So narrow features are
  /// looked at where they are. No point is given twice, of those that were called before neither.
  Eigen::MatrixXd suspicious_points(int count, const TrainField& latest, const TrainField& before,
                                    const Eigen::MatrixXd& pivots);

  /// Calls the function at points and remembers them. @throws SamplingStopped
  void call(const Eigen::MatrixXd& points);

  int count() const { return static_cast<int>(points_.cols()); }
  /// All points called so far.
  const Eigen::MatrixXd& points() const { return points_; }
  /// Values (outputs x points) at those of the points that were uniform in the box, of each call the later
  /// half.
  Eigen::MatrixXd uniform_values() const;
  /// Errors at the last `count` points called.
  PointErrors errors(const TrainField& field, int count) const;

 private:
  Eigen::MatrixXd candidates(int count, const Eigen::MatrixXd& pivots);

  const std::vector<SampledCoordinate>& coordinates_;
  SampledFunction& function_;
  Random random_;
  Eigen::MatrixXd points_, values_;
  std::set<std::string> called_;       ///< points by their bytes
  std::vector<Eigen::Index> uniform_;  ///< columns of points that were uniform
};

}  // namespace samara::pgd
