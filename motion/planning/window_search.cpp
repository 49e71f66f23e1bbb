#include "samara/motion/planning/window_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "samara/motion/ghost/bounded_quadratic.h"

namespace samara::motion {

namespace {

constexpr std::size_t kWindow = 6;  ///< knots that move at a time
constexpr std::size_t kAhead = 10;  ///< knots that a window looks ahead
constexpr std::size_t kStride = 3;  ///< knots from window to window
constexpr double kChangeWeight = 0.15;
constexpr int kTrials = 4;  ///< of a window, with more and more damping

long steps_between(const PlannedFall& fall, double from, double to) {
  return std::lround((to - from) / fall.plan().search.step);
}

/// Pieces longer than one and a half of the median one, in three.
std::vector<CourseKnot> with_thirds(const PlannedFall& fall, const std::vector<CourseKnot>& knots,
                                    double end) {
  std::vector<double> lengths;
  for (std::size_t k = 0; k < knots.size(); ++k)
    lengths.push_back((k + 1 < knots.size() ? knots[k + 1].t : end) - knots[k].t);
  std::vector<double> sorted = lengths;
  std::ranges::sort(sorted);
  const double h = fall.plan().search.step;
  std::vector<CourseKnot> all;
  for (std::size_t k = 0; k < knots.size(); ++k) {
    all.push_back(knots[k]);
    const double third = h * std::round(lengths[k] / (3.0 * h));
    if (lengths[k] < 1.5 * sorted[sorted.size() / 2] || third < knots[k].ramp) continue;
    for (const double part : {third, 2.0 * third}) {
      CourseKnot between = knots[k];
      between.t = knots[k].t + part;
      all.push_back(between);
    }
  }
  return all;
}

class Windows {
 public:
  Windows(const PlannedFall& fall, const FallPoint& start, std::vector<CourseKnot> knots)
      : fall_(fall),
        start_(start),
        knots_(std::move(knots)),
        count_(fall.names().size()),
        lanes_(fall.model(), fall.names(), lane_count(fall), {.tangents = true}),
        values_(fall.model(), fall.names(), 1) {
    for (Eigen::Index lane = 0; lane < lanes_.lanes(); ++lane) lanes_.load(lane, fall.natural());
    values_.load(0, fall.natural());
  }

  const std::vector<CourseKnot>& knots() const { return knots_; }

  /// One sweep down the fall. @returns false if it was cancelled
  bool sweep(const ProgressCallback& progress) {
    for (std::size_t first = 0; first < knots_.size(); first += kStride) {
      if (progress &&
          !progress({"refining", static_cast<double>(first) / static_cast<double>(knots_.size())}))
        return false;
      const ReplayedFall now = replay(fall_, start_, knots_);
      if (!std::isfinite(now.cost) || first >= now.at_knots.size()) break;
      improve(first, now);
    }
    return true;
  }

 private:
  static Eigen::Index lane_count(const PlannedFall& fall) {
    const models::Stepper one(fall.model(), fall.names(), 1, {.tangents = true});
    const auto wanted = static_cast<Eigen::Index>(kWindow * fall.names().size());
    return (wanted + one.directions() - 1) / one.directions();
  }

  /// What a window looks at: residuals whose squares sum to its cost, and their derivatives by its unknowns.
  struct Look {
    double cost = std::numeric_limits<double>::infinity();
    Eigen::MatrixXd H;
    Eigen::VectorXd g;
  };

  Eigen::Index unknowns(std::size_t first) const {
    return static_cast<Eigen::Index>(std::min(kWindow, knots_.size() - first) * count_);
  }

  /// Samples about twenty times between knots.
  long samples_every(double length, std::size_t knots) const {
    return std::max(1L, steps_between(fall_, 0.0, length) / static_cast<long>(20 * knots));
  }

  template <class Record>
  bool run(models::Stepper& lanes, std::size_t first, const FallPoint& from, double end, bool seeds,
           const Record& record) {
    const double h = fall_.plan().search.step;
    for (Eigen::Index lane = 0; lane < lanes.lanes(); ++lane) {
      lanes.set_state(lane, from.t, from.state);
      lanes.set_parameters(lane, from.coefficients);
    }
    const std::size_t last = std::min(knots_.size(), first + kAhead);
    const long every = samples_every(end - from.t, last - first);
    long step = 0;
    double t = from.t;
    for (std::size_t k = first; k < last; ++k) {
      for (Eigen::Index lane = 0; lane < lanes.lanes(); ++lane) {
        if (seeds) {
          lanes.ramp(lane, knots_[k].values, knots_[k].ramp, seeds_of(lanes, lane, k - first));
        } else {
          lanes.ramp(lane, knots_[k].values, knots_[k].ramp);
        }
      }
      const double until = k + 1 < last ? knots_[k + 1].t : end;
      for (long left = steps_between(fall_, t, until); left > 0;) {
        const long now = std::min(left, every - step % every);
        lanes.step(h, now);
        left -= now;
        step += now;
        if (step % every != 0) continue;
        if (!lanes.finite(0)) return false;
        record(h * static_cast<double>(every));
      }
      t = until;
    }
    return true;
  }

