#include "samara/pgd/evolution/polynomial_system.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::pgd {

namespace {

/// Each factor as often as its power says.
std::vector<int> factors(const std::vector<int>& powers) {
  std::vector<int> result;
  for (std::size_t k = 0; k < powers.size(); ++k)
    result.insert(result.end(), static_cast<std::size_t>(powers[k]), static_cast<int>(k));
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
    const std::vector<int> of_parameters = factors(term.parameter_powers);
    rates_.push_back({term.state, term.coefficient, of_parameters, factors(term.state_powers)});
    for (int m = 0; m < states_; ++m) {
      std::vector<int> powers = term.state_powers;
      const int exponent = powers[static_cast<std::size_t>(m)]--;
      if (exponent == 0) continue;
      slopes_.push_back(
          {term.state + states_ * m, term.coefficient * exponent, of_parameters, factors(powers)});
    }
  }
}

void PolynomialSystem::sum(const std::vector<Product>& products, const Eigen::MatrixXd& x,
                           const Eigen::MatrixXd& q, Eigen::MatrixXd& sums) {
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    const double* states = x.data() + x.rows() * j;
    const double* parameters = q.data() + q.rows() * j;
    for (const Product& product : products) {
      double value = product.coefficient;
      for (const int k : product.parameters) value *= parameters[k];
      for (const int m : product.states) value *= states[m];
      sums(product.row, j) += value;
    }
  }
}

void PolynomialSystem::rhs(const Eigen::VectorXd&, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                           Eigen::MatrixXd& f) const {
  f = Eigen::MatrixXd::Zero(states_, x.cols());
  sum(rates_, x, q, f);
}

void PolynomialSystem::jacobian(const Eigen::VectorXd&, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                                Eigen::MatrixXd& jacobian) const {
  jacobian = Eigen::MatrixXd::Zero(Eigen::Index{states_} * states_, x.cols());
  sum(slopes_, x, q, jacobian);
}

bool PolynomialSystem::affine_in_parameters() const {
  return std::all_of(terms_.begin(), terms_.end(), [](const Monomial& term) {
    return std::accumulate(term.parameter_powers.begin(), term.parameter_powers.end(), 0) <= 1;
  });
}

}  // namespace samara::pgd
