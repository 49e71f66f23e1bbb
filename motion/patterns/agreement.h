#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

/// How far two labellings of the same things agree. Always report more than the plain share: where one class is
/// large, a constant answer has a large share too.
namespace samara::motion {

struct Agreement {
  Eigen::MatrixXi confusion;   ///< rows: truth, columns: answer
  double share = 0.0;          ///< on which both agree
  double balanced = 0.0;       ///< mean over the classes of the truth of the share that was found
  double kappa = 0.0;          ///< Cohen's: agreement beyond chance; 1: full, 0: that of chance
  double adjusted_rand = 0.0;  ///< over pairs, whatever the classes are called; 1: same partition, 0: chance
};

/// @param truth, answer classes from 0 to `classes` - 1, one per thing
/// @throws ArgumentError for sizes that differ, none at all, or a class outside.
Agreement agreement(const std::vector<int>& truth, const std::vector<int>& answer, int classes);

/// Adjusted Rand index of two partitions with any numbers of classes (L. Hubert, P. Arabie, J. Classification 2
/// (1985) 193-218). @throws ArgumentError as above
double adjusted_rand(const std::vector<int>& first, const std::vector<int>& second);

}  // namespace samara::motion
