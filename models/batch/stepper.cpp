#include "samara/models/batch/stepper.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/bits.h"
#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/base/smoothstep.h"
#include "samara/models/batch/batch_tasks.h"
#include "samara/models/batch/lanes.h"

namespace samara::models {

namespace {

/// Indices of the steered parameters, then of the driven ones, among those of the model.
std::vector<int> steered_indices(const ParametricModel& model, const std::vector<std::string>& steered,
                                 const std::vector<std::string>& driven) {
  std::vector<std::string> names = steered;
  names.insert(names.end(), driven.begin(), driven.end());
  std::vector<int> indices;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(model.free(), name, &FreeCoordinate::name);
    if (found == model.free().end() || found->is_initial) {
      throw ArgumentError(
          fmt::format("\"{}\" was to be steered; a free parameter of the model was expected", name));
    }
    if (std::ranges::count(names, name) > 1) {
      throw ArgumentError(fmt::format("\"{}\" was to be steered twice; once was expected", name));
    }
    indices.push_back(found->index);
  }
  return indices;
}

}  // namespace

struct Stepper::Impl {
  Impl(const ParametricModel& parametric, const std::vector<std::string>& names, Eigen::Index count,
       const Options& options)
      : model(parametric),
        steered(steered_indices(model, names, {})),
        driven(steered_indices(model, names, options.driven)),
        kernel(model.model(), options.tangents ? kernel_directions(model.model()) : 0),
        lane_count(count),
        state_count(parametric.state_count()),
        width((*kernel).width()),
        layers(1 + static_cast<std::size_t>((*kernel).directions())),
        ramps(static_cast<std::size_t>(count)),
        from(static_cast<std::size_t>(count) * steered.size() * layers),
        to(from.size()),
        resting(static_cast<std::size_t>(width) * static_cast<std::size_t>(state_count) * layers) {
    for (Eigen::Index first = 0; first < count; first += width) {
      packs.emplace_back(model, *kernel, std::span<const int>());
    }
    driven.erase(driven.begin(), driven.begin() + std::ssize(steered));
    loaded.assign(packs.size(), 0);
    times.assign(packs.size() * static_cast<std::size_t>(width), 0.0);
    runs.assign(packs.size(), 0);
    moving.assign(packs.size(), 0);
    for (const int index : steered) {
      positions.push_back(static_cast<std::size_t>(
          std::ranges::find_if(model.free(),
                               [&](const FreeCoordinate& c) { return !c.is_initial && c.index == index; }) -
          model.free().begin()));
    }
  }

  /// What the kernels of a law carry; a model without kernels takes as many.
  static int kernel_directions(const Model& model) {
    constexpr int kPlain = 4;
    return model.step_kernels() == nullptr ? kPlain : model.step_kernels()->pack_tangents->directions();
  }

  struct Ramp {
    double start = 0.0, duration = 0.0;
  };

  std::size_t pack_number(Eigen::Index lane) const { return static_cast<std::size_t>(lane / width); }
  Lanes& pack_of(Eigen::Index lane) { return packs[static_cast<std::size_t>(lane / width)]; }
  const Lanes& pack_of(Eigen::Index lane) const { return packs[static_cast<std::size_t>(lane / width)]; }
  int slot_of(Eigen::Index lane) const { return static_cast<int>(lane % width); }
  Ramp& ramp_of(Eigen::Index lane) { return ramps[static_cast<std::size_t>(lane)]; }
  const Ramp& ramp_of(Eigen::Index lane) const { return ramps[static_cast<std::size_t>(lane)]; }
  double& time_of(Eigen::Index lane) { return times[static_cast<std::size_t>(lane)]; }
  double time_of(Eigen::Index lane) const { return times[static_cast<std::size_t>(lane)]; }

  /// A flag of each lane of a pack.
  using Flags = std::vector<std::uint64_t>;
  bool is_set(const Flags& flags, Eigen::Index lane) const {
    return has_bit(flags[pack_number(lane)], slot_of(lane));
  }
  void set(Flags& flags, Eigen::Index lane, bool value) const {
    const std::uint64_t bit = std::uint64_t{1} << slot_of(lane);
    std::uint64_t& all = flags[pack_number(lane)];
    all = value ? all | bit : all & ~bit;
  }
  /// what(lane) for the lanes of a pack whose bit is set.
  template <class What>
  void for_lanes(std::size_t pack, std::uint64_t bits, const What& what) const {
    for_bits(bits, [&](int slot) { what(static_cast<Eigen::Index>(pack) * width + slot); });
  }

