#pragma once

#include <Eigen/Core>

#include "samara/pgd/axes/axis_tables.h"

/// Axes that are lists of nodes without anything between them: discrete, imported; internal to pgd/axes.
namespace samara::pgd {

AxisTables discrete_tables(AxisLabel label, const Eigen::VectorXd& values);
AxisTables imported_tables(AxisLabel label, const SparseMatrix& mass);

/// The lower one of two that are equally near.
int nearest_node(const AxisTables& tables, double x);

}  // namespace samara::pgd
