#include "samara/motion/ghost/ghost_force.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"
#include "samara/base/unit_labels.h"
#include "samara/motion/events/event_finder.h"
#include "samara/motion/ghost/bounded_quadratic.h"
#include "samara/motion/records/motion_record.h"

namespace samara::motion {

namespace {

using models::ModelInfo;

/// Beyond it squares overflow soon, and no body that nearly floats comes close.
constexpr double kMostWeights = 1e100;

/// Where a model holds the numbers of a pose, then those of the velocities.
std::vector<Eigen::Index> places_of(const ModelInfo& info, bool planar) {
  const auto layout = StateLayout::of(info);
  if (!layout || !layout->has_velocities || layout->is_planar != planar) {
    throw ArgumentError(fmt::format(
        "the path is one in {}, and the states of model \"{}\" are not those of such a body, {}, alone",
        planar ? "a plane" : "space", info.name,
        planar ? "x, y, theta, vx, vy, w" : "x, y, z, qw, qx, qy, qz, ux, uy, uz, wx, wy, wz"));
  }
  std::vector<Eigen::Index> places;
  for (const auto& indices :
       {layout->positions(), layout->attitudes(), layout->velocities(), layout->rates()}) {
    for (const std::size_t i : indices) places.push_back(static_cast<Eigen::Index>(i));
  }
  if (places.size() != info.states.size()) {
    throw ArgumentError(fmt::format(
        "model \"{}\" has states besides the pose and velocities of a body, expected none", info.name));
  }
  return places;
}

/// What the whole path is judged by.
class BodyOnPath {
 public:
  BodyOnPath(const models::ParametricModel& parametric, const PosePath& path)
      : path_(path),
        rates_(path_rates(path)),
        model_(parametric.model()),
        p_(parametric.parameter_values({})),
        places_(places_of(model_.info(), path.is_planar())),
        x_(static_cast<Eigen::Index>(places_.size())),
        dxdt_(x_.size()) {
    find_inertia();
    find_units(parametric);
  }

  Eigen::Index frames() const { return rates_.velocities.rows(); }
  double time(Eigen::Index k) const { return path_.times[k + kEndFrames]; }
  Eigen::Index velocities() const { return rates_.velocities.cols(); }
  double net_weight() const { return net_weight_; }
  double semi_length() const { return semi_length_; }
  const ModelInfo& info() const { return model_.info(); }

  /// Wrenches in the units of the result: force, then torque.
  Eigen::VectorXd ghost(Eigen::Index k) {
    set_state(k);
    model_.rhs(time(k), span(x_), p_, span(dxdt_));
    return wrench_of(rates_.accelerations.row(k).transpose() - velocity_part(dxdt_));
  }

  /// ghost = constant - slopes * coefficients at frame k.
  void split(Eigen::Index k, const std::vector<std::string>& names, Eigen::VectorXd& constant,
             Eigen::MatrixXd& slopes) {
    set_state(k);
    const models::AffineSplit split = models::affine_split(model_, time(k), span(x_), p_);
    Eigen::VectorXd rest = split.constant;
    slopes.resize(velocities(), static_cast<Eigen::Index>(names.size()));
    for (std::size_t j = 0; j < split.names.size(); ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      const auto chosen = std::ranges::find(names, split.names[j]);
      if (chosen != names.end()) {
        slopes.col(chosen - names.begin()) = wrench_of(velocity_part(split.slopes.col(column)));
      } else {
        rest += parameter(split.names[j]) * split.slopes.col(column);
      }
    }
    constant = wrench_of(rates_.accelerations.row(k).transpose() - velocity_part(rest));
  }

