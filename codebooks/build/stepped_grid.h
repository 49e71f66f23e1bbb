#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/front_map.h"
#include "samara/codebooks/build/line_elements.h"
#include "samara/codebooks/build/line_nodes.h"
#include "samara/codebooks/build/stepped_trajectories.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/pgd/axes/axis.h"
#include "samara/pgd/tensors/random.h"

namespace samara::codebooks {

/// Points of the plan's box, coordinates x count: half of them in its corners, half inside.
Eigen::MatrixXd corners_and_inside(const Plan& plan, int count, pgd::Random& random);

/// The grid that trajectories by steps are interpolated on: how many nodes a coordinate of the box needs, by the
/// polynomials along lines through it (line_nodes.h). Where these need more nodes than are allowed, coordinates are cut
/// into elements (line_elements.h), which follow a front that no polynomial does. Few lines through the box cross it:
/// once its places are known, all coordinates are looked along from there. Where a front moves too far for elements,
/// its coordinate is counted from it (front_finder.h): then the grid is one of the axes, over which the front stands
/// still.
///
/// Shares are of the plan's tolerance, and bound what a line errs by between its nodes.
class SteppedGrid {
 public:
  static constexpr double kFirstShare = 0.1;
  /// What is asked of nodes in the next round, where it was not enough.
  static constexpr double kTighter = 0.2;

  /// All but the values must outlive the object.
  /// @param coordinates of the box, in its order
  /// @param trajectories are told of progress, and how many are left bounds what elements may take
  /// @param values of trajectories at points of the box, over their scales
  SteppedGrid(const Plan& plan, const std::vector<pgd::Axis::Label>& coordinates,
              SteppedTrajectories& trajectories, LineNodes::Values values);

  /// Chooses nodes, and where they do not suffice a front to count from, if it is narrow, or elements, and a front
  /// where these do not either; to be called once, first. There are no elements where they do not follow all fronts:
  /// front() then says where the worst one is.
  void look_along_lines(pgd::Random& random);

  /// Until elements err along lines by no more than the share, which is reached in steps of kTighter, each with the
  /// same draws: a build that goes on from a state halves as the one did that has left it.
  /// @throws SteppedEnd where they would be too many
  void halve_elements(double share);

  /// Per coordinate; those of elements are as many as were last chosen, whatever the share.
  std::vector<int> nodes_within(double share) const { return lines_.within(share * plan_.relative); }
  /// Of so many nodes, now or before elements were halved.
  std::vector<pgd::Axis> axes(const std::vector<int>& nodes) const;
  bool has_elements() const { return lines_.has_elements(); }
  /// Whether grids of so many nodes have the same elements.
  bool are_same_elements(const std::vector<int>& nodes, const std::vector<int>& others) const;
  /// Whether a coordinate that is not in elements needs more nodes than are allowed.
  bool are_polynomials_used_up(double share) const;
  /// The worst that neither nodes nor elements follow; null if there is none: no cross over such nodes can meet the
  /// tolerance.
  const Front* front() const { return lines_.front(); }

  /// The front that a coordinate is counted from; null where axes are coordinates.
  const FrontMap* counted_from() const { return map_ ? &*map_ : nullptr; }
  /// Points of the box for points on the axes.
  Eigen::MatrixXd in_box(Eigen::MatrixXd points) const;

  /// On the axes, where elements are short, as densely as they lie.
  Eigen::MatrixXd points_near_fronts(int count, pgd::Random& random) const;
  /// On the axes, in corners and inside, and where there are elements every other one about the fronts.
  Eigen::MatrixXd mixed_points(int count, pgd::Random& random) const;

 private:
  Eigen::Index coordinates() const { return static_cast<Eigen::Index>(plan_.box.size()); }
  double width_of_box(Eigen::Index coordinate) const {
    const BoxEntry& entry = plan_.box[static_cast<std::size_t>(coordinate)];
    return entry.upper - entry.lower;
  }
  void look_along(Eigen::Index coordinate, const Eigen::MatrixXd& bases);
  LineNodes no_lines();
  bool cut_into_elements(pgd::Random& random);
  bool count_from(Eigen::Index counted, pgd::Random& random);
  bool follow_counted(Eigen::Index counted, pgd::Random& random);
  bool cut(Eigen::Index coordinate, pgd::Random& random);
  void set_elements(Eigen::Index coordinate, LineElements found);
  std::optional<LineElements> find_elements(Eigen::Index coordinate, double share, pgd::Random& random);
  Eigen::MatrixXd bases_at_fronts(pgd::Random& random) const;
  void tell_of_elements(Eigen::Index coordinate);

  const Plan& plan_;
  const std::vector<pgd::Axis::Label>& labels_;
  SteppedTrajectories& trajectories_;
  LineNodes::Values values_;
  std::optional<FrontMap> map_;
  LineNodes lines_;
  Eigen::MatrixXd front_places_;        ///< on the axes, a column each
  double element_share_ = kFirstShare;  ///< which elements follow
};

}  // namespace samara::codebooks
