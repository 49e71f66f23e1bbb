#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace samara::codebooks {

/// Where in space the nodes of a codebook's axis lie, and the cells between them: lines, triangles or tetrahedra,
/// in as many directions as they have corners less one. Between nodes a field is linear in every cell, as that of
/// linear finite elements is. Cheap to copy, safe to share between threads.
class SpaceMesh {
 public:
  /// Some nodes of a cell and what they count for at a point of it.
  struct Place {
    std::vector<int> nodes;
    Eigen::VectorXd weights;  ///< that sum to one
    Eigen::MatrixXd slopes;   ///< nodes x directions: derivatives of the weights, 1/unit
  };

  /// @param directions names of the coordinates of a point: {"x", "y"}, without "=" and control characters
  /// @param unit of them all, SI
  /// @param points directions x nodes
  /// @param cells corners x cells, numbers of nodes
  /// @throws ArgumentError if there are no nodes or cells, directions are not one to three with names that differ,
  /// the unit is none, cells have not one corner more than directions, a corner is no node, a point is not finite, or
  /// a cell has no volume.
  SpaceMesh(std::vector<std::string> directions, std::string unit, Eigen::MatrixXd points,
            Eigen::MatrixXi cells);

  const std::vector<std::string>& directions() const { return content_->directions; }
  const std::string& unit() const { return content_->unit; }
  const Eigen::MatrixXd& points() const { return content_->points; }
  const Eigen::MatrixXi& cells() const { return content_->cells; }
  int node_count() const { return static_cast<int>(points().cols()); }
  /// Of the box around all nodes.
  Eigen::VectorXd lower() const { return points().rowwise().minCoeff(); }
  Eigen::VectorXd upper() const { return points().rowwise().maxCoeff(); }

  /// The cell that holds a point, borders included; of several the first. Empty outside all cells.
  /// @param point one number per direction
  /// @throws ArgumentError for another size, or a number that is not finite
  std::optional<Place> find(std::span<const double> point) const;

 private:
  /// Cells by the boxes of a grid that they touch.
  struct Bins {
    Eigen::VectorXi counts;  ///< boxes per direction
    Eigen::VectorXd lower, width;
    std::vector<std::vector<int>> cells;
  };
  struct Content {
    std::vector<std::string> directions;
    std::string unit;
    Eigen::MatrixXd points;
    Eigen::MatrixXi cells;
    // Made when a point is looked for first.
    mutable std::once_flag has_bins;
    mutable Bins bins;
  };

  static Bins bins_of(const Eigen::MatrixXd& points, const Eigen::MatrixXi& cells);
  /// Fills the boxes with the cells that touch them; false if that takes more than `most` entries.
  static bool fill(Bins& bins, const Eigen::MatrixXd& points, const Eigen::MatrixXi& cells, std::size_t most);
  const Bins& bins() const;

  std::shared_ptr<const Content> content_;
};

}  // namespace samara::codebooks