  /// Where the numbers of a lane's ramp begin, steered by steered, layer by layer in each.
  std::size_t ramp_place(Eigen::Index lane) const {
    return static_cast<std::size_t>(lane) * steered.size() * layers;
  }

  /// Number n of a lane's ramp at time t.
  double moved(Eigen::Index lane, std::size_t n, double share) const {
    const std::size_t at = ramp_place(lane) + n;
    return gone(from[at], to[at], share);
  }
  double share_at(Eigen::Index lane, double t) const {
    const Ramp& ramp = ramp_of(lane);
    return is_set(moving, lane) ? smoothstep((t - ramp.start) / ramp.duration) : 1.0;
  }

  /// Puts the values of time t into the kernel's parameters.
  void put_parameters(Eigen::Index lane, double t) {
    const double share = share_at(lane, t);
    Lanes& pack = pack_of(lane);
    for (std::size_t j = 0; j < steered.size(); ++j) {
      for (std::size_t layer = 0; layer < layers; ++layer) {
        pack.set_parameter(steered[j], slot_of(lane), static_cast<int>(layer),
                           moved(lane, j * layers + layer, share));
      }
    }
  }

  void begin_ramp(Eigen::Index lane, std::span<const double> target, double duration,
                  const Eigen::Ref<const Eigen::MatrixXd>* by_directions) {
    const double t = time_of(lane), share = share_at(lane, t);
    const std::size_t place = ramp_place(lane);
    for (std::size_t j = 0; j < steered.size(); ++j) {
      for (std::size_t layer = 0; layer < layers; ++layer) {
        const std::size_t n = j * layers + layer;
        from[place + n] = moved(lane, n, share);
        to[place + n] = layer == 0                 ? target[j]
                        : by_directions == nullptr ? 0.0
                                                   : (*by_directions)(static_cast<Eigen::Index>(j),
                                                                      static_cast<Eigen::Index>(layer - 1));
      }
    }
    ramp_of(lane) = {.start = t, .duration = duration};
    set(moving, lane, duration > 0.0);
    put_parameters(lane, t);
    if (defaults_follow) pack_of(lane).complete();
  }

  /// Parameters stay where they are, without tangents.
  void stop_ramp(Eigen::Index lane) {
    const double t = time_of(lane), share = share_at(lane, t);
    const std::size_t place = ramp_place(lane);
    for (std::size_t n = 0; n < steered.size() * layers; ++n) {
      const double value = n % layers == 0 ? moved(lane, n, share) : 0.0;
      from[place + n] = to[place + n] = value;
    }
    set(moving, lane, false);
    put_parameters(lane, t);
    if (defaults_follow) pack_of(lane).complete();
  }

  bool changes(int parameter) const {
    return std::ranges::count(steered, parameter) > 0 || std::ranges::count(driven, parameter) > 0;
  }

  /// Whether defaults of other parameters depend on those that change, by trial at a point.
  bool defaults_depend(std::span<const double> q) const {
    const std::vector<double> here = model.parameters(q);
    for (const double factor : {1.37, 0.61}) {
      std::vector<double> other(q.begin(), q.end());
      for (std::size_t k = 0; k < other.size(); ++k) {
        const FreeCoordinate& coordinate = model.free()[k];
        if (!coordinate.is_initial && changes(coordinate.index)) other[k] = factor * other[k] + 1e-3;
      }
      const std::vector<double> there = model.parameters(other);
      for (std::size_t j = 0; j < here.size(); ++j) {
        if (!changes(static_cast<int>(j)) && here[j] != there[j]) return true;
      }
    }
    return false;
  }

  void step_pack(std::size_t p, double h, long steps) {
    if (runs[p] == 0) return;
    for (long left = steps; left > 0;) {
      const std::uint64_t on_ramps = runs[p] & moving[p];
      for_lanes(p, on_ramps, [&](Eigen::Index lane) { put_parameters(lane, time_of(lane) + 0.5 * h); });
      if (on_ramps != 0 && defaults_follow) packs[p].complete();
      const long now = on_ramps != 0 ? 1 : left;
      advance(p, h, now);
      if (on_ramps != 0) finish_ramps(p, on_ramps, h);
      left -= now;
    }
  }

