#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/fields/separated_field.h"
#include "samara/pgd/tensors/tensor_train.h"

namespace samara::pgd {

/// Functions of d coordinates, several outputs at once, as a train over the nodes of axes:
///
///   u(x_1, .., x_d) = G_0 G_1(x_1) G_2(x_2) .. G_d(x_d),
///
/// where G_0 has one row per output and G_k(x_k) interpolates the slices of core k on axis k. Immutable, safe
/// to share between threads. Cost of a value: O(sum_k (p_k + 1) r_k-1 r_k), p_k the nodes a point touches on
/// axis k; a gradient costs about three times as much.
class TrainField {
 public:
  /// Scratch space of one thread.
  struct Workspace {
    std::vector<InterpolationStencil> stencils;
    std::vector<Eigen::VectorXd> after;        ///< after[k] = G_k+1(x) .. G_d(x)
    std::vector<Eigen::MatrixXd> slices;       ///< G_k(x_k)
    std::vector<Eigen::MatrixXd> derivatives;  ///< dG_k/dx_k
    Eigen::MatrixXd before;                    ///< transposed: G_0 .. G_k-1(x), one column per output
    Eigen::MatrixXd next;
    Eigen::VectorXd through;  ///< dG_k/dx_k after[k]
  };

  /// @param train its mode 0 the outputs, then one mode per axis
  /// @throws ArgumentError if sizes do not match, there is no axis or output, or an entry is not finite.
  TrainField(std::vector<Axis> axes, std::vector<OutputLabel> outputs, TensorTrain train);

  int output_count() const { return static_cast<int>(outputs_.size()); }
  int axis_count() const { return static_cast<int>(axes_.size()); }
  const std::vector<Axis>& axes() const { return axes_; }
  const std::vector<OutputLabel>& outputs() const { return outputs_; }
  const TensorTrain& train() const { return train_; }
  /// Numbers stored: the entries of all cores.
  long entries() const;

  Workspace make_workspace() const;

  /// All outputs at one point. Does not allocate.
  /// @param x one coordinate per axis
  /// @throws ArgumentError if x has not axis_count() finite entries; OutsideBoxError if one is outside its
  /// axis, or between the values of a discrete one.
  void evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values, Workspace& workspace) const;

  /// The same with exact derivatives: gradient(m, k) = du_m/dx_k.
  void evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                Eigen::Ref<Eigen::MatrixXd> gradient, Workspace& workspace) const;

  /// G_k(x) of axis k - 1, left rank x right rank. Building block of prepared queries; does not allocate.
  void slice(int axis, double x, InterpolationStencil& stencil, Eigen::Ref<Eigen::MatrixXd> slice) const;
  /// The same with its derivative.
  void slice(int axis, double x, InterpolationStencil& stencil, Eigen::Ref<Eigen::MatrixXd> slice,
             Eigen::Ref<Eigen::MatrixXd> derivative) const;

  /// Convenience form of the first one; allocates.
  Eigen::VectorXd operator()(std::span<const double> x) const;

 private:
  void load(std::span<const double> x, bool with_derivatives, Workspace& workspace) const;

  std::vector<Axis> axes_;
  std::vector<OutputLabel> outputs_;
  TensorTrain train_;
};

}  // namespace samara::pgd
