#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/nonlinear/decoupling.h"

namespace samara::pgd {

int DecouplingResult::largest_iterations() const {
  int largest = 0, here = 0;
  for (std::size_t i = 0; i < history.size(); ++i) {
    here = i > 0 && history[i].slab == history[i - 1].slab ? here + 1 : 1;
    largest = std::max(largest, here);
  }
  return largest;
}

Eigen::VectorXd DecouplingResult::value_at(std::span<const double> x) const {
  for (const std::vector<SeparatedField>& fields : slabs) {
    if (x.empty() || !fields.front().axes()[0].contains(x[0])) continue;
    Eigen::VectorXd values(static_cast<Eigen::Index>(fields.size()));
    for (std::size_t m = 0; m < fields.size(); ++m) values[static_cast<Eigen::Index>(m)] = fields[m](x)[0];
    return values;
  }
  throw ArgumentError(
      fmt::format("the time {} is outside what was solved, up to {}", x.empty() ? 0.0 : x[0], reached));
}

double DecouplingResult::largest_contraction() const {
  double largest = 0.0;
  for (const DecouplingRecord& record : history) largest = std::max(largest, record.contraction);
  return largest;
}

int DecouplingResult::largest_rank() const {
  int largest = 0;
  for (const DecouplingRecord& record : history) {
    for (const int terms : record.terms) largest = std::max(largest, terms);
  }
  return largest;
}

}  // namespace samara::pgd
