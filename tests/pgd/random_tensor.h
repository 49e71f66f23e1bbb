#pragma once

#include <cstdint>
#include <vector>

#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/separated_tensor.h"

/// A sum of `rank` products with standard normal entries and weights.
inline samara::pgd::SeparatedTensor random_tensor(const std::vector<int>& sizes, int rank,
                                                  std::uint64_t seed) {
  samara::pgd::Random random(seed);
  const auto normal = [&random](Eigen::Index) { return random.normal(); };
  samara::pgd::SeparatedTensor tensor;
  tensor.weights = Eigen::VectorXd::NullaryExpr(rank, normal);
  for (const int n : sizes) {
    Eigen::MatrixXd factor(n, rank);
    for (int r = 0; r < rank; ++r) factor.col(r) = Eigen::VectorXd::NullaryExpr(n, normal);
    tensor.factors.push_back(factor);
  }
  return tensor;
}

inline Eigen::MatrixXd random_matrix(int rows, int cols, std::uint64_t seed) {
  return random_tensor({rows}, cols, seed).factors[0];
}

/// Calls visit(index) for every entry of a (small) grid.
template <class Visit>
void for_every_entry(const std::vector<int>& sizes, Visit visit) {
  std::vector<int> index(sizes.size(), 0);
  while (true) {
    visit(index);
    std::size_t k = 0;
    while (k < sizes.size() && ++index[k] == sizes[k]) index[k++] = 0;
    if (k == sizes.size()) return;
  }
}