  /// Lanes that do not run are carried along, and put back.
  void advance(std::size_t p, double h, long steps) {
    const Eigen::Index first = static_cast<Eigen::Index>(p) * width;
    const auto count = static_cast<int>(std::min(lane_count - first, width));
    const std::uint64_t rests = ~runs[p] & (~std::uint64_t{0} >> (64 - count));
    const auto rest_of = [&](Eigen::Index lane) {
      const std::size_t size = resting.size() / static_cast<std::size_t>(width);
      return std::span(resting).subspan(static_cast<std::size_t>(slot_of(lane)) * size, size);
    };
    Lanes& pack = packs[p];
    for_lanes(p, rests, [&](Eigen::Index lane) { pack.save(slot_of(lane), rest_of(lane)); });
    pack.advance({&time_of(first), static_cast<std::size_t>(width)}, h, steps);
    for_lanes(p, rests, [&](Eigen::Index lane) { pack.restore(slot_of(lane), rest_of(lane)); });
    for_lanes(p, runs[p], [&](Eigen::Index lane) { time_of(lane) += h * static_cast<double>(steps); });
  }

  void finish_ramps(std::size_t p, std::uint64_t on_ramps, double h) {
    bool ended = false;
    for_lanes(p, on_ramps, [&](Eigen::Index lane) {
      // What is left of a ramp by round-off is no reason for another step of order 2.
      const double t = time_of(lane);
      if (t - ramp_of(lane).start < ramp_of(lane).duration - 1e-9 * h) return;
      set(moving, lane, false);
      put_parameters(lane, t);
      ended = true;
    });
    if (ended && defaults_follow) packs[p].complete();
  }

  ParametricModel model;
  std::vector<int> steered, driven;    ///< among the parameters of the model
  std::vector<std::size_t> positions;  ///< the same among the free coordinates
  PassKernel kernel;
  Eigen::Index lane_count;
  int state_count;
  Eigen::Index width;
  std::size_t layers;  ///< of a number: its value, then its tangents
  std::vector<Lanes> packs;
  std::vector<char> loaded;   ///< per pack
  Flags runs, moving;         ///< on a ramp
  std::vector<double> times;  ///< of all lanes
  std::vector<Ramp> ramps;
  std::vector<double> from, to;  ///< of all ramps, see ramp_place()
  std::vector<double> resting;   ///< states of lanes that do not run, per slot
  bool is_tried = false, defaults_follow = false;
};

Stepper::Stepper(const ParametricModel& model, const std::vector<std::string>& steered, Eigen::Index lanes,
                 const Options& options) {
  require(lanes > 0, "lanes", lanes, "1 or more");
  impl_ = std::make_unique<Impl>(model, steered, lanes, options);
}
Stepper::~Stepper() = default;
Stepper::Stepper(Stepper&&) noexcept = default;
Stepper& Stepper::operator=(Stepper&&) noexcept = default;

Eigen::Index Stepper::lanes() const {
  return impl_->lane_count;
}
int Stepper::state_count() const {
  return impl_->state_count;
}
int Stepper::steered_count() const {
  return static_cast<int>(impl_->steered.size());
}
int Stepper::directions() const {
  return static_cast<int>(impl_->layers) - 1;
}

void Stepper::load(Eigen::Index lane, std::span<const double> q) {
  Impl& run = *impl_;
  Lanes& pack = run.pack_of(lane);
  char& loaded = run.loaded[static_cast<std::size_t>(lane / run.width)];
  if (loaded == 0) {  // the other lanes are carried along, and need some values
    for (int slot = 0; slot < pack.width(); ++slot) pack.load(slot, q);
    loaded = 1;
  }
  pack.load(run.slot_of(lane), q);
  run.time_of(lane) = 0.0;
  run.set(run.runs, lane, true);
  run.set(run.moving, lane, false);
  if (!run.is_tried) run.defaults_follow = run.defaults_depend(q);
  run.is_tried = true;
  const std::size_t place = run.ramp_place(lane);
  for (std::size_t j = 0; j < run.steered.size(); ++j) {
    for (std::size_t layer = 0; layer < run.layers; ++layer) {
      const std::size_t n = place + j * run.layers + layer;
      run.from[n] = run.to[n] = layer == 0 ? q[run.positions[j]] : 0.0;
    }
  }
  pack.complete();
}

