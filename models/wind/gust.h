#pragma once

#include <Eigen/Core>

#include "samara/models/laws/ambient_flow.h"

/// Single gusts of a given course, to be added to a wind: nothing in them is random.
///
/// Sources: MIL-F-8785C (1980), 3.7.3 (1 - cosine); IEC 61400-1 ed. 3 (2005), 6.3.2.2 (extreme operating gust).
namespace samara::models::wind {

/// Velocity over time s since the start, in times of `velocity`; T is the duration.
enum class GustShape {
  one_minus_cosine,  ///< (1 - cos(2 pi s/T))/2 for 0 <= s <= T, else 0
  step,              ///< (1 - cos(pi s/T))/2 for 0 <= s <= T, then 1: the rise of MIL-F-8785C, to stay
  extreme_operating,  ///< -0.37 sin(3 pi s/T) (1 - cos(2 pi s/T)) for 0 <= s <= T, else 0: a dip, a rise, a dip
};

struct GustOptions {
  GustShape shape = GustShape::one_minus_cosine;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< world axes [m/s]
  double start = 0.0;                                  ///< [s]
  double duration = 0.0;                               ///< T [s]
  /// Velocity with which the gust travels, world axes [m/s]; it arrives at the origin at `start`. Zero: it is
  /// everywhere at once, which leaves the flow free of divergence; one that travels along its own velocity does not.
  Eigen::Vector3d travel = Eigen::Vector3d::Zero();
};

/// Immutable.
class Gust final : public AmbientFlow {
 public:
  /// @throws ArgumentError unless the duration is positive and all is finite.
  explicit Gust(const GustOptions& options);

  AmbientSample sample(double t, const Eigen::Vector3d& position) const override;
  /// Of a gust that travels, its way in T/(2 pi); else infinite [m].
  double length() const override;
  double duration() const { return options_.duration; }
  /// Whether it changes at a place some time between two times.
  bool passes(double from, double to, const Eigen::Vector3d& position) const;

  /// The factor of `velocity` at s after the start, and its rate [1/s].
  double course(double s) const;
  double course_rate(double s) const;

 private:
  GustOptions options_;
  Eigen::Vector3d slowness_;  ///< gradient of the time of arrival [s/m]
};

}  // namespace samara::models::wind
