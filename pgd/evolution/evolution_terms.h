#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/cross/cross_interpolation.h"
#include "samara/pgd/evolution/evolution.h"
#include "samara/pgd/linear/separated_operator.h"
#include "samara/pgd/tensors/separated_tensor.h"

namespace samara::pgd {

/// The discrete side of an evolution problem: tensors with the modes (state, time nodes after the first,
/// parameters..), states divided by their scales, time by its duration.
class EvolutionGrid {
 public:
  explicit EvolutionGrid(const EvolutionProblem& problem);

  const EvolutionProblem& problem() const { return problem_; }
  int states() const { return problem_.system->state_count(); }
  double duration() const { return problem_.time.length(); }
  /// Sizes of the modes behind the states.
  const std::vector<int>& sizes() const { return sizes_; }
  double size() const;

  /// S: integral from the start to every node but the first, per duration.
  const Eigen::MatrixXd& integration() const { return integration_; }
  /// Square roots of the quadrature weights of every mode (empty for the states), summing to one: with them
  /// the Euclidean norm of a tensor is a root mean square over the box.
  const std::vector<Eigen::VectorXd>& root_weights() const { return root_weights_; }
  /// The weights themselves.
  const std::vector<Eigen::VectorXd>& weights() const { return weights_; }

  /// x0 as a tensor.
  SeparatedTensor initial() const;

  /// Values of a tensor (modes as above) at entries of the grid: states x entries.
  static Eigen::MatrixXd gather(const SeparatedTensor& tensor, const IndexBatch& entries);

  /// f(x0 + w) times duration over scales at entries.
  void rhs(const SeparatedTensor& state, const IndexBatch& entries, Eigen::MatrixXd& values) const;
  /// Its Jacobian by the scaled states: column j holds entry j's matrix, column after column.
  void jacobian(const SeparatedTensor& state, const IndexBatch& entries, Eigen::MatrixXd& values) const;

  /// I - S J for a Jacobian given as a sum of products whose first mode is the (column-wise) state matrix.
  SeparatedOperator linear_operator(const SeparatedTensor& jacobian) const;

  /// The field x0 + w in SI units.
  SeparatedField field(const SeparatedTensor& w) const;
  /// w of a field over axes of the same names.
  SeparatedTensor from_field(const SeparatedField& field) const;

  /// Coordinates of an entry in words: "t = 0.1 s, C_D = 1.2 1".
  std::string describe(const std::vector<int>& entry) const;

 private:
  struct Points {
    Eigen::VectorXd t;
    Eigen::MatrixXd x, q;
  };
  Points points(const SeparatedTensor& state, const IndexBatch& entries) const;

  const EvolutionProblem& problem_;
  std::vector<int> sizes_;
  Eigen::MatrixXd integration_;
  std::vector<Eigen::VectorXd> weights_, root_weights_;
  Eigen::VectorXd scales_;
};

}  // namespace samara::pgd
