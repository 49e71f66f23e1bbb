#include "samara/pgd/evolution/polynomial_system.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::pgd {

namespace {

double power(double base, int exponent) {
  double result = 1.0;
  for (int i = 0; i < exponent; ++i) result *= base;
  return result;
}

/// The product of powers at column j, but for the power of one factor (or none: -1).
double product(const Eigen::MatrixXd& values, Eigen::Index j, const std::vector<int>& powers, int left_out) {
  double result = 1.0;
  for (std::size_t k = 0; k < powers.size(); ++k) {
    if (static_cast<int>(k) != left_out) result *= power(values(static_cast<Eigen::Index>(k), j), powers[k]);
  }
  return result;
}

void check_powers(std::vector<int>& powers, int count, const char* what) {
  if (powers.empty()) powers.assign(static_cast<std::size_t>(count), 0);
  const bool negative = std::any_of(powers.begin(), powers.end(), [](int p) { return p < 0; });
  if (static_cast<int>(powers.size()) == count && !negative) return;
  throw ArgumentError(fmt::format("the {} powers of a monomial are ({}), expected {} of them, none negative",
                                  what, fmt::join(powers, ", "), count));
}

}  // namespace

PolynomialSystem::PolynomialSystem(int states, int parameters, std::vector<Monomial> terms)
    : states_(states), parameters_(parameters), terms_(std::move(terms)) {
  for (Monomial& term : terms_) {
    if (term.state < 0 || term.state >= states_ || !std::isfinite(term.coefficient)) {
      throw ArgumentError(
          fmt::format("a monomial of state {} with the coefficient {}, expected one of {} states "
                      "and a finite number",
                      term.state, term.coefficient, states_));
    }
    check_powers(term.parameter_powers, parameters_, "parameter");
    check_powers(term.state_powers, states_, "state");
  }
}

void PolynomialSystem::rhs(const Eigen::VectorXd&, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                           Eigen::MatrixXd& f) const {
  f = Eigen::MatrixXd::Zero(x.rows(), x.cols());
  for (const Monomial& term : terms_) {
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      f(term.state, j) +=
          term.coefficient * product(q, j, term.parameter_powers, -1) * product(x, j, term.state_powers, -1);
    }
  }
}

void PolynomialSystem::jacobian(const Eigen::VectorXd&, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                                Eigen::MatrixXd& jacobian) const {
  jacobian = Eigen::MatrixXd::Zero(x.rows() * x.rows(), x.cols());
  for (const Monomial& term : terms_) {
    for (int m = 0; m < states_; ++m) {
      const int exponent = term.state_powers[static_cast<std::size_t>(m)];
      if (exponent == 0) continue;
      for (Eigen::Index j = 0; j < x.cols(); ++j) {
        jacobian(term.state + x.rows() * m, j) +=
            term.coefficient * exponent * product(q, j, term.parameter_powers, -1) *
            product(x, j, term.state_powers, m) * power(x(m, j), exponent - 1);
      }
    }
  }
}

bool PolynomialSystem::affine_in_parameters() const {
  return std::all_of(terms_.begin(), terms_.end(), [](const Monomial& term) {
    return std::accumulate(term.parameter_powers.begin(), term.parameter_powers.end(), 0) <= 1;
  });
}

}  // namespace samara::pgd
