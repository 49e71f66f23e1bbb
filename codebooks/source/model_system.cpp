#include "samara/codebooks/source/model_system.h"

#include <algorithm>

namespace samara::codebooks {

namespace {
std::span<const double> column(const Eigen::MatrixXd& matrix, Eigen::Index j) {
  return {matrix.data() + j * matrix.rows(), static_cast<std::size_t>(matrix.rows())};
}
}  // namespace

void ModelSystem::rhs(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                      Eigen::MatrixXd& f) const {
  models::ParametricModel::Workspace workspace = model_.make_workspace();
  f.resize(x.rows(), x.cols());
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    model_.rhs(t[j], column(x, j), column(q, j),
               {f.data() + j * f.rows(), static_cast<std::size_t>(f.rows())}, workspace);
  }
}

void ModelSystem::jacobian(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                           Eigen::MatrixXd& jacobian) const {
  models::ParametricModel::Workspace workspace = model_.make_workspace();
  models::RhsDerivatives derivatives;
  std::vector<double> f(static_cast<std::size_t>(x.rows()));
  jacobian.resize(x.rows() * x.rows(), x.cols());
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    model_.rhs_with_derivatives(t[j], column(x, j), column(q, j), f, derivatives, workspace);
    jacobian.col(j) = derivatives.df_dx.reshaped();
  }
}

bool ModelSystem::affine_in_parameters() const {
  const std::vector<std::string>& affine = model_.model().info().affine_in;
  return std::ranges::all_of(model_.free(), [&](const models::FreeCoordinate& free) {
    return free.is_initial || std::ranges::find(affine, free.name) != affine.end();
  });
}

}  // namespace samara::codebooks
