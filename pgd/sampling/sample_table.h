#pragma once

#include <chrono>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "samara/base/errors.h"
#include "samara/base/termination.h"
#include "samara/pgd/cross/cross_interpolation.h"
#include "samara/pgd/sampling/sampling.h"

namespace samara::pgd {

/// Takes an ending from SampledFunction out of the searches under way, to sample(), which returns it.
class SamplingStopped : public Error {
 public:
  explicit SamplingStopped(Ending why) : Error(why.message), ending(std::move(why)) {}
  Ending ending;
};

/// A called function with its limits: counts calls, watches the clock, the values and the callback.
class SampledFunction {
 public:
  SampledFunction(const std::vector<SampledCoordinate>& coordinates, const std::vector<OutputLabel>& outputs,
                  const PointsFunction& function, const SamplingOptions& options);

  int coordinates() const { return static_cast<int>(coordinates_.size()); }
  int outputs() const { return static_cast<int>(outputs_.size()); }

  /// Values at points (coordinates x points). @throws SamplingStopped
  Eigen::MatrixXd operator()(const Eigen::MatrixXd& points);

  /// The same, but points that came through here before are not called again: for points off the grid, of
  /// which searches ask for some twice.
  Eigen::MatrixXd recalled(const Eigen::MatrixXd& points);

  long calls() const { return calls_; }
  double seconds() const;
  /// Per output, largest less smallest value seen.
  Eigen::VectorXd range() const { return largest_ - smallest_; }
  /// What errors are divided by: the range or the floor; for a constant output its size.
  Eigen::VectorXd scale() const;
  /// "C_D = 1.2 1, m = 0.1 kg"
  std::string described(const Eigen::VectorXd& point) const;
  /// For the progress callback: fraction of the work done.
  void report(double fraction) { fraction_ = fraction; }

 private:
  void check_limits(Eigen::Index more);
  void call(const Eigen::MatrixXd& points, Eigen::MatrixXd& values) const;
  void call_one_by_one(const Eigen::MatrixXd& points, Eigen::MatrixXd& values) const;
  void check_values(const Eigen::MatrixXd& points, const Eigen::MatrixXd& values) const;

  const std::vector<SampledCoordinate>& coordinates_;
  const std::vector<OutputLabel>& outputs_;
  const PointsFunction& function_;
  const SamplingOptions& options_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  long calls_ = 0;
  double fraction_ = 0.0;
  Eigen::VectorXd smallest_, largest_;
  std::unordered_map<std::string, Eigen::VectorXd> recalled_;  ///< by the bytes of the point
};

/// One coordinate as [-1, 1], through its transform.
class CoordinateMap {
 public:
  CoordinateMap(double lower, double upper, Transform transform);
  double from_unit(double u) const;
  double to_unit(double x) const;
  Transform transform() const { return transform_; }

 private:
  double lower_, upper_;
  Transform transform_;
  double length_;  ///< of the interval in T(x)
};

/// Remembers the function's values at nodes of the nested grid.
class SampleTable {
 public:
  SampleTable(SampledFunction& function, std::vector<CoordinateMap> maps);

  const std::vector<CoordinateMap>& maps() const { return maps_; }
  SampledFunction& function() { return function_; }

  /// Places of the points (coordinates x points, Leja numbers) in the table; missing ones are called in one
  /// batch. @throws SamplingStopped
  std::vector<int> places(const IndexBatch& points);
  /// Nodes that were called.
  std::size_t size() const { return places_.size(); }
  /// All outputs at one place.
  Eigen::Map<const Eigen::VectorXd> values(int place) const {
    return {values_.data() + static_cast<std::ptrdiff_t>(place) * outputs_, outputs_};
  }
  double value(int output, int place) const {
    return values_[static_cast<std::size_t>(place) * static_cast<std::size_t>(outputs_) +
                   static_cast<std::size_t>(output)];
  }
  Eigen::VectorXd point(const Eigen::Ref<const Eigen::VectorXi>& nodes) const;

 private:
  SampledFunction& function_;
  std::vector<CoordinateMap> maps_;
  int outputs_;
  Eigen::VectorXd leja_;
  std::unordered_map<std::string, int> places_;
  std::vector<double> values_;
};

}  // namespace samara::pgd
