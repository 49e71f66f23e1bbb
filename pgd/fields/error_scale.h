#pragma once

#include <Eigen/Core>

/// What errors of an output are divided by: the same in builders and certificates. Compaction does not know sizes.
namespace samara::pgd {

/// The values of an output, as far as they decide that.
struct OutputSpread {
  double range = 0.0;  ///< largest less smallest value
  double floor = 0.0;  ///< least range that counts: the absolute tolerance
  double size = 0.0;   ///< largest absolute value, or the output's characteristic size where that is larger
};

/// The range, at least its floor. Where that is less than 1e-12 of the size the output is constant up to rounding:
/// there the size, and 1 of what is zero. (In doubles 1e-12 of the size is told from its rounding to 2e-4.)
double error_scale(const OutputSpread& output);

/// What is known of outputs beside their values, in their units; empty: nothing.
struct OutputMeasure {
  Eigen::VectorXd floors = {};  ///< least ranges
  Eigen::VectorXd sizes = {};   ///< characteristic sizes
};

/// The same of several outputs, by their smallest and largest values.
Eigen::VectorXd error_scales(const Eigen::VectorXd& smallest, const Eigen::VectorXd& largest,
                             const OutputMeasure& measure);

}  // namespace samara::pgd
