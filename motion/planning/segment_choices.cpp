#include "samara/motion/planning/segment_choices.h"

#include <algorithm>
#include <array>
#include <limits>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

namespace samara::motion {

SegmentChoices::SegmentChoices(const MotionPlan& plan)
    : database_(*plan.database), box_(plan.box), tree_(*plan.database) {
  require_same_body(database_, models::ParametricModel(plan.model, plan.fixed, {}));
  const std::vector<std::string>& names = database_.coefficient_names;
  for (const SteeredCoefficient& coefficient : box_) {
    const auto found = std::ranges::find(names, coefficient.name);
    columns_.push_back(found == names.end() ? -1 : found - names.begin());
  }
  if (std::ranges::count(columns_, -1) == std::ssize(columns_))
    throw ArgumentError(
        fmt::format("the motions of the database differ in {}, expected a coefficient that the "
                    "plan may change",
                    names.empty() ? "no coefficient" : join(names)));
  if (!plan.sequence) return;
  for (const auto& [pattern, chain] : plan.sequence->of_pattern) {
    std::vector<Eigen::Index> segments;
    for (Eigen::Index n = 0; n < database_.segment_count(); ++n) {
      const Eigen::Index run = database_.segments[static_cast<std::size_t>(n)].run;
      if (database_.runs[static_cast<std::size_t>(run)].pattern == pattern) segments.push_back(n);
    }
    if (!segments.empty()) of_pattern_.emplace(pattern, SegmentTree(database_, std::move(segments)));
  }
}

const SegmentTree* SegmentChoices::tree_of(const AskedSegment* asked) const {
  if (asked == nullptr || !asked->pattern) return &tree_;
  const auto found = of_pattern_.find(*asked->pattern);
  return found == of_pattern_.end() ? nullptr : &found->second;
}

double SegmentChoices::distance(std::span<const double> state, const AskedSegment& asked) const {
  const SegmentTree* tree = tree_of(&asked);
  NearSegment near;
  if (tree == nullptr || tree->nearest(state, {&near, 1}, asked.kind) == 0)
    return std::numeric_limits<double>::infinity();
  return near.distance;
}

std::size_t SegmentChoices::propose(std::span<const double> state, const AskedSegment* asked,
                                    std::span<std::vector<double>> targets) const {
  const SegmentTree* tree = tree_of(asked);
  if (tree == nullptr) return 0;
  std::array<NearSegment, SegmentTree::kMost> near;
  std::array<Eigen::Index, SegmentTree::kMost> runs;
  const std::size_t found =
      tree->nearest(state, near, asked != nullptr ? asked->kind : std::optional<EventKind>());
  std::size_t count = 0;
  for (std::size_t k = 0; k < found && count < targets.size(); ++k) {
    const Eigen::Index run = database_.segments[static_cast<std::size_t>(near[k].segment)].run;
    const auto known = std::span(runs).first(count);
    if (std::ranges::find(known, run) != known.end()) continue;
    runs[count] = run;
    std::vector<double>& target = targets[count++];
    const Eigen::VectorXd& values = database_.runs[static_cast<std::size_t>(run)].coefficients;
    for (std::size_t j = 0; j < box_.size(); ++j) {
      if (columns_[j] >= 0) target[j] = std::clamp(values[columns_[j]], box_[j].lower, box_[j].upper);
    }
  }
  return count;
}

}  // namespace samara::motion
