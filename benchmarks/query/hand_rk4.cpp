#include "hand_rk4.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numbers>

#include <experimental/simd>

#include "samara/codebooks/query/kernels/kernels.h"
#include "samara/models/batch/dual.h"
#include "samara/models/integrators/step_kernel.h"
#include "samara/models/laws/immersed_body.h"
#include "samara/models/laws/planar_plate.h"

namespace samara::benchmarks {

namespace {

using namespace models;
using Pack = std::experimental::native_simd<double>;
constexpr std::size_t kLanes = Pack::size();

/// The law of falling_plate_nd with its coefficients; all other parameters hold their defaults.
struct PlateLaw {
  static constexpr std::size_t kStates = laws::kPlanarStates;
  static constexpr std::array<std::size_t, 3> kFree = {2, 3, 4};  // C_T, C_R, A
  template <class S>
  static void rhs(const S* x, const S* p, S* dxdt) {
    const S beta2 = p[1] * p[1];
    const S thin = S(1.0) - beta2;
    const laws::EllipticPlate<S> plate{.mass_x = p[0] + beta2,
                                       .mass_y = p[0] + S(1.0),
                                       .inertia = S(0.25) * (p[0] * (S(1.0) + beta2) + S(0.5) * thin * thin),
                                       .weight = S(1.0),
                                       .flow = {.lift_T = S(2.0 / std::numbers::pi) * p[2],
                                                .lift_R = S(2.0 / std::numbers::pi) * p[3],
                                                .drag_chord = S(1.0 / std::numbers::pi) * (p[4] - p[5]),
                                                .drag_normal = S(1.0 / std::numbers::pi) * (p[4] + p[5]),
                                                .drag_floor = S(1.0 / std::numbers::pi) * p[4],
                                                .damping = p[6],
                                                .damping_abs = p[7],
                                                .speed_floor = p[8],
                                                .Re = laws::reynolds_speeds(p[9], p[10], S(1.0), p[11])}};
    plate.rhs(x, dxdt);
  }
};

struct BodyLaw {
  using Law = laws::ImmersedBodyIn<laws::StillFluid>;
  static constexpr std::size_t kStates = Law::kStates;
  static constexpr std::array<std::size_t, 3> kFree = {laws::ImmersedBody::kCD90, laws::ImmersedBody::kCT,
                                                       laws::ImmersedBody::kCR};
  template <class S>
  static void rhs(const S* x, const S* p, S* dxdt) {
    Law().rhs(S(0.0), x, p, dxdt);
  }
};

/// Eight vectors of eight become their transpose.
using Eight [[gnu::vector_size(64)]] = double;
using Places [[gnu::vector_size(64)]] = long long;
void transpose(std::array<Eight, 8>& m) {
  std::array<Eight, 8> a, b;
  for (std::size_t i = 0; i < 8; i += 2) {
    a[i] = __builtin_shuffle(m[i], m[i + 1], Places{0, 8, 2, 10, 4, 12, 6, 14});
    a[i + 1] = __builtin_shuffle(m[i], m[i + 1], Places{1, 9, 3, 11, 5, 13, 7, 15});
  }
  for (std::size_t i : {0, 1, 4, 5}) {
    b[i] = __builtin_shuffle(a[i], a[i + 2], Places{0, 1, 8, 9, 4, 5, 12, 13});
    b[i + 2] = __builtin_shuffle(a[i], a[i + 2], Places{2, 3, 10, 11, 6, 7, 14, 15});
  }
  for (std::size_t i = 0; i < 4; ++i) {
    m[i] = __builtin_shuffle(b[i], b[i + 4], Places{0, 1, 2, 3, 8, 9, 10, 11});
    m[i + 4] = __builtin_shuffle(b[i], b[i + 4], Places{4, 5, 6, 7, 12, 13, 14, 15});
  }
}

template <class Law>
class HandRk4Of final : public HandRk4 {
 public:
  explicit HandRk4Of(const ParametricModel& model) : model_(model) {
    const std::size_t parameters = model.model().info().parameters.size();
    std::vector<double> q;
    for (const FreeCoordinate& free : model.free())
      q.push_back(
          model.model().info().parameters[static_cast<std::size_t>(free.index)].default_value.value_or(1.0));
    const ParameterValues values = model.parameter_values(q);
    for (std::size_t j = 0; j < parameters; ++j)
      p_[j] =
          values.given[j] ? values.value[j] : model.model().info().parameters[j].default_value.value_or(0.0);
    model.model().step_kernels()->scalar->complete(values.given.data(), p_.data());
    model.initial(q, start_);
  }

  void prepare(const Frames& frames, int steps) override {
    frames_ = frames;
    steps_ = steps;
    h_ = frames.end() / steps;
    places_.clear();
    for (const double t : frames.times) {
      const int i = std::clamp(static_cast<int>(t / h_), 0, steps - 1);
      const double s = t / h_ - i;
      const double r = 1.0 - s;
      places_.push_back(
          {i, {(1.0 + 2.0 * s) * r * r, h_ * s * r * r, s * s * (3.0 - 2.0 * s), -h_ * s * s * r}});
    }
    nodes_.resize(static_cast<std::size_t>(steps + 1));
    pack_nodes_.resize(nodes_.size());
    tangent_nodes_.resize(nodes_.size());
    for (std::vector<double>& lane : lanes_) lane.assign(frames.times.size() * frames.outputs.size(), 0.0);
  }