  /// By the inertia from accelerations, whose noise is alike along all axes.
  GhostForce::Noise noise() const {
    GhostForce::Noise noise{.frames = noise_of(path_)};
    const Eigen::Index torques = path_.is_planar() ? 1 : 3, forces = velocities() - torques;
    Eigen::VectorXd deviations(velocities());
    deviations << Eigen::VectorXd::Constant(forces, noise.frames.position),
        Eigen::VectorXd::Constant(torques, noise.frames.angle);
    deviations *= std::sqrt(mean_square_gain(path_));
    const Eigen::MatrixXd wrench = inertia_ * deviations.asDiagonal() / net_weight_;
    noise.force = wrench.topRows(forces).norm();
    noise.torque = wrench.bottomRows(torques).norm() / semi_length_;
    return noise;
  }

  /// As databases have them, at the mean square speed of this path.
  int events() {
    const double square =
        rates_.velocities.leftCols(path_.is_planar() ? 2 : 3).rowwise().squaredNorm().mean();
    if (!(square > 0.0)) return 0;
    EventFinder finder(MovingStates(model_.info(), BodySymmetry::none),
                       event_options(square, 2.0 * semi_length_));
    int count = 0;
    for (Eigen::Index k = 0; k < frames(); ++k) {
      set_state(k);
      count += finder.see(time(k), span(x_));
    }
    return count;
  }

 private:
  static std::span<double> span(Eigen::VectorXd& v) { return {v.data(), static_cast<std::size_t>(v.size())}; }

  double parameter(const std::string& name) const {
    const auto& list = model_.info().parameters;
    const auto found = std::ranges::find(list, name, &models::ParameterInfo::name);
    return complete_[static_cast<std::size_t>(found - list.begin())];
  }

  void set_state(Eigen::Index k) {
    Eigen::VectorXd numbers(x_.size());
    numbers << path_.poses.row(k + kEndFrames).transpose(), rates_.velocities.row(k).transpose();
    if (!path_.is_planar()) numbers.segment<4>(3).normalize();
    for (std::size_t i = 0; i < places_.size(); ++i) x_[places_[i]] = numbers[static_cast<Eigen::Index>(i)];
  }

  Eigen::VectorXd velocity_part(const Eigen::VectorXd& states) const {
    Eigen::VectorXd part(velocities());
    const std::size_t first = places_.size() - static_cast<std::size_t>(part.size());
    for (Eigen::Index i = 0; i < part.size(); ++i)
      part[i] = states[places_[first + static_cast<std::size_t>(i)]];
    return part;
  }

  /// From second differences of the kinetic energy, which is a quadratic form of the velocities.
  void find_inertia() {
    complete_ = model_.completed(p_);
    const Eigen::Index n = velocities();
    set_state(0);
    const std::size_t first = places_.size() - static_cast<std::size_t>(n);
    const auto energy = [&](const Eigen::VectorXd& v) {
      for (Eigen::Index i = 0; i < n; ++i) x_[places_[first + static_cast<std::size_t>(i)]] = v[i];
      const std::optional<double> found = model_.kinetic_energy(time(0), span(x_), p_);
      if (found) return *found;
      throw ArgumentError(fmt::format(
          "model \"{}\" has no kinetic energy, from which its inertia would follow", model_.info().name));
    };
    inertia_.resize(n, n);
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(n, n);
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) {
        inertia_(i, j) =
            energy(unit.col(i) + unit.col(j)) - energy(unit.col(i)) - energy(unit.col(j)) + energy(none);
      }
    }
  }

  void find_units(const models::ParametricModel& parametric) {
    const auto& terms = model_.info().force_terms;
    const auto gravity = std::ranges::find(terms, "gravity and buoyancy", &models::ForceTermInfo::name);
    if (gravity == terms.end()) {
      throw ArgumentError(fmt::format("model \"{}\" has no term \"gravity and buoyancy\", the unit of forces",
                                      model_.info().name));
    }
    set_state(0);
    std::vector<models::Wrench> wrenches(terms.size());
    model_.forces(time(0), span(x_), p_, wrenches);
    net_weight_ = wrenches[static_cast<std::size_t>(gravity - terms.begin())].force.norm();
    semi_length_ = 0.5 * motion::MotionStates::body_length(model_, complete_);
    if (!(semi_length_ > 0.0)) semi_length_ = parametric.scales({}).length;
    if (!(net_weight_ > 0.0)) {
      throw ArgumentError(fmt::format("the net weight of \"{}\" is {}, expected a body that does not float",
                                      model_.info().name, net_weight_));
    }
  }

