#pragma once

#include "samara/models/interface/parametric_model.h"
#include "samara/pgd/evolution/evolution_problem.h"

namespace samara::codebooks {

/// A model as the engine sees it: the only adapter between the two. Parameters are the free coordinates in
/// order. The model must outlive it.
class ModelSystem final : public pgd::EvolutionSystem {
 public:
  explicit ModelSystem(const models::ParametricModel& model) : model_(model) {}

  int state_count() const override { return model_.state_count(); }
  void rhs(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
           Eigen::MatrixXd& f) const override;
  void jacobian(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                Eigen::MatrixXd& jacobian) const override;
  /// Whether the model says so of all free parameters; initial values do not enter f.
  bool affine_in_parameters() const override;

 private:
  const models::ParametricModel& model_;
};

}  // namespace samara::codebooks
