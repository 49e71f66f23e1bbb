#pragma once

#include <functional>
#include <span>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace samara::models {

/// M u' + K u = f(t): linear equations of many states, as the method of lines makes them of a field. M and K
/// are sparse and do not change, M is regular.
struct LinearSystem {
  Eigen::SparseMatrix<double> mass;                               ///< M, states x states
  Eigen::SparseMatrix<double> stiffness;                          ///< K, states x states
  std::function<void(double, Eigen::Ref<Eigen::VectorXd>)> load;  ///< writes f(t); empty: zero
};

struct LinearIntegrationOptions {
  double relative_tolerance = 1e-10;  ///< per step, of every state
  double absolute_tolerance = 1e-12;  ///< per step, in the unit of the states
  long max_steps = 100'000;           ///< from one time to the next
};

/// Integrates by CVODE: backward differentiation formulas of variable order and step, with sparse
/// factorisations of M + gamma K.
/// @param start u at times[0]
/// @param times increasing, at least one
/// @returns states x times
/// @throws ArgumentError if sizes do not match, a number is not finite, times do not increase or an option is
/// not positive; NoResultError with the time it came to, if M is singular or CVODE gives up.
Eigen::MatrixXd integrate_linear(const LinearSystem& system, const Eigen::VectorXd& start,
                                 std::span<const double> times, const LinearIntegrationOptions& options = {});

/// The same state by state, where all of them at once are too many: `take` gets the place of the time and the states
/// at it, in the order of the times.
void integrate_linear(const LinearSystem& system, const Eigen::VectorXd& start, std::span<const double> times,
                      const LinearIntegrationOptions& options,
                      const std::function<void(std::size_t, const Eigen::Ref<const Eigen::VectorXd>&)>& take);

}  // namespace samara::models
