#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/tensors/separated_tensor.h"

namespace samara::pgd {

struct OutputLabel {
  std::string name;
  std::string unit = "1";
};

/// Separated functions of d coordinates, several outputs at once ("field group"):
///
///   u_m(x_1, .., x_d) = sum_r W(m, r) prod_k F_k^r(x_k),   (6.1) of the dissertation with shared factors,
///
/// where F_k^r interpolates column r of the factor matrix of axis k. Factors have length one in the mass
/// matrix of their axis divided by its measure, so |W(m, r)| is the root mean square of term r in output m
/// over the box. Coordinates and outputs are in SI units. Immutable, safe to share between threads.
///
/// Cost of a value: O(R (sum_k p_k + M)), p_k the nodes a point touches on axis k, M outputs; the gradient by
/// all axes costs about d + 1 times the second part more.
class SeparatedField {
 public:
  /// Scratch space of one thread.
  struct Workspace {
    std::vector<InterpolationStencil> stencils;
    Eigen::MatrixXd values;       ///< rank x axes: F_k^r(x_k)
    Eigen::MatrixXd derivatives;  ///< rank x axes: dF_k^r/dx_k
    Eigen::VectorXd product;
    Eigen::VectorXd suffix;
  };

  /// @param factors per axis: nodes x rank
  /// @param weights outputs x rank
  /// @throws ArgumentError if sizes do not match, there is no axis or output, or an entry is not finite.
  SeparatedField(std::vector<Axis> axes, std::vector<OutputLabel> outputs,
                 std::vector<Eigen::MatrixXd> factors, Eigen::MatrixXd weights);

  int rank() const { return static_cast<int>(weights_.cols()); }
  int output_count() const { return static_cast<int>(weights_.rows()); }
  int axis_count() const { return static_cast<int>(axes_.size()); }
  const std::vector<Axis>& axes() const { return axes_; }
  const std::vector<OutputLabel>& outputs() const { return outputs_; }
  const std::vector<Eigen::MatrixXd>& factors() const { return factors_; }
  const Eigen::MatrixXd& weights() const { return weights_; }

  Workspace make_workspace() const;

  /// All outputs at one point. Does not allocate.
  /// @param x one coordinate per axis
  /// @throws ArgumentError if x has not axis_count() finite entries; OutsideBoxError if one is outside its
  /// axis, or between the values of a discrete one.
  void evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values, Workspace& workspace) const;

  /// The same with the exact derivatives of the separated form: gradient(m, k) = du_m/dx_k.
  void evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                Eigen::Ref<Eigen::MatrixXd> gradient, Workspace& workspace) const;

  /// Convenience form of the first one; allocates.
  Eigen::VectorXd operator()(std::span<const double> x) const;

  /// Values of all factors of one axis at x: rank entries. Building block of prepared queries.
  void factor_values(int axis, double x, InterpolationStencil& stencil,
                     Eigen::Ref<Eigen::VectorXd> values) const;
  /// The same with the derivatives of the factors.
  void factor_values(int axis, double x, InterpolationStencil& stencil, Eigen::Ref<Eigen::VectorXd> values,
                     Eigen::Ref<Eigen::VectorXd> derivatives) const;

 private:
  std::vector<Axis> axes_;
  std::vector<OutputLabel> outputs_;
  std::vector<Eigen::MatrixXd> factors_;
  Eigen::MatrixXd weights_;
};

}  // namespace samara::pgd
