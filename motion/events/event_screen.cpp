#include "samara/motion/events/event_screen.h"

#include <cmath>

#include <experimental/simd>

namespace samara::motion {

using namespace event_rows;

namespace {

namespace simd = std::experimental;

/// atan(sqrt(s))/sqrt(s) for s within [0, 1], to 2e-8: M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions,
/// 4.4.49 (C. Hastings).
template <class V>
V arc_tangent_ratio(const V& s) {
  constexpr std::array kFactors = {-0.0161657367, 0.0429096138, -0.0752896400, 0.1065626393,
                                   -0.1420889944, 0.1999355085, -0.3333314528, 1.0};
  V sum(0.0028662257);
  for (const double factor : kFactors) sum = factor + s * sum;
  return sum;
}

/// How the normal turned between two states, as a factor of their cross product: the swept vector of the arc.
double arc_factor(double sine_square, double cosine) {
  const double sine = std::sqrt(sine_square);
  if (sine == 0.0) return 0.0;  // opposite: about which axis, nobody can tell
  return std::atan2(sine, cosine) / sine;
}

/// Lanes of a pack, as many as V holds.
template <class V>
struct Screen {
  const EventScreen& screen;
  std::size_t first;  // lane

  V get(const double* row) const { return V(row + first, simd::element_aligned); }
  void put(const V& value, double* row) const { value.copy_to(row + first, simd::element_aligned); }

  std::array<V, 3> normals(const LaneRows<const double>& states) const {
    const auto state = [&](std::size_t k) { return get(states.row(screen.attitude[k])); };
    if (screen.attitude_is == EventScreen::Attitude::normal) return {state(0), state(1), state(2)};
    const V w = state(0), x = state(1), y = state(2), z = state(3);
    const V twice = 2.0 / (w * w + x * x + y * y + z * z);
    return {twice * (x * z + w * y), twice * (y * z - w * x), 1.0 - twice * (x * x + y * y)};
  }

  V square_speeds(const LaneRows<const double>& states) const {
    V sum(0.0);
    for (std::size_t i = 0; i < screen.velocity_count; ++i) {
      const V v = get(states.row(screen.velocity[i]));
      sum += v * v;
    }
    return sum;
  }

  void copy(const double* times, const LaneRows<const double>& states, const LaneRows<double>& mark) const {
    put(get(times), mark.row(kTime));
    for (std::size_t i = 0; i < screen.state_count; ++i) put(get(states.row(i)), mark.row(kMarkRows + i));
  }

  V arc_factors(const V& sine_square, const V& cosine) const {
    // Normals of states are of length one: an arc is twice that whose tangent is sine/(1 + cosine).
    const V half = 1.0 / (1.0 + cosine);
    V factor = 2.0 * half * arc_tangent_ratio((1.0 - cosine) * half);
    // Measured normals are of any length.
    const bool is_measured = screen.attitude_is == EventScreen::Attitude::normal;
    const auto is_far = !(cosine >= 0.0);
    if (!is_measured && simd::none_of(is_far)) return factor;
    for (std::size_t k = 0; k < V::size(); ++k) {
      if (is_measured || is_far[k]) factor[k] = arc_factor(sine_square[k], cosine[k]);
    }
    return factor;
  }

  void sweep(const LaneRows<const double>& states, const LaneRows<double>& mark,
             const LaneRows<double>& before, const LaneRows<double>& of_lanes) const {
    if (screen.attitude_is == EventScreen::Attitude::angle) {
      // In the plane y = 0, theta grows by a turn about -y.
      put(-get(states.row(screen.attitude[0])), mark.row(kSwept + 1));
      return;
    }
    const std::array<V, 3> n = normals(states);
    const std::array<V, 3> m = {get(of_lanes.row(kNormal)), get(of_lanes.row(kNormal + 1)),
                                get(of_lanes.row(kNormal + 2))};
    const std::array<V, 3> axis = {m[1] * n[2] - m[2] * n[1], m[2] * n[0] - m[0] * n[2],
                                   m[0] * n[1] - m[1] * n[0]};
    const V factor = arc_factors(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2],
                                 m[0] * n[0] + m[1] * n[1] + m[2] * n[2]);
    for (std::size_t i = 0; i < 3; ++i) {
      put(get(before.row(kSwept + i)) + factor * axis[i], mark.row(kSwept + i));
      put(n[i], of_lanes.row(kNormal + i));
    }
  }

  std::uint64_t see(const double* times, const LaneRows<const double>& states,
                    const std::array<LaneRows<double>, 3>& marks, const LaneRows<double>& of_lanes) const {
    copy(times, states, marks[0]);
    sweep(states, marks[0], marks[1], of_lanes);
    const V t = get(times), now = square_speeds(states);
    put(now, marks[0].row(kSquare));
    const V lowest = get(of_lanes.row(kLowest));
    V least = simd::min(get(of_lanes.row(kLevelLeast)), now);
    V most = simd::max(get(of_lanes.row(kLevelMost)), now);
    V since = get(of_lanes.row(kLevelSince));
    const auto changes = most - least >= screen.prominence;
    where(changes, least) = now;
    where(changes, most) = now;
    where(changes, since) = t;
    put(least, of_lanes.row(kLevelLeast));
    put(most, of_lanes.row(kLevelMost));
    put(since, of_lanes.row(kLevelSince));
    V highest = get(of_lanes.row(kHighest));
    where(lowest == kNone && now > highest, highest) = now;
    put(highest, of_lanes.row(kHighest));
    const V before = get(marks[1].row(kSquare));
    const auto is_minimum =
        before < get(marks[2].row(kSquare)) && before <= now && highest - before >= screen.prominence &&
        get(marks[1].row(kTime)) - get(of_lanes.row(kBegin)) >= screen.shortest && before < lowest;
    const auto open = is_minimum || now - lowest >= screen.prominence || t - since >= screen.steady;
    if (simd::none_of(open)) return 0;
    std::uint64_t bits = 0;
    for (std::size_t k = 0; k < V::size(); ++k) bits |= std::uint64_t{open[k]} << (first + k);
    return bits;
  }
};

using Pack = simd::native_simd<double>;
using One = simd::simd<double, simd::simd_abi::scalar>;

}  // namespace

void EventScreen::begin(std::size_t lane, const LaneRows<double>& mark,
                        const LaneRows<double>& of_lanes) const {
  const LaneRows<const double> states = {mark.row(kMarkRows), mark.stride};
  const Screen<One> one = {*this, lane};
  one.put(one.square_speeds(states), mark.row(kSquare));
  for (std::size_t i = 0; i < 3; ++i) one.put(One(0.0), mark.row(kSwept + i));
  if (attitude_is == Attitude::angle) return one.sweep(states, mark, mark, of_lanes);
  const std::array<One, 3> normal = one.normals(states);
  for (std::size_t i = 0; i < 3; ++i) one.put(normal[i], of_lanes.row(kNormal + i));
}

std::uint64_t EventScreen::see(std::size_t lanes, const double* times, const LaneRows<const double>& states,
                               const std::array<LaneRows<double>, 3>& marks,
                               const LaneRows<double>& of_lanes) const {
  std::uint64_t open = 0;
  std::size_t first = 0;
  for (; first + Pack::size() <= lanes; first += Pack::size())
    open |= Screen<Pack>{*this, first}.see(times, states, marks, of_lanes);
  for (; first < lanes; ++first) open |= Screen<One>{*this, first}.see(times, states, marks, of_lanes);
  return open;
}

}  // namespace samara::motion
