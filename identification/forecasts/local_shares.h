#pragma once

#include <map>
#include <span>
#include <vector>

#include <Eigen/Core>

/// Shares of predictors that vary with the motion: moments of the training count the more, the more they are
/// like the one that is asked about.
namespace samara::identification {

/// Of w >= 0, 1 together, the one with the least w . N w.
/// @param normal N, symmetric and positive semidefinite: sums of products of the predictors' errors
/// @param guess to begin with: shares
Eigen::VectorXd least_error_shares(const Eigen::MatrixXd& normal, const Eigen::VectorXd& guess);

/// The weight of training moment k is its own (Huber, of distances by the shares of all) times
/// exp(-|f - f_k|^2/(2 h^2)) + 1/20, f features in units of their scatter. The width h is one of 1/2, 1, 2 and
/// infinity, and shares are those found, or half way from them to the one predictor that was best alone, or all on
/// that one: where parts of the clusters predict the others best.
class LocalShares {
 public:
  /// @param errors of each moment, predicted less measured: predictors x components, finite
  /// @param features a row for each moment, finite
  /// @param clusters of the moments
  /// @throws ArgumentError for sizes that differ
  static LocalShares fit(std::span<const Eigen::MatrixXd> errors, const Eigen::MatrixXd& features,
                         const std::vector<int>& clusters);

  /// Empty if there was no moment to find them from.
  const Eigen::VectorXd& of_all() const { return of_all_; }
  Eigen::VectorXd at(const Eigen::RowVectorXd& features) const;
  /// The same without a cluster of the training, and those in its part.
  Eigen::VectorXd without(int cluster, const Eigen::RowVectorXd& features) const;

 private:
  Eigen::VectorXd found(const Eigen::RowVectorXd& features, std::size_t part, double width) const;
  Eigen::VectorXd drawn(const Eigen::VectorXd& shares, std::size_t part, double to_best) const;
  Eigen::VectorXd shares(const Eigen::RowVectorXd& features, std::size_t part) const;

  std::vector<Eigen::MatrixXd> products_ = {};  ///< of errors, times the moment's own weight
  Eigen::MatrixXd features_ = {};               ///< in units of their scatter
  Eigen::RowVectorXd scatter_ = {};
  std::vector<std::size_t> parts_ = {};      ///< of each moment
  std::map<int, std::size_t> part_of_ = {};  ///< of each cluster
  double width_ = 0.0, to_best_ = 0.0;
  std::vector<Eigen::Index> best_ = {};  ///< predictor, without each part and of all
  Eigen::VectorXd of_all_ = {};
};

}  // namespace samara::identification
