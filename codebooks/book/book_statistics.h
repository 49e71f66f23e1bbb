#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/codebook.h"

/// Mean, deviation and Sobol' indices of the outputs of a codebook over its box, all parameters and initial
/// values independent and uniform (pgd/fields/statistics.h), at the nodes of time.
///
///     const BookStatistics s = statistics_of(load("coin.h5"));
///     s.outputs[0].total(i, k);                      // of output 0, at s.times[i], by s.inputs[k]
namespace samara::codebooks {

/// Of one output: rows are times, or one where there is none.
struct OutputStatistics {
  std::string name, unit;
  Eigen::VectorXd mean, deviation;  ///< SI
  /// Times x inputs. NaN where the deviation is below twice the largest error that the certificate has found:
  /// they may be those of the error. Empty of a box that is split into cells.
  Eigen::MatrixXd first_order, total;
};

struct BookStatistics {
  std::vector<std::string> inputs = {};  ///< that there are indices of
  Eigen::VectorXd times = {};            ///< s; empty where there is no time
  std::vector<OutputStatistics> outputs = {};
  std::vector<std::string> warnings = {};  ///< sentences: what is not given at all
  std::vector<std::string> notes = {};     ///< sentences: indices that were left out
};

/// @throws ArgumentError if no parameter is free
BookStatistics statistics_of(const Codebook& book);

}  // namespace samara::codebooks