  Eigen::MatrixXd seeds_of(const models::Stepper& lanes, Eigen::Index lane, std::size_t knot) const {
    const int directions = lanes.directions();
    Eigen::MatrixXd seeds = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(count_), directions);
    for (std::size_t j = 0; j < count_; ++j) {
      const auto unknown = static_cast<Eigen::Index>(knot * count_ + j);
      if (knot < kWindow && unknown / directions == lane)
        seeds(static_cast<Eigen::Index>(j), unknown % directions) = 1.0;
    }
    return seeds;
  }

  double horizon(std::size_t first, const ReplayedFall& now) const {
    return first + kAhead < knots_.size() ? std::min(knots_[first + kAhead].t, now.end.t) : now.end.t;
  }

  /// Changes of coefficients within the window and to the knot behind it.
  void add_changes(std::size_t first, const FallPoint& from, Look& look) const {
    const auto knots = static_cast<Eigen::Index>(std::min(kWindow, knots_.size() - first));
    for (Eigen::Index k = 0; k <= knots; ++k) {
      const std::size_t knot = first + static_cast<std::size_t>(k);
      if (knot >= knots_.size()) break;
      for (std::size_t j = 0; j < count_; ++j) {
        const SteeredCoefficient& range = fall_.plan().box[j];
        const double weight = kChangeWeight / (range.upper - range.lower);
        const double before = k == 0 ? from.heading_for[j] : knots_[knot - 1].values[j];
        const double change = weight * (knots_[knot].values[j] - before);
        look.cost += change * change;
        const Eigen::Index here = k * static_cast<Eigen::Index>(count_) + static_cast<Eigen::Index>(j);
        const Eigen::Index there = here - static_cast<Eigen::Index>(count_);
        if (look.g.size() == 0) continue;
        const bool has_here = k<knots, has_there = k> 0;
        if (has_here) {
          look.H(here, here) += weight * weight;
          look.g[here] += weight * change;
        }
        if (has_there) {
          look.H(there, there) += weight * weight;
          look.g[there] -= weight * change;
        }
        if (has_here && has_there) {
          look.H(here, there) -= weight * weight;
          look.H(there, here) -= weight * weight;
        }
      }
    }
  }

  Look look(std::size_t first, const FallPoint& from, double end, bool derivatives) {
    Look look;
    look.cost = 0.0;
    const Eigen::Index n = unknowns(first);
    if (derivatives) {
      look.H.setZero(n, n);
      look.g.setZero(n);
    }
    models::Stepper& lanes = derivatives ? lanes_ : values_;
    std::vector<double> state(from.state.size()), tangent(state.size());
    Eigen::Matrix3Xd J(3, n);
    const double a = fall_.semi_length();
    const bool finite = run(lanes, first, from, end, derivatives, [&](double weight) {
      lanes.read(0, state);
      const Eigen::Vector3d place = fall_.states().position(state);
      const double share = weight / (end - from.t) / (a * a);
      const Eigen::Vector3d deviation = fall_.deviation(lanes.time(0), place);
      look.cost += share * deviation.squaredNorm();
      if (!derivatives) return;
      const Eigen::Vector3d slope = fall_.plan().sketch->slope(place);
      for (Eigen::Index i = 0; i < n; ++i) {
        lanes.read_tangent(i / lanes.directions(), static_cast<int>(i % lanes.directions()), tangent);
        const Eigen::Vector3d moved = fall_.states().position(tangent);
        J.col(i) = moved - slope * moved.z();
      }
      look.H += share * J.transpose() * J;
      look.g += share * J.transpose() * deviation;
    });
    if (!finite) return {};
    add_changes(first, from, look);
    return look;
  }

