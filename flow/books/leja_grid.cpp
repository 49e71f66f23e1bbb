#include "samara/flow/books/leja_grid.h"

#include <cmath>
#include <numbers>

#include "samara/pgd/axes/lagrange.h"
#include "samara/pgd/sampling/leja.h"

namespace samara::flow {

namespace {

/// Acts on all tuples below the counts, the first entry running fastest.
void for_all(const std::vector<int>& counts, const std::function<void(const std::vector<int>&)>& act) {
  std::vector<int> numbers(counts.size(), 0);
  for (;;) {
    act(numbers);
    std::size_t k = 0;
    while (k < counts.size() && ++numbers[k] == counts[k]) numbers[k++] = 0;
    if (k == counts.size()) return;
  }
}

}  // namespace

long LejaGrid::size() const {
  long product = 1;
  for (const int count : counts_) product *= count;
  return product;
}

std::vector<double> LejaGrid::unit_of(const std::vector<int>& numbers) const {
  static const Eigen::VectorXd points = pgd::leja_points(kMost + 1);
  std::vector<double> unit;
  for (const int number : numbers) unit.push_back(points[number]);
  return unit;
}

long LejaGrid::missing(const std::vector<int>& counts) const {
  long count = 0;
  for_all(counts, [&](const std::vector<int>& numbers) { count += has(numbers) ? 0 : 1; });
  return count;
}

void LejaGrid::for_missing(const std::function<void(const std::vector<int>& numbers)>& act) const {
  for_all(counts_, [&](const std::vector<int>& numbers) {
    if (!has(numbers)) act(numbers);
  });
}

Eigen::VectorXd LejaGrid::at(const std::vector<double>& unit) const {
  std::vector<Eigen::VectorXd> weights;
  for (std::size_t k = 0; k < counts_.size(); ++k) {
    const pgd::LagrangeBasis basis(pgd::leja_points(counts_[k]));
    weights.emplace_back(counts_[k]);
    basis.values(unit[k], weights.back());
  }
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(columns_.begin()->second.size());
  for_all(counts_, [&](const std::vector<int>& numbers) {
    double weight = 1.0;
    for (std::size_t k = 0; k < numbers.size(); ++k) weight *= weights[k][numbers[k]];
    if (weight != 0.0) sum += weight * column(numbers);
  });
  return sum;
}

Eigen::MatrixXd LejaGrid::on_chebyshev_points() const {
  Eigen::MatrixXd values(columns_.begin()->second.size(), size());
  Eigen::Index next = 0;
  for_all(counts_, [&](const std::vector<int>& numbers) {
    std::vector<double> unit;
    for (std::size_t k = 0; k < numbers.size(); ++k)
      unit.push_back(-std::cos(std::numbers::pi * numbers[k] / (counts_[k] - 1)));
    values.col(next++) = at(unit);
  });
  return values;
}

}  // namespace samara::flow