  void end_point(const double* q, double* values) override {
    std::array<double, kMostParameters> p = p_;
    for (std::size_t k = 0; k < 3; ++k) p[Law::kFree[k]] = q[k];
    std::array<double, kStates> x = start_, f;
    for (int i = 0; i < steps_; ++i) {
      Law::rhs(x.data(), p.data(), f.data());
      step(x, f, p);
    }
    for (std::size_t o = 0; o < frames_.outputs.size(); ++o) values[o] = x[output(o)];
  }

  void trajectory(const double* q, double* values) override {
    std::array<double, kMostParameters> p = p_;
    for (std::size_t k = 0; k < 3; ++k) p[Law::kFree[k]] = q[k];
    run(start_, p, nodes_);
    const std::size_t times = places_.size();
    for (std::size_t first = 0; first < times; first += 8) {
      const std::size_t count = std::min<std::size_t>(8, times - first);
      for (std::size_t state = 0; state < kStates; state += 8) {
        std::array<Eight, 8> rows = {};
        for (std::size_t i = 0; i < count; ++i) {
          const Place& at = places_[first + i];
          const Node<double>& a = nodes_[static_cast<std::size_t>(at.step)];
          const Node<double>& b = nodes_[static_cast<std::size_t>(at.step) + 1];
          rows[i] = at.weights[0] * eight(a.x.data() + state) + at.weights[1] * eight(a.f.data() + state) +
                    at.weights[2] * eight(b.x.data() + state) + at.weights[3] * eight(b.f.data() + state);
        }
        transpose(rows);
        for (std::size_t o = 0; o < frames_.outputs.size(); ++o) {
          if (output(o) < state || output(o) >= state + 8) continue;
          std::memcpy(values + o * times + first, &rows[output(o) - state], count * sizeof(double));
        }
      }
    }
  }

  void batch(const Eigen::MatrixXd& points, Eigen::MatrixXd& values) override {
    const std::size_t times = places_.size();
    std::array<Pack, kMostParameters> p;
    for (std::size_t j = 0; j < p.size(); ++j) p[j] = Pack(p_[j]);
    std::array<Pack, kStates> start;
    for (std::size_t i = 0; i < kStates; ++i) start[i] = Pack(start_[i]);
    for (Eigen::Index first = 0; first < points.cols(); first += static_cast<Eigen::Index>(kLanes)) {
      const auto last = points.cols() - 1;
      for (std::size_t k = 0; k < 3; ++k) {
        p[Law::kFree[k]] = Pack([&](auto lane) {
          return points(static_cast<Eigen::Index>(k),
                        std::min(last, first + static_cast<Eigen::Index>(+lane)));
        });
      }
      run(start, p, pack_nodes_);
      for (std::size_t o = 0; o < frames_.outputs.size(); ++o) {
        for (std::size_t at = 0; at < times; at += 8) {
          const std::size_t count = std::min<std::size_t>(8, times - at);
          std::array<Eight, 8> rows = {};
          for (std::size_t i = 0; i < count; ++i) {
            const Pack frame = hermite(pack_nodes_, places_[at + i], output(o));
            static_assert(kLanes == 8 || kLanes < 8);
            std::memcpy(&rows[i], &frame, sizeof frame);
          }
          if constexpr (kLanes == 8) transpose(rows);
          for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const Eigen::Index column = first + static_cast<Eigen::Index>(lane);
            if (column > last) break;
            double* to = lanes_[lane].data() + o * times + at;
            if (kLanes == 8 && count == 8) {
              std::memcpy(to, &rows[lane], sizeof(Eight));
            } else if (kLanes == 8) {
              std::memcpy(to, &rows[lane], count * sizeof(double));
            } else {
              for (std::size_t i = 0; i < count; ++i) to[i] = rows[i][lane];
            }
          }
        }
      }
      // As our own batches: trajectories are put together before they go to memory, and past the caches.
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const Eigen::Index column = first + static_cast<Eigen::Index>(lane);
        if (column > last) break;
        codebooks::kernels::stream(lanes_[lane].data(), values.rows(), values.col(column).data());
      }
    }
  }

