#include "samara/models/stochastic/realisation_pack.h"

#include <cmath>
#include <limits>

#include "samara/models/integrators/trajectory_tools.h"
#include "samara/models/stochastic/response_time.h"

namespace samara::models {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// How often a body turns over, by which of its sides is up. Edge-on is neither, so that it does not flicker.
class TurnCounter {
 public:
  void look(double normal_z) {
    if (std::abs(normal_z) < 0.5) return;
    const int side = normal_z > 0.0 ? 1 : -1;
    if (side_ != 0 && side != side_) ++half_turns_;
    side_ = side;
  }
  int half_turns() const { return half_turns_; }

 private:
  int side_ = 0;
  int half_turns_ = 0;
};

/// One realisation on its way, in one lane.
struct Flight {
  std::unique_ptr<AirAlongPath> air;
  BodyOnPath body;
  Eigen::Vector3d start = Eigen::Vector3d::Zero();
  Eigen::Vector3d followed =
      Eigen::Vector3d::Zero();  ///< of its change of velocity in this step, the gust's at once
  TurnCounter turns;
  RealisationRecord record;

  bool goes_on() const { return air && record.status == RealisationStatus::flying; }
};

class FlightPack {
 public:
  FlightPack(const RealisationPlan& plan, const StepKernel& kernel, SharedProgress& progress)
      : plan_(plan),
        progress_(progress),
        lanes_(plan.model, kernel, {}),
        response_(plan.model.model(), plan.layout),
        flights_(static_cast<std::size_t>(lanes_.width())),
        t_(flights_.size(), 0.0),
        state_(static_cast<std::size_t>(plan.model.state_count())) {}

  /// @returns false if it was cancelled on the way
  bool fly(long first, long last, long keep) {
    board(first, last, keep);
    double t = 0.0;
    for (std::size_t k = 0; k < plan_.times.size(); ++k) {
      const EqualSteps steps = equal_steps(t, plan_.times[k], plan_.step);
      for (long step = 0; step < steps.count; ++step) {
        if (step % 256 == 0 && !progress_.goes_on()) return false;
        take_step(t + static_cast<double>(step) * steps.length, steps.length);
      }
      t = plan_.times[k];
      for_flying([&](Flight& flight, int lane) { write(flight, lane, static_cast<Eigen::Index>(k)); });
    }
    for_flying([](Flight& flight, int) { flight.record.displacement = flight.body.position - flight.start; });
    return progress_.goes_on();
  }

  RealisationRecord& record(int lane) { return flights_[static_cast<std::size_t>(lane)].record; }

 private:
  template <class Act>
  void for_flying(const Act& act) {
    for (int lane = 0; lane < lanes_.width(); ++lane) {
      Flight& flight = flights_[static_cast<std::size_t>(lane)];
      if (flight.goes_on()) act(flight, lane);
    }
  }

  /// Lanes without a realisation carry the same body in still air.
  void board(long first, long last, long keep) {
    const auto times = static_cast<Eigen::Index>(plan_.times.size());
    for (int lane = 0; lane < lanes_.width(); ++lane) lanes_.load(lane, plan_.point);
    lanes_.complete();
    for (int lane = 0; lane < lanes_.width(); ++lane) {
      Flight& flight = flights_[static_cast<std::size_t>(lane)];
      flight = {};
      const long number = first + lane;
      if (number >= last) continue;
      const auto draw = static_cast<std::uint64_t>(plan_.antithetic ? number / 2 : number);
      flight.air = plan_.air.realisation(draw, plan_.antithetic && number % 2 == 1);
      flight.body.follows = plan_.follows;
      flight.record.landing.realisation = number;
      flight.record.chosen.setConstant(times, static_cast<Eigen::Index>(plan_.states.size()), kNaN);
      if (number < keep) flight.record.all.setConstant(times, plan_.model.state_count(), kNaN);
      look(flight, lane);
      flight.start = flight.body.position;
      const AirSeen seen = flight.air->start(flight.body);
      flight.body.air = seen.velocity;
      if (!seen.inside) flight.record.status = RealisationStatus::left_flow;
    }
  }