  Eigen::VectorXd wrench_of(const Eigen::VectorXd& acceleration) const {
    Eigen::VectorXd wrench = inertia_ * acceleration / net_weight_;
    wrench.tail(path_.is_planar() ? 1 : 3) /= semi_length_;
    return wrench;
  }

  const PosePath& path_;
  PathRates rates_;
  const models::Model& model_;
  models::ParameterValues p_;
  std::vector<double> complete_;
  std::vector<Eigen::Index> places_;
  Eigen::VectorXd x_, dxdt_;
  Eigen::MatrixXd inertia_;
  double net_weight_ = 0.0, semi_length_ = 0.0;
};

GhostSizes sizes_of(const Eigen::VectorXd& series) {
  std::vector<double> sorted(series.begin(), series.end());
  std::ranges::sort(sorted);
  const auto at = [&](double share) {
    return sorted[static_cast<std::size_t>(share * double(sorted.size() - 1))];
  };
  return {.rms = std::sqrt(series.squaredNorm() / static_cast<double>(series.size())),
          .median = at(0.5),
          .quantile90 = at(0.9),
          .max = sorted.back()};
}

void put(const Eigen::VectorXd& wrench, Eigen::Index k, GhostSeries& series) {
  const Eigen::Index torques = wrench.size() == 3 ? 1 : 3;
  series.force[k] = wrench.head(wrench.size() - torques).norm();
  series.torque[k] = wrench.tail(torques).norm();
}

void finish(GhostSeries& series) {
  series.force_sizes = sizes_of(series.force);
  series.torque_sizes = sizes_of(series.torque);
}

GhostSeries empty_series(Eigen::Index frames) {
  return {.force = Eigen::VectorXd(frames),
          .torque = Eigen::VectorXd(frames),
          .force_sizes = {},
          .torque_sizes = {}};
}

void check_box(const GhostOptions& options, const ModelInfo& info) {
  require(options.window >= 2, "window", options.window, "at least 2 frames");
  for (const auto& [name, range] : options.box) {
    if (std::ranges::count(info.affine_in, name) == 0) {
      throw ArgumentError(fmt::format("\"{}\" is none of the coefficients in which \"{}\" is affine, {}{}",
                                      name, info.name, fmt::join(info.affine_in, ", "),
                                      suggestion(name, info.affine_in)));
    }
    if (!(range.lower < range.upper) || !std::isfinite(range.lower) || !std::isfinite(range.upper)) {
      throw ArgumentError(fmt::format("the range of {} is {} to {}, expected the first to be less", name,
                                      range.lower, range.upper));
    }
  }
}

