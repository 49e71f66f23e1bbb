#include "samara/models/trajectories/delayed_source.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::models {

namespace {

/// Frames to a piece.
constexpr double kPieceFrames = 4.0;
/// Pieces go on over gaps between frames that are shorter than so many frames.
constexpr double kGapFrames = 2.0;
/// Share of the time between frames that rounding may put a time outside the family.
constexpr double kTimeRounding = 1e-3;

/// The least number of nodes with which the bound for a motion of one radian from frame to frame is met.
/// @param frames length of the piece
Eigen::Index node_count(double frames) {
  constexpr double kBound = 2e-6;
  double bound = 4.0;
  Eigen::Index count = 0;
  while (bound > kBound || count < 2) bound *= 0.25 * frames / static_cast<double>(++count);
  return count;
}

/// Times at which the family is asked, from one end to the other, and the polynomial through their values.
class Piece {
 public:
  /// @param first row of its first node
  Piece(const Interval& span, Eigen::Index count, Eigen::Index first)
      : first_(first), middle_(0.5 * (span.lower + span.upper)), half_(0.5 * span.width()) {
    nodes_.resize(count);
    for (Eigen::Index j = 0; j < count; ++j) {
      nodes_[j] = count == 1
                      ? 0.0
                      : -std::cos(std::numbers::pi * static_cast<double>(j) / static_cast<double>(count - 1));
    }
    scales_.setOnes(count);
    for (Eigen::Index j = 0; j < count; ++j) {
      for (Eigen::Index m = 0; m < count; ++m) {
        if (m != j) scales_[j] /= nodes_[j] - nodes_[m];
      }
    }
  }

  Eigen::Index first() const { return first_; }
  Eigen::Index size() const { return nodes_.size(); }
  double begin() const { return middle_ - half_; }
  double time(Eigen::Index node) const { return middle_ + half_ * nodes_[node]; }

  /// Adds `share` times the weights of the values, and of the rate, at `time`: Lagrange's polynomials as
  /// products of what lies left and right of a node, which are exact at the nodes.
  /// @param weights, rates from the first node on
  void add(double time, double share, double* weights, double* rates) const {
    if (half_ == 0.0) {
      weights[0] += share;
      return;
    }
    const double u = (time - middle_) / half_;
    double left = 1.0, left_rate = 0.0;
    for (Eigen::Index j = 0; j < size(); ++j) {
      double right = 1.0, right_rate = 0.0;
      for (Eigen::Index m = j + 1; m < size(); ++m) {
        right_rate = right_rate * (u - nodes_[m]) + right;
        right *= u - nodes_[m];
      }
      weights[j] += share * scales_[j] * left * right;
      rates[j] += share * scales_[j] / half_ * (left_rate * right + left * right_rate);
      left_rate = left_rate * (u - nodes_[j]) + left;
      left *= u - nodes_[j];
    }
  }

 private:
  Eigen::Index first_;
  double middle_, half_;
  Eigen::VectorXd nodes_;   ///< from -1 to 1
  Eigen::VectorXd scales_;  ///< prod of 1/(u_j - u_m)
};

/// Where the family is asked, and with what weights a frame consists of it.
class NodeGrid {
 public:
  NodeGrid(const Interval& range, const FrameMean& mean, std::vector<double> frames,
           std::optional<double> state, double end_time)
      : mean_(mean), frames_(std::move(frames)), state_(state) {
    const double interval = frame_interval(range);
    for (const Interval& run : runs(range, interval)) {
      // Rounding must not lead out of the times of the family.
      Interval span = run;
      if (span.lower < 0.0 && span.lower >= -kTimeRounding * interval) span.lower = 0.0;
      if (span.upper > end_time && span.upper <= end_time + kTimeRounding * interval) span.upper = end_time;
      add_pieces(span, interval);
    }
    if (state_) {
      state_row_ = std::ranges::upper_bound(times_, *state_) - times_.begin();
      times_.insert(times_.begin() + state_row_, *state_);
    }
    weights_.setZero(static_cast<Eigen::Index>(times_.size()));
    rates_.setZero(weights_.size());
    place_.reserve(weights_.size());
  }

  const std::vector<double>& times() const { return times_; }
  Eigen::Index frame_count() const { return std::ssize(frames_); }
  /// Row of the state that has no delay, if there is one.
  std::optional<Eigen::Index> state_row() const {
    return state_ ? std::optional<Eigen::Index>(state_row_) : std::nullopt;
  }

