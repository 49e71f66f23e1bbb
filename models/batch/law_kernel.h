#pragma once

#include <array>
#include <cstddef>

#include <experimental/simd>

#include "samara/models/batch/dual.h"
#include "samara/models/integrators/step_kernel.h"

/// Marks a function to be compiled with all that it calls inlined; not with sanitizers, whose checks
/// would make this take minutes.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SAMARA_FLAT
#else
#define SAMARA_FLAT [[gnu::flatten]]
#endif

/// The step kernels of a law: the template that law_model.h instantiates for each of them. The instruction
/// set is that of the compiler flags of the source file of the law.
namespace samara::models {

/// As many doubles as a register of the machine holds.
using Pack = std::experimental::native_simd<double>;

/// Tangents carried beside the values in one pass of a kernel.
inline constexpr int kTangentsPerPass = 4;

/// How a scalar of a law lies in memory.
template <class S>
struct LaneLayout;

template <>
struct LaneLayout<double> {
  static constexpr int kWidth = 1;
  static constexpr int kDirections = 0;
  static double load(const double* from) { return *from; }
  static void store(const double& value, double* to) { *to = value; }
};

template <>
struct LaneLayout<Pack> {
  static constexpr int kWidth = static_cast<int>(Pack::size());
  static constexpr int kDirections = 0;
  static Pack load(const double* from) { return Pack(from, std::experimental::element_aligned); }
  static void store(const Pack& value, double* to) { value.copy_to(to, std::experimental::element_aligned); }
};

template <class S, int K>
struct LaneLayout<Dual<S, K>> {
  static constexpr int kWidth = LaneLayout<S>::kWidth;
  static constexpr int kDirections = K;
  static Dual<S, K> load(const double* from) {
    Dual<S, K> x;
    x.a = LaneLayout<S>::load(from);
    for (std::size_t k = 0; k < K; ++k) x.v[k] = LaneLayout<S>::load(from + (k + 1) * kWidth);
    return x;
  }
  static void store(const Dual<S, K>& x, double* to) {
    LaneLayout<S>::store(x.a, to);
    for (std::size_t k = 0; k < K; ++k) LaneLayout<S>::store(x.v[k], to + (k + 1) * kWidth);
  }
};

/// A time of each lane as a scalar of the law: it has no tangents.
template <class S>
struct LaneTime {
  static S load(const double* t) { return LaneLayout<S>::load(t); }
};
template <class S, int K>
struct LaneTime<Dual<S, K>> {
  static Dual<S, K> load(const double* t) {
    Dual<S, K> x(0.0);
    x.a = LaneLayout<S>::load(t);
    return x;
  }
};

/// The scalar of one lane.
template <class S>
struct OneLane {
  using Type = double;
};
template <class S, int K>
struct OneLane<Dual<S, K>> {
  using Type = Dual<double, K>;
};

template <class Law, class S>
class LawKernel final : public StepKernel {
 public:
  explicit LawKernel(const Law& law) : law_(law) {}

  int width() const override { return Layout::kWidth; }
  int directions() const override { return Layout::kDirections; }

  /// Lane by lane: derived defaults may branch on values, and are needed once per trajectory.
  void complete(const char* given, double* p) const override {
    using Lane = typename OneLane<S>::Type;
    constexpr std::size_t kLaneStride = 1 + Layout::kDirections;
    std::array<double, kParameters * kLaneStride> numbers;
    std::array<Lane, kParameters> all;
    for (std::size_t lane = 0; lane < Layout::kWidth; ++lane) {
      for (std::size_t n = 0; n < numbers.size(); ++n) numbers[n] = p[n * Layout::kWidth + lane];
      for (std::size_t j = 0; j < kParameters; ++j) {
        all[j] = LaneLayout<Lane>::load(numbers.data() + j * kLaneStride);
      }
      if constexpr (requires { law_.template complete<Lane>(given, all.data()); })
        law_.template complete<Lane>(given, all.data());
      for (std::size_t j = 0; j < kParameters; ++j) {
        LaneLayout<Lane>::store(all[j], numbers.data() + j * kLaneStride);
      }
      for (std::size_t n = 0; n < numbers.size(); ++n) p[n * Layout::kWidth + lane] = numbers[n];
    }
  }

  /// Flat: calls would pass packs through memory, at twice the cost.
  SAMARA_FLAT void advance(const double* t, double h, long steps, double* x_lanes,
                           const double* p_lanes) const override {
    // Local copies: the compiler sees that nothing else changes them, and moves what depends on the
    // parameters alone out of the loop.
    std::array<S, kStates> x = load<kStates>(x_lanes);
    const std::array<S, kParameters> p = load<kParameters>(p_lanes);
    const S start = LaneTime<S>::load(t);
    for (long step = 0; step < steps; ++step) {
      take_step(start + S(static_cast<double>(step) * h), h, x, p);
    }
    store(x, x_lanes);
  }

 private:
  static constexpr std::size_t kStates = Law::kStates;
  static constexpr std::size_t kParameters = Law::kParameters;
  using Layout = LaneLayout<S>;
  static constexpr std::size_t kStride = Layout::kWidth * (1 + Layout::kDirections);

  /// Kutta's classical method (1901).
  void take_step(const S& t, double h, std::array<S, kStates>& x, const std::array<S, kParameters>& p) const {
    constexpr std::array kNode = {0.0, 0.5, 0.5, 1.0};
    constexpr std::array kWeight = {1.0, 2.0, 2.0, 1.0};
    std::array<S, kStates> y = x;
    std::array<S, kStates> k;
    std::array<S, kStates> sum;
    sum.fill(S(0.0));
    for (std::size_t stage = 0; stage < 4; ++stage) {
      law_.template rhs<S>(t + S(kNode[stage] * h), y.data(), p.data(), k.data());
      for (std::size_t i = 0; i < kStates; ++i) sum[i] = sum[i] + S(kWeight[stage]) * k[i];
      if (stage == 3) break;
      for (std::size_t i = 0; i < kStates; ++i) y[i] = x[i] + S(kNode[stage + 1] * h) * k[i];
    }
    for (std::size_t i = 0; i < kStates; ++i) x[i] = x[i] + S(h / 6.0) * sum[i];
  }

  template <std::size_t N>
  static std::array<S, N> load(const double* from) {
    std::array<S, N> values;
    for (std::size_t i = 0; i < N; ++i) values[i] = Layout::load(from + i * kStride);
    return values;
  }

  template <std::size_t N>
  static void store(const std::array<S, N>& values, double* to) {
    for (std::size_t i = 0; i < N; ++i) Layout::store(values[i], to + i * kStride);
  }

  Law law_;
};

/// The kernels of a law, in one object.
template <class Law>
struct LawKernels {
  explicit LawKernels(const Law& law) : scalar(law), pack(law), pack_tangents(law) {}

  LawKernel<Law, double> scalar;
  LawKernel<Law, Pack> pack;
  LawKernel<Law, Dual<Pack, kTangentsPerPass>> pack_tangents;
  StepKernels all = {&scalar, &pack, &pack_tangents};
};

}  // namespace samara::models
