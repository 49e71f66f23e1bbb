#include "motion/decision_tree.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace samara::benchmarks::motion_cases {

namespace {

std::vector<double> counts_of(const std::vector<int>& classes, const std::vector<Eigen::Index>& rows) {
  std::vector<double> counts(static_cast<std::size_t>(*std::ranges::max_element(classes)) + 1, 0.0);
  for (const Eigen::Index row : rows)
    ++counts[static_cast<std::size_t>(classes[static_cast<std::size_t>(row)])];
  return counts;
}

/// Total less the sum of squares over it.
double impurity(const std::vector<double>& counts) {
  double total = 0.0, squares = 0.0;
  for (const double count : counts) {
    total += count;
    squares += count * count;
  }
  return total > 0.0 ? total - squares / total : 0.0;
}

}  // namespace

std::unique_ptr<DecisionTree::Node> DecisionTree::grown(const Eigen::MatrixXd& points,
                                                        const std::vector<int>& classes,
                                                        const std::vector<Eigen::Index>& rows, int depth) {
  auto node = std::make_unique<Node>();
  const std::vector<double> counts = counts_of(classes, rows);
  node->answer = static_cast<int>(std::ranges::max_element(counts) - counts.begin());
  double least = impurity(counts) - 1e-9;
  if (depth == 0 || least <= 0.0) return node;
  constexpr std::size_t kFewest = 10;  // in a leaf
  for (Eigen::Index feature = 0; feature < points.cols(); ++feature) {
    std::vector<Eigen::Index> order = rows;
    std::ranges::sort(order, {}, [&](Eigen::Index row) { return points(row, feature); });
    std::vector<double> below(counts.size(), 0.0), above = counts;
    for (std::size_t k = 0; k + 1 < order.size(); ++k) {
      const auto kind = static_cast<std::size_t>(classes[static_cast<std::size_t>(order[k])]);
      ++below[kind];
      --above[kind];
      const double here = points(order[k], feature), next = points(order[k + 1], feature);
      if (here == next || k + 1 < kFewest || order.size() - k - 1 < kFewest) continue;
      if (const double both = impurity(below) + impurity(above); both < least) {
        least = both;
        node->feature = feature;
        node->threshold = 0.5 * (here + next);
      }
    }
  }
  if (node->feature < 0) return node;
  std::vector<Eigen::Index> low, high;
  for (const Eigen::Index row : rows)
    (points(row, node->feature) < node->threshold ? low : high).push_back(row);
  node->below = grown(points, classes, low, depth - 1);
  node->above = grown(points, classes, high, depth - 1);
  return node;
}

DecisionTree::DecisionTree(const Eigen::MatrixXd& points, const std::vector<int>& classes, int depth) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index n = 0; n < points.rows(); ++n) rows.push_back(n);
  root_ = grown(points, classes, rows, depth);
}

int DecisionTree::operator()(const Eigen::RowVectorXd& point) const {
  const Node* node = root_.get();
  while (node->feature >= 0)
    node = point[node->feature] < node->threshold ? node->below.get() : node->above.get();
  return node->answer;
}

std::string DecisionTree::text(const std::vector<std::string>& names) const {
  std::string all;
  std::vector<const Node*> level = {root_.get()};
  while (!level.empty()) {
    std::vector<const Node*> next;
    for (const Node* node : level) {
      if (node->feature < 0) continue;
      all += fmt::format(" {} < {:.3g};", names[static_cast<std::size_t>(node->feature)], node->threshold);
      next.push_back(node->below.get());
      next.push_back(node->above.get());
    }
    level = std::move(next);
  }
  return all;
}

}  // namespace samara::benchmarks::motion_cases
