#include "samara/models/stochastic/realisation_pack.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "samara/models/integrators/trajectory_tools.h"
#include "samara/models/stochastic/gust_ramps.h"
#include "samara/models/stochastic/response_time.h"

namespace samara::models {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class FlightPack {
 public:
  FlightPack(const RealisationPlan& plan, const StepKernel& kernel, SharedProgress& progress)
      : plan_(plan),
        progress_(progress),
        lanes_(plan.model, kernel, {}),
        response_(plan.model, plan.point, plan.layout),
        ramps_(plan.layout, lanes_.width()),
        bodies_(ramps_.lanes()),
        seen_(ramps_.lanes()),
        records_(static_cast<std::size_t>(lanes_.width())),
        t_(records_.size(), 0.0),
        state_(static_cast<std::size_t>(plan.model.state_count())) {
    bodies_.axes = plan.layout.axes();
    bodies_.follows = plan.follows;
  }

  /// @returns false if it was cancelled on the way
  bool fly(long first, long last, long keep) {
    board(first, last, keep);
    double t = 0.0;
    for (std::size_t k = 0; k < plan_.times.size() && any_flies(); ++k) {
      const EqualSteps steps = equal_steps(t, plan_.times[k], plan_.step);
      for (long step = 0; step < steps.count && any_flies(); ++step) {
        if (step % 256 == 0 && !progress_.goes_on()) return false;
        take_step(t + static_cast<double>(step) * steps.length, steps.length);
      }
      t = plan_.times[k];
      for_flying(
          [&](RealisationRecord& record, int lane) { write(record, lane, static_cast<Eigen::Index>(k)); });
    }
    for_flying([&](RealisationRecord& record, int lane) {
      record.displacement = bodies_.position.row(lane) - start_.row(lane);
      record.half_turns = ramps_.half_turns(lane);
    });
    return progress_.goes_on();
  }

  RealisationRecord& record(int lane) { return records_[static_cast<std::size_t>(lane)]; }
  const StepCounts& steps() const { return steps_; }

 private:
  bool any_flies() const { return (bodies_.flies > 0.0).any(); }

  template <class Act>
  void for_flying(const Act& act) {
    for (int lane = 0; lane < lanes_.width(); ++lane) {
      if (bodies_.flies[lane] > 0.0) act(record(lane), lane);
    }
  }

  /// Lanes without a realisation carry the same body.
  void board(long first, long last, long keep) {
    for (int lane = 0; lane < lanes_.width(); ++lane) lanes_.load(lane, plan_.point);
    lanes_.complete();
    ramps_.start(lanes_, bodies_);
    start_ = bodies_.position;
    bodies_.t = 0.0;
    bodies_.air.setZero();
    bodies_.acceleration.setZero();
    bodies_.response_time.setZero();
    bodies_.flies.setZero();
    seen_ = AirsSeen(bodies_.lanes());
    std::vector<Draw> draws;
    for (long number = first; number < last; ++number) {
      const int lane = static_cast<int>(number - first);
      bodies_.flies[lane] = 1.0;
      draws.push_back({.number = static_cast<std::uint64_t>(plan_.antithetic ? number / 2 : number),
                       .mirrored = plan_.antithetic && number % 2 == 1});
      record(lane) = record_of(number, number < keep);
    }
    air_ = plan_.air.side_by_side(draws, bodies_.lanes());
    air_->start(bodies_, seen_);
    bodies_.air = seen_.velocity.rowwise() * bodies_.axes.transpose().array();
    for_flying([&](RealisationRecord& record, int lane) {
      if (!(seen_.inside[lane] > 0.0)) end(record, lane, RealisationStatus::left_flow);
    });
  }

  RealisationRecord record_of(long number, bool is_kept) const {
    const auto times = static_cast<Eigen::Index>(plan_.times.size());
    RealisationRecord record;
    record.landing.realisation = number;
    record.chosen.setConstant(times, static_cast<Eigen::Index>(plan_.states.size()), kNaN);
    if (is_kept) record.all.setConstant(times, plan_.model.state_count(), kNaN);
    return record;
  }

