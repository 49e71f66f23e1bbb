#pragma once

#include <Eigen/Core>

namespace samara::pgd {

/// Grid indices, one column per entry, one row per mode.
using IndexBatch = Eigen::MatrixXi;

}  // namespace samara::pgd