/// Best coefficients, window by window. Where a window leaves a coefficient open it stays near the one before.
GhostForce::Box best_in_box(BodyOnPath& body, const GhostOptions& options, int events) {
  GhostForce::Box box;
  for (const auto& [name, range] : options.box) box.names.push_back(name);
  const auto count = static_cast<Eigen::Index>(box.names.size());
  Eigen::VectorXd lower(2 * count), upper(2 * count);
  for (Eigen::Index j = 0; j < 2 * count; ++j) {
    const CoefficientRange& range = options.box.at(box.names[static_cast<std::size_t>(j % count)]);
    lower[j] = range.lower;
    upper[j] = range.upper;
  }
  const Eigen::VectorXd width = upper - lower;
  // So weak that it changes forces by 1e-8 of what a coefficient can do.
  constexpr double kStay = 1e-4;
  const Eigen::MatrixXd stay = (kStay * width.cwiseInverse()).cwiseAbs2().asDiagonal();

  box.ghost = empty_series(body.frames());
  box.coefficients.resize(body.frames(), count);
  Eigen::VectorXd z = 0.5 * (lower + upper), constant;
  Eigen::MatrixXd slopes;
  for (Eigen::Index first = 0; first < body.frames(); first += options.window) {
    const Eigen::Index last = std::min(body.frames(), first + options.window);
    Eigen::MatrixXd H = stay;
    Eigen::VectorXd g = stay * z;
    Eigen::MatrixXd rows((last - first) * body.velocities(), 2 * count);
    Eigen::VectorXd right(rows.rows());
    for (Eigen::Index k = first; k < last; ++k) {
      const double share = last - first > 1
                               ? (body.time(k) - body.time(first)) / (body.time(last - 1) - body.time(first))
                               : 0.0;
      body.split(k, box.names, constant, slopes);
      rows.middleRows((k - first) * body.velocities(), body.velocities()) << (1.0 - share) * slopes,
          share * slopes;
      right.segment((k - first) * body.velocities(), body.velocities()) = constant;
    }
    H += rows.transpose() * rows;
    g += rows.transpose() * right;
    z = bounded_minimum(H, g, lower, upper, z);
    const Eigen::VectorXd left = right - rows * z;
    for (Eigen::Index k = first; k < last; ++k) {
      put(left.segment((k - first) * body.velocities(), body.velocities()), k, box.ghost);
      const double share = last - first > 1
                               ? (body.time(k) - body.time(first)) / (body.time(last - 1) - body.time(first))
                               : 0.0;
      box.coefficients.row(k) = ((1.0 - share) * z.head(count) + share * z.tail(count)).transpose();
    }
    z.head(count) = z.tail(count).eval();
  }
  finish(box.ghost);
  double way = 0.0;
  for (Eigen::Index k = 1; k < body.frames(); ++k) {
    way += (box.coefficients.row(k) - box.coefficients.row(k - 1))
               .cwiseAbs()
               .cwiseQuotient(width.head(count).transpose())
               .mean();
  }
  box.travel = way / std::max(1, events);
  return box;
}

}  // namespace

GhostForce ghost_force(const models::ParametricModel& model, const PosePath& path,
                       const GhostOptions& options) {
  if (model.free_count() > 0) {
    throw ArgumentError(fmt::format("\"{}\" is free, expected a model all of whose parameters are fixed",
                                    model.free().front().name));
  }
  check_box(options, model.model().info());
  BodyOnPath body(model, path);
  GhostForce result;
  result.times = path.times.segment(kEndFrames, body.frames());
  result.net_weight = body.net_weight();
  result.semi_length = body.semi_length();
  result.events = body.events();
  result.declared = empty_series(body.frames());
  for (Eigen::Index k = 0; k < body.frames(); ++k) put(body.ghost(k), k, result.declared);
  finish(result.declared);
  if (!(result.declared.force_sizes.rms < kMostWeights && result.declared.torque_sizes.rms < kMostWeights)) {
    throw ArgumentError(fmt::format(
        "the path of {} frames in {:.3g}{} takes forces and torques of {:.0e} net weights or more, expected "
        "times and lengths in the units that its columns name",
        path.times.size(), path.times[path.times.size() - 1] - path.times[0],
        unit_suffix(models::time_unit(model.model().info())), kMostWeights));
  }
  if (path.times.size() >= kFewestFrames) {
    result.noise = body.noise();
    constexpr double kMatters = 0.01;
    result.noise->decides =
        result.noise->force > kMatters && result.declared.force_sizes.rms < 1.5 * result.noise->force;
  }
  if (!options.box.empty()) result.box = best_in_box(body, options, result.events);
  return result;
}

}  // namespace samara::motion