void Stepper::set_state(Eigen::Index lane, double t, std::span<const double> state) {
  Impl& run = *impl_;
  run.stop_ramp(lane);
  run.time_of(lane) = t;
  run.set(run.runs, lane, true);
  run.pack_of(lane).set_state(run.slot_of(lane), state);
}

void Stepper::set_tangent(Eigen::Index lane, int direction, std::span<const double> tangent) {
  impl_->pack_of(lane).set_tangent(impl_->slot_of(lane), direction, tangent);
}

void Stepper::set_parameters(Eigen::Index lane, std::span<const double> values) {
  ramp(lane, values, 0.0);
}

void Stepper::ramp(Eigen::Index lane, std::span<const double> target, double duration) {
  impl_->begin_ramp(lane, target, duration, nullptr);
}

void Stepper::ramp(Eigen::Index lane, std::span<const double> target, double duration,
                   const Eigen::Ref<const Eigen::MatrixXd>& by_directions) {
  impl_->begin_ramp(lane, target, duration, &by_directions);
}

void Stepper::drive(Eigen::Index lane, std::span<const double> values) {
  Impl& run = *impl_;
  Lanes& pack = run.pack_of(lane);
  for (std::size_t k = 0; k < run.driven.size(); ++k)
    pack.set_parameter(run.driven[k], run.slot_of(lane), values[k]);
  if (run.defaults_follow) pack.complete();
}

void Stepper::set_running(Eigen::Index lane, bool runs) {
  impl_->set(impl_->runs, lane, runs);
}
bool Stepper::runs(Eigen::Index lane) const {
  return impl_->is_set(impl_->runs, lane);
}

void Stepper::step(double h, long steps) {
  for (std::size_t p = 0; p < impl_->packs.size(); ++p) impl_->step_pack(p, h, steps);
}

int Stepper::width() const {
  return static_cast<int>(impl_->width);
}
Eigen::Index Stepper::packs() const {
  return std::ssize(impl_->packs);
}

void Stepper::step_pack(Eigen::Index pack, double h, long steps) {
  impl_->step_pack(static_cast<std::size_t>(pack), h, steps);
}

Stepper::PackView Stepper::pack(Eigen::Index pack) const {
  const auto p = static_cast<std::size_t>(pack);
  const Lanes& lanes = impl_->packs[p];
  return {.times = &impl_->times[p * static_cast<std::size_t>(impl_->width)],
          .states = lanes.states(0),
          .stride = lanes.stride(),
          .running = impl_->runs[p]};
}

std::uint64_t Stepper::finite_lanes(Eigen::Index pack) const {
  // A number times 0 is 0, or not a number.
  std::array<double, 64> sums = {};
  const auto width = static_cast<std::size_t>(impl_->width);
  const Lanes& lanes = impl_->packs[static_cast<std::size_t>(pack)];
  for (std::size_t i = 0; i < static_cast<std::size_t>(state_count()); ++i) {
    const double* states = lanes.states(static_cast<int>(i));
    for (std::size_t k = 0; k < width; ++k) sums[k] += 0.0 * states[k];
  }
  std::uint64_t finite = 0;
  for (std::size_t k = 0; k < width; ++k) finite |= std::uint64_t{sums[k] == 0.0} << k;
  return finite;
}

double Stepper::time(Eigen::Index lane) const {
  return impl_->time_of(lane);
}

double Stepper::state(Eigen::Index index, Eigen::Index lane) const {
  return impl_->pack_of(lane).state(static_cast<int>(index), impl_->slot_of(lane));
}

void Stepper::read(Eigen::Index lane, std::span<double> state) const {
  impl_->pack_of(lane).read(impl_->slot_of(lane), state);
}

void Stepper::read_tangent(Eigen::Index lane, int direction, std::span<double> tangent) const {
  impl_->pack_of(lane).read_tangent(impl_->slot_of(lane), direction, tangent);
}

void Stepper::read_parameters(Eigen::Index lane, std::span<double> values) const {
  const double share = impl_->share_at(lane, impl_->time_of(lane));
  for (std::size_t j = 0; j < values.size(); ++j) values[j] = impl_->moved(lane, j * impl_->layers, share);
}

bool Stepper::finite(Eigen::Index lane) const {
  for (int i = 0; i < state_count(); ++i) {
    if (!std::isfinite(state(i, lane))) return false;
  }
  return true;
}

}  // namespace samara::models
