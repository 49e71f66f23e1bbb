#include "samara/pgd/axes/axis_list.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/axes/axis_checks.h"

namespace samara::pgd {

namespace {

void check_entries(const std::string& name, const SparseMatrix& mass) {
  for (Eigen::Index j = 0; j < mass.outerSize(); ++j) {
    for (SparseMatrix::InnerIterator entry(mass, j); entry; ++entry) {
      if (std::isfinite(entry.value())) continue;
      throw ArgumentError(fmt::format("the mass matrix of axis \"{}\" holds {} at ({}, {}), expected finite",
                                      name, entry.value(), entry.row(), entry.col()));
    }
  }
}

/// What every symmetric positive definite matrix obeys and can be seen entry by entry.
void check_positive(const std::string& name, const SparseMatrix& mass) {
  const Eigen::VectorXd diagonal = mass.diagonal();
  for (Eigen::Index i = 0; i < diagonal.size(); ++i) {
    if (diagonal[i] > 0.0) continue;
    throw ArgumentError(
        fmt::format("the mass matrix of axis \"{}\" holds {} on its diagonal, at {}, "
                    "expected more than 0",
                    name, diagonal[i], i));
  }
  const SparseMatrix transpose = mass.transpose();
  const SparseMatrix skew = mass - transpose;
  for (Eigen::Index j = 0; j < mass.outerSize(); ++j) {
    for (SparseMatrix::InnerIterator entry(skew, j); entry; ++entry) {
      const double scale = std::sqrt(diagonal[entry.row()]) * std::sqrt(diagonal[entry.col()]);
      if (std::abs(entry.value()) <= 1e-12 * scale) continue;
      throw ArgumentError(
          fmt::format("the mass matrix of axis \"{}\" is not symmetric: its entries at "
                      "({}, {}) and ({}, {}) differ by {:.3g}",
                      name, entry.row(), entry.col(), entry.col(), entry.row(), entry.value()));
    }
    for (SparseMatrix::InnerIterator entry(mass, j); entry; ++entry) {
      const double scale = std::sqrt(diagonal[entry.row()]) * std::sqrt(diagonal[entry.col()]);
      if (entry.row() == entry.col() || std::abs(entry.value()) < scale) continue;
      throw ArgumentError(
          fmt::format("the mass matrix of axis \"{}\" is not positive definite: its entry {} "
                      "at ({}, {}) is not below {}, the geometric mean of its diagonal there",
                      name, entry.value(), entry.row(), entry.col(), scale));
    }
  }
}

AxisTables list_tables(AxisLabel label, Basis basis, const Eigen::VectorXd& nodes, const SparseMatrix& mass) {
  AxisTables tables;
  tables.label = std::move(label);
  tables.basis = basis;
  tables.lower = nodes[0];
  tables.upper = nodes[nodes.size() - 1];
  tables.nodes = nodes;
  tables.mass = mass;
  tables.mass.makeCompressed();
  tables.weights = mass * Eigen::VectorXd::Ones(nodes.size());
  tables.measure = tables.weights.sum();
  return tables;
}

}  // namespace

AxisTables discrete_tables(AxisLabel label, const Eigen::VectorXd& values) {
  check_increasing(label, values, 1);
  check_no_transform(label, "discrete");
  SparseMatrix identity(values.size(), values.size());
  identity.setIdentity();
  return list_tables(std::move(label), Basis::discrete, values, identity);
}

AxisTables imported_tables(AxisLabel label, const SparseMatrix& mass) {
  check_no_transform(label, "imported");
  if (mass.rows() != mass.cols() || mass.rows() == 0) {
    throw ArgumentError(
        fmt::format("the mass matrix of axis \"{}\" is {} x {}, expected square and not empty", label.name,
                    mass.rows(), mass.cols()));
  }
  check_entries(label.name, mass);
  check_positive(label.name, mass);
  const Eigen::Index n = mass.rows();
  const Eigen::VectorXd indices = Eigen::VectorXd::LinSpaced(n, 0.0, static_cast<double>(n - 1));
  return list_tables(std::move(label), Basis::imported, indices, mass);
}

int nearest_node(const AxisTables& tables, double x) {
  const double* begin = tables.nodes.data();
  const double* last = begin + tables.nodes.size() - 1;
  const double* above = std::lower_bound(begin, last, x);
  const bool below_is_nearer = above != begin && x - above[-1] <= *above - x;
  return static_cast<int>(above - begin) - (below_is_nearer ? 1 : 0);
}

}  // namespace samara::pgd
