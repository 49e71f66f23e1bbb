#include "samara/flow/books/leja_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

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

std::vector<int> LejaGrid::next_along(std::size_t coordinate) const {
  std::vector<int> numbers(counts_.size(), kMiddle);
  numbers[coordinate] = counts_[coordinate];
  return numbers;
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

std::string GridGrowth::text(const LejaGrid& grid, long most) const {
  std::string counts;
  for (const int count : grid.counts()) counts += fmt::format("{}{}", counts.empty() ? "" : " x ", count);
  return fmt::format(
      "{} flows; the next one along a coordinate differs by {:.3g} from what they foretell{}", counts, worst,
      status == Termination::max_calls ? fmt::format(", and no more than {} flows were allowed", most) : "");
}

GridGrowth grow(LejaGrid& grid, const std::function<Eigen::VectorXd(const std::vector<double>& unit)>& solve,
                const std::function<double(const Eigen::VectorXd&, const Eigen::VectorXd&)>& apart,
                double allowed, long most) {
  GridGrowth growth;
  const auto put = [&](const std::vector<int>& numbers) {
    grid.put(numbers, solve(grid.unit_of(numbers)));
    ++growth.solved;
  };
  for (;;) {
    grid.for_missing(put);
    growth.status = Termination::max_calls;
    const std::size_t coordinates = grid.counts().size();
    long unknown = 0;
    for (std::size_t k = 0; k < coordinates; ++k) unknown += grid.has(grid.next_along(k)) ? 0 : 1;
    if (growth.solved + unknown > most) return growth;
    std::vector<int> larger = grid.counts();
    growth.worst = 0.0;
    for (std::size_t k = 0; k < coordinates; ++k) {
      const std::vector<int> next = grid.next_along(k);
      const Eigen::VectorXd foretold = grid.at(grid.unit_of(next));
      if (!grid.has(next)) put(next);
      const double error = apart(foretold, grid.column(next));
      growth.worst = std::max(growth.worst, error);
      if (error > allowed) ++larger[k];
    }
    if (larger == grid.counts()) {
      growth.status = Termination::converged;
      // Of one coordinate the flow that was compared with is all that a larger grid needs.
      if (coordinates == 1) grid.set_counts({larger[0] + 1});
      return growth;
    }
    if (growth.solved + grid.missing(larger) > most) return growth;
    if (*std::ranges::max_element(larger) > LejaGrid::kMost) {
      growth.status = Termination::exhausted;
      return growth;
    }
    grid.set_counts(larger);
  }
}

double in_interval(double lower, double upper, double unit) {
  return std::clamp(lower + 0.5 * (1.0 + unit) * (upper - lower), lower, upper);
}

}  // namespace samara::flow
