#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "samara/base/streams.h"
#include "samara/motion/search/near_points.h"
#include "samara/motion/sweeps/sweep.h"

/// Where in a box which pattern lies, from the falls of a sweep: the map of one release, which says nothing of others.
namespace samara::motion {

struct MapAnswer {
  Pattern pattern = Pattern::unresolved;
  double probability = 0.0;         ///< share of the nearest falls that have it
  double distance_to_border = 0.0;  ///< to the nearest fall of another pattern; the box has sides of length 1
};

/// Falls of one pattern that hang together.
struct MapRegion {
  Pattern pattern = Pattern::unresolved;
  Eigen::Index falls = 0;
};

/// All numbers from 0 to `count` - 1, or of more than `most` so many of them, drawn, in order. Those at equal
/// distances might show one half of an axis, of grids and Sobol' points alike, or one release of several.
std::vector<Eigen::Index> drawn_numbers(Eigen::Index count, Eigen::Index most);

/// How far outside its ends a coordinate counts as inside: round-off, also of an axis of a single value.
double room_beside(double lower, double upper);

class PatternMap {
 public:
  /// Falls that are asked around a point.
  static constexpr int kNeighbours = 7;

  /// @throws ArgumentError for a release that the sweep does not have, or fewer than kNeighbours + 1 points.
  explicit PatternMap(const Sweep& sweep, Eigen::Index release = 0);

  Eigen::Index size() const { return places_.rows(); }
  Pattern pattern(Eigen::Index point) const { return patterns_[static_cast<std::size_t>(point)]; }

  /// @param point coordinates, SI. @throws ArgumentError if it is not finite or lies outside the box.
  MapAnswer at(const Eigen::VectorXd& point) const;

  /// Share of points whose neighbours, without itself, have its pattern most often: what the map is worth at places
  /// between its points. Only points that were run are asked, and only of each other: one that inherited its label has
  /// it from its neighbours. Of at most 2,000 of them, drawn.
  /// @param asked points; empty: all that were run
  double left_one_out(const std::vector<Eigen::Index>& asked = {}) const;

  /// Points that were run, not inherited.
  Eigen::Index run_count() const { return static_cast<Eigen::Index>(run_.size()); }

  /// The largest first. On a grid, neighbours differ by one step along one axis; else each point hangs together with
  /// its kNeighbours nearest.
  std::vector<MapRegion> regions() const;

  /// Share of points with a neighbour (as in regions()) of another pattern.
  double border_share() const;

  /// A point of the pattern's part of the box: one of its falls, moved by at most half its distance to the border,
  /// inside the box. @throws ArgumentError if no fall has this pattern, naming those that there are.
  Eigen::VectorXd draw(Pattern pattern, Stream& stream) const;

  /// The point itself where at() calls it by the pattern; else the last place that it does so on the way to the point
  /// from the nearest fall of the pattern, or that fall, if even there most neighbours have another. Coordinates
  /// outside the box are brought to its sides first.
  /// @throws ArgumentError as draw(), and if the point is not finite.
  Eigen::VectorXd clamp(Pattern pattern, const Eigen::VectorXd& point) const;

 private:
  Eigen::VectorXd scaled(const Eigen::VectorXd& point) const;
  std::vector<Eigen::Index> nearest(const Eigen::VectorXd& place, int count) const;
  MapAnswer answer(const std::vector<Eigen::Index>& nearest) const;
  double distance_to_other(const Eigen::VectorXd& place, Pattern pattern) const;
  std::vector<Eigen::Index> falls_of(Pattern pattern) const;
  std::vector<std::vector<Eigen::Index>> neighbours() const;

  std::vector<std::string> names_;         ///< of the coordinates
  Eigen::VectorXd lower_, upper_, width_;  ///< an axis of a single value is taken for one of width 1
  Eigen::MatrixXd places_;                 ///< points x coordinates, box of unit sides
  std::vector<Pattern> patterns_;
  std::vector<Eigen::Index> run_;
  std::vector<Eigen::Index> grid_;          ///< points along each axis; empty: no grid
  std::shared_ptr<const NearPoints> tree_;  ///< of places_
  std::array<std::shared_ptr<const NearPoints>, kPatterns> trees_;  ///< of those of each pattern
};

}  // namespace samara::motion