  void with_tangents(const double* q, double* values, double* slopes) override {
    std::array<Tangent, kMostParameters> p;
    for (std::size_t j = 0; j < p.size(); ++j) p[j] = Tangent(p_[j]);
    for (std::size_t k = 0; k < 3; ++k) {
      p[Law::kFree[k]] = Tangent(q[k]);
      p[Law::kFree[k]].v[k] = 1.0;
    }
    std::array<Tangent, kStates> start;
    for (std::size_t i = 0; i < kStates; ++i) start[i] = Tangent(start_[i]);
    run(start, p, tangent_nodes_);
    const std::size_t times = places_.size();
    const std::size_t rows = times * frames_.outputs.size();
    for (std::size_t o = 0; o < frames_.outputs.size(); ++o) {
      for (std::size_t i = 0; i < times; ++i) {
        const Place& at = places_[i];
        const Node<Tangent>& a = tangent_nodes_[static_cast<std::size_t>(at.step)];
        const Node<Tangent>& b = tangent_nodes_[static_cast<std::size_t>(at.step) + 1];
        const std::size_t s = output(o);
        values[o * times + i] = at.weights[0] * a.x[s].a + at.weights[1] * a.f[s].a +
                                at.weights[2] * b.x[s].a + at.weights[3] * b.f[s].a;
        for (std::size_t k = 0; k < 3; ++k)
          slopes[o * times + i + rows * k] = at.weights[0] * a.x[s].v[k] + at.weights[1] * a.f[s].v[k] +
                                             at.weights[2] * b.x[s].v[k] + at.weights[3] * b.f[s].v[k];
      }
    }
  }

  void rate(const double* q, const double* x, double* dxdt) override {
    std::array<double, kMostParameters> p = p_;
    for (std::size_t k = 0; k < 3; ++k) p[Law::kFree[k]] = q[k];
    Law::rhs(x, p.data(), dxdt);
  }

 private:
  static constexpr std::size_t kStates = Law::kStates;
  static constexpr std::size_t kMostParameters = 64;
  using Tangent = Dual<double, 3>;
  struct Place {
    int step = 0;
    std::array<double, 4> weights = {};  ///< of x and f at the step's begin, then at its end
  };
  /// States and rates at the end of a step; some room after them for vectors.
  template <class S>
  struct Node {
    std::array<S, (kStates + 7) / 8 * 8> x = {};
    std::array<S, (kStates + 7) / 8 * 8> f = {};
  };

  static Eight eight(const double* from) {
    Eight v;
    std::memcpy(&v, from, sizeof v);
    return v;
  }
  std::size_t output(std::size_t o) const { return static_cast<std::size_t>(frames_.outputs[o]); }

  /// A step from x with f there.
  template <class S>
  [[gnu::always_inline]] void step(std::array<S, kStates>& x, const std::array<S, kStates>& f,
                                   const std::array<S, kMostParameters>& p) const {
    std::array<S, kStates> y, k2, k3, k4;
    for (std::size_t i = 0; i < kStates; ++i) y[i] = x[i] + S(0.5 * h_) * f[i];
    Law::rhs(y.data(), p.data(), k2.data());
    for (std::size_t i = 0; i < kStates; ++i) y[i] = x[i] + S(0.5 * h_) * k2[i];
    Law::rhs(y.data(), p.data(), k3.data());
    for (std::size_t i = 0; i < kStates; ++i) y[i] = x[i] + S(h_) * k3[i];
    Law::rhs(y.data(), p.data(), k4.data());
    for (std::size_t i = 0; i < kStates; ++i)
      x[i] = x[i] + S(h_ / 6.0) * (f[i] + S(2.0) * (k2[i] + k3[i]) + k4[i]);
  }

  template <class S>
  [[gnu::flatten]] void run(const std::array<S, kStates>& start, const std::array<S, kMostParameters>& p,
                            std::vector<Node<S>>& nodes) const {
    std::array<S, kStates> x = start, f;
    for (int i = 0;; ++i) {
      Law::rhs(x.data(), p.data(), f.data());
      Node<S>& node = nodes[static_cast<std::size_t>(i)];
      std::copy(x.begin(), x.end(), node.x.begin());
      std::copy(f.begin(), f.end(), node.f.begin());
      if (i == steps_) break;
      step(x, f, p);
    }
  }

  static Pack hermite(const std::vector<Node<Pack>>& nodes, const Place& at, std::size_t state) {
    const Node<Pack>& a = nodes[static_cast<std::size_t>(at.step)];
    const Node<Pack>& b = nodes[static_cast<std::size_t>(at.step) + 1];
    return at.weights[0] * a.x[state] + at.weights[1] * a.f[state] + at.weights[2] * b.x[state] +
           at.weights[3] * b.f[state];
  }

  ParametricModel model_;
  std::array<double, kMostParameters> p_ = {};
  std::array<double, kStates> start_ = {};
  Frames frames_;
  int steps_ = 1;
  double h_ = 1.0;
  std::vector<Place> places_;
  std::vector<Node<double>> nodes_;
  std::vector<Node<Pack>> pack_nodes_;
  std::vector<Node<Tangent>> tangent_nodes_;
  std::array<std::vector<double>, kLanes> lanes_;  ///< trajectories of a pack
};

}  // namespace

std::unique_ptr<HandRk4> plate_rk4(const ParametricModel& model) {
  return std::make_unique<HandRk4Of<PlateLaw>>(model);
}
std::unique_ptr<HandRk4> body_rk4(const ParametricModel& model) {
  return std::make_unique<HandRk4Of<BodyLaw>>(model);
}

}  // namespace samara::benchmarks
