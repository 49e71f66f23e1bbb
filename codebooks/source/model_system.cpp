#include "samara/codebooks/source/model_system.h"

#include <algorithm>

namespace samara::codebooks {

void ModelSystem::rhs(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                      Eigen::MatrixXd& f) const {
  f.resize(x.rows(), x.cols());
  model_.rhs_at_points(t, x, q, f);
}

void ModelSystem::jacobian(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                           Eigen::MatrixXd& jacobian) const {
  jacobian.resize(x.rows() * x.rows(), x.cols());
  model_.jacobians_at_points(t, x, q, jacobian);
}

bool ModelSystem::affine_in_parameters() const {
  const std::vector<std::string>& affine = model_.model().info().affine_in;
  return std::ranges::all_of(model_.free(), [&](const models::FreeCoordinate& free) {
    return free.is_initial || std::ranges::find(affine, free.name) != affine.end();
  });
}

}  // namespace samara::codebooks
