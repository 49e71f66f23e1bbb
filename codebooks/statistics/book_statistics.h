#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/statistics/distribution.h"

/// What a codebook says of uncertain inputs: mean, deviation, Sobol' indices and quantiles of its outputs, over time.
/// Means, deviations and indices are integrals of the separated form (pgd/fields/statistics.h); quantiles come from
/// draws, at which it is evaluated. Where pieces overlap, the one that queries come to counts. Of a list, the values of
/// all pieces count alike, nodes of a mesh by their areas.
///
/// Usage:
///   BookStatistics s = take_statistics(book, {.inputs = {{"C_D", {DistributionKind::normal, 1.1, 0.05}}},
///                                             .quantiles = {0.05, 0.95}});
///   s.outputs[o].mean[i], s.outputs[o].total(i, k)     // at s.times[i], of input s.inputs[k]
namespace samara::codebooks {

/// Inputs that are normal together, such as coefficients with the covariance of a fit.
struct JointNormal {
  std::vector<std::string> inputs;
  Eigen::VectorXd mean;        ///< SI
  Eigen::MatrixXd covariance;  ///< inputs x inputs, symmetric, positive semidefinite
};

struct StatisticsRequest {
  /// By the names of coordinates; those left out are uniform over the box.
  std::map<std::string, Distribution> inputs = {};
  std::map<std::string, double> fixed = {};           ///< coordinates that are held, SI
  std::vector<std::vector<std::string>> groups = {};  ///< of inputs to give indices of together
  std::vector<double> quantiles = {};                 ///< shares in (0, 1)
  /// With it all statistics come from draws, and there are no indices, which stand for inputs that are independent.
  /// So it is with codebooks of which a coordinate is counted from a front.
  std::optional<JointNormal> joint = {};
  int draws = 4096;
  std::uint64_t seed = 1;
};

/// Of one output: rows are times, or one where there is none. NaN where an index is not resolved: the output varies by
/// less than twice the largest error that the certificate has found.
struct OutputStatistics {
  std::string name = {}, unit = {};
  Eigen::VectorXd mean = {}, deviation = {};
  Eigen::MatrixXd first_order = {}, total = {};  ///< times x inputs
  /// times x groups: what a group explains alone, and together with all others
  Eigen::MatrixXd group_closed = {}, group_total = {};
  Eigen::MatrixXd quantiles = {};  ///< times x quantiles
};

struct BookStatistics {
  /// That there are indices of. Empty where the box is split into cells, inputs are correlated or one is counted from a
  /// front.
  std::vector<std::string> inputs = {};
  std::vector<std::vector<std::string>> groups = {};
  std::vector<double> quantiles = {};
  Eigen::VectorXd times = {};  ///< s; empty where there is none
  std::vector<OutputStatistics> outputs = {};
  std::vector<std::string> notes = {};  ///< what was left out, and why, a sentence each
};

/// @throws ArgumentError for a name that is no coordinate, or is given twice; time among the inputs; no input left;
///   numbers without meaning; a distribution of which less than half lies inside the box, or nothing in its pieces;
///   a value outside it (OutsideBoxError); a coordinate that is a list in one piece and an interval in another; pieces
///   that overlap as with_pieces_apart() refuses
BookStatistics take_statistics(const Codebook& book, const StatisticsRequest& request = {});

}  // namespace samara::codebooks
