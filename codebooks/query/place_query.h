#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/query/query.h"

namespace samara::codebooks {

/// Answers of a codebook with a mesh at points of space instead of numbers of nodes: in the cell that holds the
/// point, outputs are linear between its corners. One per thread; the codebook must outlive it.
///
///   PlaceQuery query(book);
///   query.values({{0.2, 0.31, 0.64, 1.5}}, values);   // t, x, y, conductivity
class PlaceQuery {
 public:
  /// @throws ArgumentError if the codebook has no mesh
  explicit PlaceQuery(const Codebook& book);

  /// Those of the codebook, with the directions of the mesh in place of the number of the node.
  const std::vector<Coordinate>& coordinates() const { return coordinates_; }

  /// All outputs at a point. @param x coordinates() in order, SI
  /// @throws ArgumentError as Query::values(); OutsideBoxError also if no cell holds the point
  void values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values);
  /// The same with gradient(output, coordinate); between cells, derivatives by directions are those of one of them.
  void values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
              Eigen::Ref<Eigen::MatrixXd> gradient);

 private:
  void answer(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
              Eigen::Ref<Eigen::MatrixXd>* gradient);

  const SpaceMesh* mesh_;
  std::size_t space_;  ///< place of the node among the codebook's coordinates, and of the first direction
  std::vector<Coordinate> coordinates_;
  Query query_;
  std::vector<double> point_;  ///< of the codebook
  Eigen::VectorXd at_node_;
  Eigen::MatrixXd slopes_;
};

}  // namespace samara::codebooks
