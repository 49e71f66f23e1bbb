#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include <Eigen/Core>

namespace samara::pgd {

/// Places of the values, the largest first; equal ones stay in order.
inline std::vector<Eigen::Index> descending_order(const Eigen::VectorXd& values) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::ranges::stable_sort(order, [&](Eigen::Index a, Eigen::Index b) { return values[a] > values[b]; });
  return order;
}

}  // namespace samara::pgd