  /// The weights of a frame are those of rows first() on.
  void weigh(Eigen::Index frame, double delay) {
    const int half = mean_.frames / 2;
    const double share = 1.0 / mean_.frames;
    const double time = frames_[static_cast<std::size_t>(frame)] + delay;
    const Piece& earliest = piece_at(time - half * mean_.interval);
    const Piece& latest = piece_at(time + half * mean_.interval);
    first_ = row_of(earliest.first());
    count_ = row_of(latest.first() + latest.size() - 1) + 1 - first_;
    weights_.segment(first_, count_).setZero();
    rates_.segment(first_, count_).setZero();
    for (int j = -half; j <= half; ++j) {
      const double instant = time + j * mean_.interval;
      const Piece& piece = piece_at(instant);
      add(piece, instant, share);
    }
  }

  Eigen::Index first() const { return first_; }
  auto weights() const { return weights_.segment(first_, count_); }
  auto rates() const { return rates_.segment(first_, count_); }

 private:
  /// The median time between frames; of one frame alone, the width of the range.
  double frame_interval(const Interval& range) const {
    std::vector<double> intervals;
    for (std::size_t k = 1; k < frames_.size(); ++k) {
      if (frames_[k] > frames_[k - 1]) intervals.push_back(frames_[k] - frames_[k - 1]);
    }
    double interval = range.width() > 0.0 ? range.width() : 1.0;
    if (!intervals.empty()) {
      const auto middle = intervals.begin() + std::ssize(intervals) / 2;
      std::ranges::nth_element(intervals, middle);
      interval = *middle;
    }
    return mean_.frames > 1 ? std::min(interval, mean_.interval) : interval;
  }

  /// What frames can reach, without overlaps.
  std::vector<Interval> runs(const Interval& range, double interval) const {
    std::vector<Interval> reached;
    const int half = mean_.frames / 2;
    for (const double frame : frames_) {
      for (int j = -half; j <= half; ++j) {
        const double instant = frame + j * mean_.interval;
        reached.push_back({instant + range.lower, instant + range.upper});
      }
    }
    std::ranges::sort(reached, {}, &Interval::lower);
    // A delay that is held asks for the instants themselves.
    const double gap = range.width() > 0.0 ? kGapFrames * interval : 1e-6 * interval;
    std::vector<Interval> merged;
    for (const Interval& one : reached) {
      if (merged.empty() || one.lower > merged.back().upper + gap) {
        merged.push_back(one);
      } else if (range.width() > 0.0) {
        merged.back().upper = std::max(merged.back().upper, one.upper);
      }
    }
    return merged;
  }

  /// Equal ones, with their ends in common.
  void add_pieces(const Interval& run, double interval) {
    if (run.width() == 0.0) {
      pieces_.emplace_back(run, 1, std::ssize(times_));
      times_.push_back(run.lower);
      return;
    }
    const double count = std::ceil(run.width() / (kPieceFrames * interval));
    const double width = run.width() / count;
    for (double k = 0.0; k < count; ++k) {
      const bool is_last = k + 1.0 == count;
      const Interval span{run.lower + k * width, is_last ? run.upper : run.lower + (k + 1.0) * width};
      const Eigen::Index first = std::ssize(times_) - (k > 0.0 ? 1 : 0);
      pieces_.emplace_back(span, node_count(width / interval), first);
      const Piece& piece = pieces_.back();
      for (Eigen::Index j = k > 0.0 ? 1 : 0; j < piece.size(); ++j) {
        // The ends without rounding.
        times_.push_back(j == 0 ? span.lower : j + 1 == piece.size() ? span.upper : piece.time(j));
      }
    }
  }

  const Piece& piece_at(double time) const {
    auto next = std::ranges::upper_bound(pieces_, time, {}, &Piece::begin);
    if (next == pieces_.begin()) return pieces_.front();
    const auto before = std::prev(next);
    // Of points, rounding may have put the time just before its own.
    if (before->size() == 1 && next != pieces_.end() && next->begin() - time < time - before->begin())
      return *next;
    return *before;
  }

  Eigen::Index row_of(Eigen::Index node) const { return node + (state_ && node >= state_row_ ? 1 : 0); }

  void add(const Piece& piece, double time, double share) {
    place_.assign(piece.size());
    piece.add(time, share, place_.weights.data(), place_.rates.data());
    for (Eigen::Index j = 0; j < piece.size(); ++j) {
      weights_[row_of(piece.first() + j)] += place_.weights[j];
      rates_[row_of(piece.first() + j)] += place_.rates[j];
    }
  }

