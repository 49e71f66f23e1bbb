#pragma once

#include <limits>
#include <vector>

#include "samara/motion/planning/fall_replay.h"
#include "samara/motion/planning/fall_tangents.h"

namespace samara::motion {

/// Windows over the knots of a fall, each of six knots that move and ten that are looked at.
class Windows {
 public:
  static constexpr std::size_t kMoved = 6, kSeen = 10;

  /// Residuals whose squares sum to the cost, and their derivatives by the values at the knots that move.
  struct Look {
    double cost = std::numeric_limits<double>::infinity();
    Eigen::MatrixXd H;
    Eigen::VectorXd g;
  };

  /// @param knots which improve() moves
  Windows(const PlannedFall& fall, std::vector<CourseKnot>& knots);

  /// What the window that begins with a knot costs. If it holds the whole fall, that is the cost of
  /// fall_cost.h but for the kinds, its integrals from about twenty samples a knot, and the landing where the
  /// way of the last step meets the ground.
  /// @param now the fall along the knots as they were when pieces were last cut
  Look look(std::size_t first, const ReplayedFall& now, bool derivatives);
  /// The window that begins with this knot. @param now the fall along the knots as they are
  /// @returns whether its knots were moved
  bool improve(std::size_t first, const ReplayedFall& now);

  /// Of all looks with derivatives so far.
  const BookUse& use() const { return motion_.use(); }

 private:
  Eigen::Index unknowns(std::size_t first) const;
  /// Samples about twenty times between knots.
  long samples_every(double length, std::size_t knots) const;
  template <class Record>
  bool run(std::size_t first, const FallPoint& from, double end, bool derivatives, const Record& record);
  double horizon(std::size_t first) const;
  /// Of the whole: what changes and turbulence are over.
  double fallen() const;
  /// Changes of coefficients within the window and to the knot after it.
  void add_changes(std::size_t first, const FallPoint& from, Look& look) const;
  /// Of the place; 3 x unknowns.
  Eigen::Matrix3Xd moved_places() const;
  /// @param weight of both, see fall_cost.h
  static void add_residual(const Eigen::VectorXd& residual, const Eigen::MatrixXd& J, double weight,
                           Look& look);
  void add_path(double duration, Look& look) const;
  /// The pieces of the turbulence are those between knots, with the heights that they had.
  void add_turbulence(std::size_t first, std::size_t knot, double duration, Look& look);
  /// Where it comes down: along the way that it has at the end of the window, which is that of the fall.
  void add_landing(Look& look) const;
  void put(std::size_t first, const Eigen::VectorXd& z);

  const PlannedFall& fall_;
  std::vector<CourseKnot>& knots_;
  std::size_t count_;
  FallTangents motion_;
  Roaming roaming_;
  const ReplayedFall* now_ = nullptr;
};

}  // namespace samara::motion
