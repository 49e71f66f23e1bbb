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
  for (const AskedSegment& asked : plan.sequence->segments) {
    if (of_asked_.contains(key_of(asked))) continue;
    std::vector<Eigen::Index> segments;
    for (Eigen::Index n = 0; n < database_.segment_count(); ++n) {
      const MotionSegment& segment = database_.segments[static_cast<std::size_t>(n)];
      const Pattern pattern = database_.runs[static_cast<std::size_t>(segment.run)].pattern;
      if (asked.kind.value_or(segment.kind) == segment.kind && asked.pattern.value_or(pattern) == pattern)
        segments.push_back(n);
    }
    if (!segments.empty()) of_asked_.emplace(key_of(asked), SegmentTree(database_, std::move(segments)));
  }
}

SegmentChoices::Key SegmentChoices::key_of(const AskedSegment& asked) {
  return {asked.kind, asked.pattern};
}

const SegmentTree* SegmentChoices::tree_of(const AskedSegment* asked) const {
  if (asked == nullptr || (!asked->kind && !asked->pattern)) return &tree_;
  const auto found = of_asked_.find(key_of(*asked));
  return found == of_asked_.end() ? nullptr : &found->second;
}

double SegmentChoices::distance(std::span<const double> state, const AskedSegment& asked) const {
  const SegmentTree* tree = tree_of(&asked);
  NearSegment near;
  if (tree == nullptr || tree->nearest(state, {&near, 1}) == 0)
    return std::numeric_limits<double>::infinity();
  return near.distance;
}

std::size_t SegmentChoices::propose(std::span<const double> state, const AskedSegment* asked,
                                    std::span<std::vector<double>> targets) const {
  const SegmentTree* tree = tree_of(asked);
  if (tree == nullptr) return 0;
  std::array<NearSegment, SegmentTree::kMost> near;
  std::array<Eigen::Index, SegmentTree::kMost> runs;
  const std::size_t found = tree->nearest(state, near);
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