  /// Weights of one instant, by the nodes of its piece.
  struct Place {
    Eigen::VectorXd weights, rates;
    void reserve(Eigen::Index most) {
      weights.setZero(most);
      rates.setZero(most);
    }
    void assign(Eigen::Index count) {
      weights.head(count).setZero();
      rates.head(count).setZero();
    }
  };

  FrameMean mean_;
  std::vector<double> frames_;
  std::optional<double> state_;
  Eigen::Index state_row_ = 0;
  std::vector<Piece> pieces_;
  std::vector<double> times_;  ///< of the nodes, and of the state
  Place place_;
  Eigen::VectorXd weights_, rates_;  ///< per row
  Eigen::Index first_ = 0, count_ = 0;
};

class DelayedSource final : public TrajectorySource {
 public:
  DelayedSource(NodeGrid grid, std::unique_ptr<TrajectorySource> nodes, Eigen::Index outputs,
                Eigen::Index coordinates, std::vector<int> wanted)
      : grid_(std::move(grid)),
        nodes_(std::move(nodes)),
        outputs_(outputs),
        coordinates_(coordinates),
        wanted_(std::move(wanted)),
        values_(Eigen::MatrixXd::Zero(std::ssize(grid_.times()), outputs)),
        derivatives_(Eigen::MatrixXd::Zero(std::ssize(grid_.times()), outputs * coordinates)) {}

  /// A frame is valid only with all its nodes: of a trajectory that ended before the last one, none is kept.
  TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                             Eigen::MatrixXd* derivatives) override {
    check_point(q, static_cast<std::size_t>(coordinates_) + 1);
    TrajectoryOutcome outcome =
        nodes_->evaluate(q.first(q.size() - 1), values_, derivatives ? &derivatives_ : nullptr);
    if (!outcome) {
      outcome.reached = -1.0;
      return outcome;
    }
    for (Eigen::Index frame = 0; frame < grid_.frame_count(); ++frame) {
      grid_.weigh(frame, q.back());
      const auto weights = grid_.weights();
      const auto rates = grid_.rates();
      for (Eigen::Index o = 0; o < outputs_; ++o) {
        const auto nodes = values_.col(o).segment(grid_.first(), weights.size());
        values(frame, o) = weights.dot(nodes);
        if (!derivatives) continue;
        (*derivatives)(frame, o + outputs_ * coordinates_) = rates.dot(nodes);
        for (const int k : wanted_) {
          const Eigen::Index column = o + outputs_ * k;
          (*derivatives)(frame, column) =
              weights.dot(derivatives_.col(column).segment(grid_.first(), weights.size()));
        }
      }
    }
    if (grid_.state_row()) keep_state(*grid_.state_row(), values, derivatives);
    return outcome;
  }

 private:
  /// The last row has no delay.
  void keep_state(Eigen::Index row, Eigen::MatrixXd& values, Eigen::MatrixXd* derivatives) const {
    const Eigen::Index last = grid_.frame_count();
    values.row(last) = values_.row(row);
    if (!derivatives) return;
    for (const int k : wanted_) {
      derivatives->row(last).segment(outputs_ * k, outputs_) =
          derivatives_.row(row).segment(outputs_ * k, outputs_);
    }
    derivatives->row(last).segment(outputs_ * coordinates_, outputs_).setZero();
  }

  NodeGrid grid_;
  std::unique_ptr<TrajectorySource> nodes_;
  Eigen::Index outputs_, coordinates_;
  std::vector<int> wanted_;
  Eigen::MatrixXd values_, derivatives_;  ///< of the nodes
};

}  // namespace

std::unique_ptr<TrajectorySource> delayed_source(const TrajectoryFamily& family, const Interval& range,
                                                 const FrameMean& mean, const std::vector<double>& times,
                                                 const std::vector<std::string>& outputs,
                                                 const std::vector<int>& wanted) {
  check_frame_mean(mean);
  if (!(range.width() >= 0.0) || !std::isfinite(range.lower) || !std::isfinite(range.upper)) {
    throw ArgumentError(fmt::format(
        "the delay of a clock ranges from {} s to {} s; an interval of finite numbers was expected",
        range.lower, range.upper));
  }
  std::vector<double> frames = times;
  std::optional<double> state;
  if (mean.last_is_state && !times.empty()) {
    state = times.back();
    frames.pop_back();
  }
  NodeGrid grid(range, mean, std::move(frames), state, family.info().end_time);
  std::unique_ptr<TrajectorySource> nodes = family.at(grid.times(), outputs, wanted);
  return std::make_unique<DelayedSource>(std::move(grid), std::move(nodes), std::ssize(outputs),
                                         std::ssize(family.info().coordinates), wanted);
}

}  // namespace samara::models