  void improve(std::size_t first, const ReplayedFall& now) {
    const FallPoint& from = now.at_knots[first];
    const double end = horizon(first, now);
    if (steps_between(fall_, from.t, end) < 10) return;
    Look here = look(first, from, end, true);
    if (!std::isfinite(here.cost) || !here.H.allFinite()) return;
    const Eigen::Index n = here.g.size();
    Eigen::VectorXd lower(n), upper(n), z(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto j = static_cast<std::size_t>(i) % count_;
      lower[i] = fall_.plan().box[j].lower;
      upper[i] = fall_.plan().box[j].upper;
      z[i] = knots_[first + static_cast<std::size_t>(i) / count_].values[j];
    }
    double damping = 1e-3;
    for (int trial = 0; trial < kTrials; ++trial, damping *= 10.0) {
      Eigen::MatrixXd H = here.H;
      for (Eigen::Index i = 0; i < n; ++i) H(i, i) += damping * (here.H(i, i) + 1e-9 * here.H.trace());
      const Eigen::VectorXd to = bounded_minimum(H, H * z - here.g, lower, upper, z);
      put(first, to);
      const double cost = look(first, from, end, false).cost;
      if (cost < here.cost) return;
    }
    put(first, z);
  }

  void put(std::size_t first, const Eigen::VectorXd& z) {
    for (Eigen::Index i = 0; i < z.size(); ++i)
      knots_[first + static_cast<std::size_t>(i) / count_].values[static_cast<std::size_t>(i) % count_] =
          z[i];
  }

  const PlannedFall& fall_;
  const FallPoint& start_;
  std::vector<CourseKnot> knots_;
  std::size_t count_;
  models::Stepper lanes_, values_;
};

}  // namespace

ReplayedFall replay(const PlannedFall& fall, const FallPoint& start, const std::vector<CourseKnot>& knots) {
  ReplayedFall result;
  const double h = fall.plan().search.step, a = fall.semi_length();
  models::Stepper lane(fall.model(), fall.names(), 1);
  lane.load(0, fall.natural());
  lane.set_state(0, start.t, start.state);
  lane.set_parameters(0, start.coefficients);
  FallPoint now = start;
  double change = 0.0;
  const double most = knots.empty() ? start.t : knots.back().t + 4.0 * fall.longest_piece();
  std::size_t next = 0;
  while (!fall.is_over(now.t, now.height) && now.t < most) {
    if (next < knots.size() && now.t > knots[next].t - 0.5 * h) {
      lane.read_parameters(0, now.coefficients);
      result.at_knots.push_back(now);
      for (std::size_t j = 0; j < knots[next].values.size(); ++j) {
        const SteeredCoefficient& range = fall.plan().box[j];
        change += std::pow(
            kChangeWeight * (knots[next].values[j] - now.heading_for[j]) / (range.upper - range.lower), 2);
      }
      now.heading_for = knots[next].values;
      lane.ramp(0, knots[next].values, knots[next].ramp);
      ++next;
    }
    lane.step(h);
    lane.read(0, now.state);
    if (!lane.finite(0)) {
      result.cost = std::numeric_limits<double>::infinity();
      return result;
    }
    now.t = lane.time(0);
    const Eigen::Vector3d place = fall.states().position(now.state);
    const double before = now.deviation.squaredNorm();
    now.height = place.z();
    now.deviation = fall.deviation(now.t, place);
    now.square_time += 0.5 * h * (before + now.deviation.squaredNorm());
  }
  lane.read_parameters(0, now.coefficients);
  result.end = now;
  const double fallen = std::max(a, fall.release().height - now.height) / a;
  result.cost = now.square_time / std::max(h, now.t) / (a * a) + change / fallen;
  return result;
}

FoundFall refine_in_windows(const PlannedFall& fall, const FallPoint& start, const FoundFall& found,
                            const ProgressCallback& progress, std::vector<PlanningStep>& history) {
  FoundFall best = found;
  best.cost = replay(fall, start, best.knots).cost;
  std::vector<CourseKnot> knots = with_thirds(fall, found.knots, found.end.t);
  for (int sweep = 0; sweep < fall.plan().search.sweeps; ++sweep) {
    Windows windows(fall, start, knots);
    const bool finished = windows.sweep(progress);
    const ReplayedFall now = replay(fall, start, windows.knots());
    const bool improved = now.cost < best.cost;
    if (improved) best = {.knots = windows.knots(), .end = now.end, .cost = now.cost};
    history.push_back(
        {.stage = "windows", .cost = best.cost, .depth = fall.release().height - best.end.height});
    if (!finished || !improved) break;
    knots = best.knots;
  }
  // Knots behind the end of the fall move nothing.
  std::erase_if(best.knots, [&](const CourseKnot& knot) { return knot.t >= best.end.t; });
  return best;
}

}  // namespace samara::motion