  void take_step(double t, double h) {
    for_flying([&](Flight& flight, int lane) { meet_air(flight, lane, t, h); });
    std::ranges::fill(t_, t);
    lanes_.advance(t_, h, 1);
    for_flying([&](Flight& flight, int lane) { look_after(flight, lane, t, h); });
  }

  /// Sets the ramp of the coming step.
  void meet_air(Flight& flight, int lane, double t, double h) {
    BodyOnPath& body = flight.body;
    body.t = t;
    if (flight.air->needs_response()) body.response_time = response_(lanes_, lane, t, body.air);
    const AirSeen seen = flight.air->step(body, h);
    flight.record.steps.add(h, seen.time_scale);
    if (!seen.inside) {
      flight.record.status = RealisationStatus::left_flow;
      return;
    }
    const Eigen::Vector3d change = seen.velocity - body.air;
    const Eigen::Vector3d rate = change / h;
    // In the middle of the step, or the advection would be right to first order only.
    flight.followed = body.followed(change);
    const Eigen::Vector3d relative =
        body.air - body.velocity + 0.5 * (change - flight.followed - h * body.acceleration);
    const Eigen::Vector3d material = rate + seen.gradient * relative;
    plan_.layout.write([&](int j, double value) { lanes_.set_parameter(j, lane, value); }, t, body.air, rate,
                       material, seen.rotation);
    body.air = seen.velocity;
  }

  void look_after(Flight& flight, int lane, double t, double h) {
    const Eigen::Vector3d before = flight.body.position;
    const Eigen::Vector3d velocity = flight.body.velocity;
    look(flight, lane);
    flight.body.acceleration = (flight.body.velocity - velocity - flight.followed) / h;
    const Eigen::Vector3d& now = flight.body.position;
    // What is not finite in any state is so in these at the next step, too.
    if (!now.allFinite() || !flight.body.velocity.allFinite()) {
      flight.record.status = RealisationStatus::not_finite;
    } else if (plan_.ground && now.z() <= *plan_.ground) {
      const double share = (before.z() - *plan_.ground) / (before.z() - now.z());
      flight.record.status = RealisationStatus::landed;
      flight.record.landing.t = t + share * h;
      flight.record.landing.position = before + share * (now - before);
      flight.record.displacement = flight.record.landing.position - flight.start;
    }
  }

  void look(Flight& flight, int lane) {
    plan_.layout.read([&](int i) { return lanes_.state(i, lane); }, flight.body);
    if (!plan_.layout.has_attitude()) return;
    flight.turns.look(flight.body.attitude(2, 2));
    flight.record.half_turns = flight.turns.half_turns();
  }

  void write(Flight& flight, int lane, Eigen::Index k) {
    RealisationRecord& record = flight.record;
    lanes_.read(lane, state_);
    if (!all_finite(state_)) {
      record.status = RealisationStatus::not_finite;
      return;
    }
    for (Eigen::Index s = 0; s < record.chosen.cols(); ++s)
      record.chosen(k, s) = lanes_.state(plan_.states[static_cast<std::size_t>(s)], lane);
    for (Eigen::Index s = 0; s < record.all.cols(); ++s)
      record.all(k, s) = lanes_.state(static_cast<int>(s), lane);
  }

  const RealisationPlan& plan_;
  SharedProgress& progress_;
  Lanes lanes_;
  ResponseTime response_;
  std::vector<Flight> flights_;
  std::vector<double> t_;
  std::vector<double> state_;
};

}  // namespace

std::vector<RealisationRecord> fly_realisations(const RealisationPlan& plan, long first, long last, long keep,
                                                SharedProgress& progress) {
  const Model& model = plan.model.model();
  const PassKernel pass(model, 0);
  // One alone needs no pack; a lane has the same bits in both.
  const StepKernel& kernel =
      last - first == 1 && model.step_kernels() ? *model.step_kernels()->scalar : *pass;
  FlightPack pack(plan, kernel, progress);
  std::vector<RealisationRecord> records;
  for (long from = first; from < last; from += kernel.width()) {
    const long to = std::min(last, from + kernel.width());
    if (!pack.fly(from, to, keep)) return {};
    for (long n = from; n < to; ++n) records.push_back(std::move(pack.record(static_cast<int>(n - from))));
  }
  return records;
}

}  // namespace samara::models
