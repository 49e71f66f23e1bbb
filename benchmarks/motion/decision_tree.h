#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace samara::benchmarks::motion_cases {

/// A tree of thresholds on single features, grown by Gini's impurity: what a rule set on examples would be.
class DecisionTree {
 public:
  /// @param points things x features, finite; @param classes one per thing, from 0
  DecisionTree(const Eigen::MatrixXd& points, const std::vector<int>& classes, int depth);
  int operator()(const Eigen::RowVectorXd& point) const;
  /// Features and thresholds, level by level, as text.
  std::string text(const std::vector<std::string>& names) const;

 private:
  struct Node {
    int answer = 0;
    Eigen::Index feature = -1;  ///< -1: a leaf
    double threshold = 0.0;
    std::unique_ptr<Node> below, above;
  };
  static std::unique_ptr<Node> grown(const Eigen::MatrixXd& points, const std::vector<int>& classes,
                                     const std::vector<Eigen::Index>& rows, int depth);
  std::unique_ptr<Node> root_;
};

}  // namespace samara::benchmarks::motion_cases