  void take_step(double t, double h) {
    bodies_.t = t;
    bodies_.response_time.setZero();
    if ((seen_.needs_response > 0.0).any()) {
      for_flying([&](RealisationRecord&, int lane) {
        if (seen_.needs_response[lane] > 0.0)
          bodies_.response_time[lane] = response_(lanes_, lane, t, bodies_.air.row(lane));
      });
    }
    air_->step(bodies_, h, seen_);
    for_flying([&](RealisationRecord&, int lane) { steps_.add(h, seen_.time_scale[lane]); });
    if (ramps_.set(t, h, seen_, bodies_, lanes_)) {
      for_flying([&](RealisationRecord& record, int lane) {
        if (!seen_.velocity.row(lane).allFinite()) end(record, lane, RealisationStatus::not_finite);
      });
    }
    std::ranges::fill(t_, t);
    lanes_.advance(t_, h, 1);
    const bool is_any_down = ramps_.look(h, plan_.ground.value_or(-kInfinity), lanes_, bodies_);
    if (is_any_down || !(seen_.inside > 0.0).all())
      for_flying([&](RealisationRecord& record, int lane) { look_after(record, lane, t, h); });
  }

  void look_after(RealisationRecord& record, int lane, double t, double h) {
    const Eigen::Vector3d before = ramps_.before().row(lane), now = bodies_.position.row(lane);
    // What is not finite in any state is so in these at the next step, too.
    if (!now.allFinite() || !bodies_.velocity.row(lane).allFinite()) {
      end(record, lane, RealisationStatus::not_finite);
    } else if (plan_.ground && now.z() <= *plan_.ground) {
      const double share = (before.z() - *plan_.ground) / (before.z() - now.z());
      record.landing.t = t + share * h;
      record.landing.position = before + share * (now - before);
      record.displacement = record.landing.position - start_.row(lane).transpose().matrix();
      end(record, lane, RealisationStatus::landed);
    } else if (!(seen_.inside[lane] > 0.0)) {
      end(record, lane, RealisationStatus::left_flow);
    }
  }

  void end(RealisationRecord& record, int lane, RealisationStatus status) {
    record.status = status;
    record.half_turns = ramps_.half_turns(lane);
    bodies_.flies[lane] = 0.0;
  }

  void write(RealisationRecord& record, int lane, Eigen::Index k) {
    lanes_.read(lane, state_);
    if (!all_finite(state_)) return end(record, lane, RealisationStatus::not_finite);
    for (Eigen::Index s = 0; s < record.chosen.cols(); ++s)
      record.chosen(k, s) = lanes_.state(plan_.states[static_cast<std::size_t>(s)], lane);
    for (Eigen::Index s = 0; s < record.all.cols(); ++s)
      record.all(k, s) = lanes_.state(static_cast<int>(s), lane);
  }

  const RealisationPlan& plan_;
  SharedProgress& progress_;
  Lanes lanes_;
  ResponseTime response_;
  GustRamps ramps_;
  BodiesOnPath bodies_;
  AirsSeen seen_;
  std::unique_ptr<AirAlongPaths> air_;
  VectorsByLane start_;
  std::vector<RealisationRecord> records_;
  StepCounts steps_;
  std::vector<double> t_;
  std::vector<double> state_;
};

}  // namespace

FlownRealisations fly_realisations(const RealisationPlan& plan, long first, long last, long keep,
                                   SharedProgress& progress) {
  const Model& model = plan.model.model();
  const PassKernel pass(model, 0);
  // One alone needs no pack; a lane has the same bits in both.
  const StepKernel& kernel =
      last - first == 1 && model.step_kernels() ? *model.step_kernels()->scalar : *pass;
  FlightPack pack(plan, kernel, progress);
  FlownRealisations flown;
  for (long from = first; from < last; from += kernel.width()) {
    const long to = std::min(last, from + kernel.width());
    if (!pack.fly(from, to, keep)) return {};
    for (long n = from; n < to; ++n)
      flown.records.push_back(std::move(pack.record(static_cast<int>(n - from))));
  }
  flown.steps = pack.steps();
  return flown;
}

}  // namespace samara::models
