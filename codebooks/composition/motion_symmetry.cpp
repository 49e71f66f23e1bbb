#include "samara/codebooks/composition/motion_symmetry.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/models/equations/equation_model.h"
#include "samara/pgd/tensors/random.h"

namespace samara::codebooks {

namespace {

constexpr double kFullTurn = 2.0 * std::numbers::pi;
/// Wrong images fail at the first few; only those that are kept are compared at all.
constexpr std::size_t kDraws = 256;
/// Signs of so many states are tried, one after the other.
constexpr std::size_t kMostSigned = 12;

/// A point of the box: inside in all coordinates, or at one of the ends in two of three.
std::vector<double> drawn(std::span<const DrawnInterval> box, bool is_at_ends, pgd::Random& random) {
  std::vector<double> q;
  for (const DrawnInterval& interval : box) {
    const double share = random.uniform();
    const int place = is_at_ends ? random.below(3) : 2;
    const double width = pgd::transformed_distance(interval.transform, interval.lower, interval.upper);
    q.push_back(place == 0   ? interval.lower
                : place == 1 ? interval.upper
                             : pgd::transformed_advance(interval.transform, interval.lower, share * width));
  }
  return q;
}

/// States and parameters at which f is compared.
class Trials {
 public:
  Trials(const models::ParametricModel& model, std::span<const DrawnInterval> box)
      : model_(model),
        has_parameters_(!std::ranges::all_of(model.free(), &models::FreeCoordinate::is_initial)) {
    pgd::Random random(17);
    for (std::size_t draw = 0; draw < kDraws; ++draw) {
      const std::vector<double> q = drawn(box, draw % 2 == 1, random);
      Eigen::VectorXd offset(model.state_count());
      for (double& number : offset) number = random.uniform() - 0.5;
      add_draw(q, offset);
    }
    sizes_ = Eigen::VectorXd::Zero(model.state_count());
    for (const Draw& draw : draws_) sizes_ = sizes_.cwiseMax(draw.rates.cwiseAbs()).eval();
  }

  const Eigen::VectorXd& sizes() const { return sizes_; }

  /// Whether f at moved(x) is that at x, turned.
  template <class Move, class Turn>
  bool keep(const Move& moved, const Turn& turned) {
    return std::ranges::all_of(draws_, [&](const Draw& draw) {
      return are_same_rates(rate(0.0, draw.at, moved(draw.states)), turned(draw.rates), sizes_);
    });
  }
  bool keep(const MotionImage& image) {
    return 2 * draws_.size() >= kDraws &&
           keep([&](const Eigen::VectorXd& x) { return image.of(x); },
                [&](const Eigen::VectorXd& f) -> Eigen::VectorXd { return image.linear * f; });
  }
  /// Whether f stays as it is when a state is moved.
  bool keep_moved(std::size_t state, double by) {
    const auto moved = [&](Eigen::VectorXd x) {
      x[static_cast<Eigen::Index>(state)] += by;
      return x;
    };
    return keep(moved, [](const Eigen::VectorXd& f) { return f; });
  }
  /// Whether f stays as it is: equations as text if they do not mention the time, others over a window of time and a
  /// quarter of it beyond, at other times for every draw: what acts for a short time is met, too.
  bool keep_in_time(double window) {
    const models::Equations* const text = models::equations_of(model_.model());
    if (text != nullptr && models::mention_time(*text)) return false;
    constexpr int kTimes = 8;
    double share = 0.0;
    return std::ranges::all_of(draws_, [&](const Draw& draw) {
      for (int k = 0; k < kTimes; ++k) {
        share = std::fmod(share + std::numbers::phi, 1.0);
        if (!are_same_rates(rate(1.25 * window * share, draw.at, draw.states), draw.rates, sizes_))
          return false;
      }
      return true;
    });
  }

 private:
  /// Parameters, with a workspace of their own: what a model derives from them is costly, and kept there.
  struct Parameters {
    std::vector<double> q;
    models::ParametricModel::Workspace workspace;
  };
  struct Draw {
    std::size_t at = 0;  ///< its parameters
    Eigen::VectorXd states, rates;
  };

  /// Beside the initial states, since where all begin at zero symmetries hold that are none; nearer where f has no
  /// value that far. None where it has none at all.
  void add_draw(const std::vector<double>& q, const Eigen::VectorXd& offset) {
    if (parameters_.empty() || has_parameters_) parameters_.push_back({q, model_.make_workspace()});
    const models::ModelInfo& info = model_.model().info();
    Eigen::VectorXd start(offset.size()), sizes(offset.size());
    model_.initial(q, {start.data(), info.states.size()});
    const models::Scales scales = model_.scales(q);
    for (Eigen::Index i = 0; i < sizes.size(); ++i)
      sizes[i] = models::state_scale(info.states[static_cast<std::size_t>(i)], scales);
    for (double share = 1.0; share > 1e-3; share *= 0.25) {
      Eigen::VectorXd x = start + share * offset.cwiseProduct(sizes);
      for (const models::StateGroup& group : info.groups)
        if (group.kind == models::StateGroupKind::quaternion) x.segment<4>(group.first).normalize();
      Eigen::VectorXd f = rate(0.0, parameters_.size() - 1, x);
      if (!f.allFinite()) continue;
      draws_.push_back({parameters_.size() - 1, std::move(x), std::move(f)});
      return;
    }
  }

  Eigen::VectorXd rate(double t, std::size_t at, const Eigen::VectorXd& x) {
    Eigen::VectorXd f(x.size());
    const auto size = static_cast<std::size_t>(x.size());
    model_.rhs(t, {x.data(), size}, parameters_[at].q, {f.data(), size}, parameters_[at].workspace);
    return f;
  }

  const models::ParametricModel& model_;
  bool has_parameters_;  ///< among the free coordinates; if not, all draws share the first
  std::vector<Parameters> parameters_;
  std::vector<Draw> draws_;
  Eigen::VectorXd sizes_;  ///< of the rates
};

/// Which of so many states change their sign, a bit for each: all ways, fewest changes first.
std::vector<unsigned> sign_patterns(std::size_t states) {
  std::vector<unsigned> patterns(std::size_t{1} << states);
  std::iota(patterns.begin(), patterns.end(), 0u);
  std::ranges::stable_sort(patterns, {}, [](unsigned p) { return std::popcount(p); });
  return patterns;
}

bool changes(unsigned pattern, std::size_t j) {
  return (pattern >> j & 1u) != 0;
}

void set_signs(Eigen::MatrixXd& linear, const std::vector<std::size_t>& states, unsigned pattern) {
  for (std::size_t j = 0; j < states.size(); ++j) {
    const auto i = static_cast<Eigen::Index>(states[j]);
    linear(i, i) = changes(pattern, j) ? -1.0 : 1.0;
  }
}

/// With signs for the states that may change theirs, so that f keeps it. Fewest changes first.
std::optional<MotionImage> with_signs(MotionImage turn, const std::vector<std::size_t>& may_change,
                                      Trials& trials) {
  if (may_change.size() > kMostSigned) return std::nullopt;
  for (const unsigned pattern : sign_patterns(may_change.size())) {
    set_signs(turn.linear, may_change, pattern);
    if (trials.keep(turn)) return turn;
  }
  return std::nullopt;
}

/// All changes of signs that f keeps, but for none at all.
std::vector<MotionImage> reflections(const MotionImage& none, const models::ModelInfo& info, Trials& trials) {
  std::vector<MotionImage> found;
  if (!info.groups.empty() || info.states.size() > kMostSigned) return found;
  std::vector<std::size_t> all(info.states.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  for (const unsigned pattern : sign_patterns(all.size())) {
    if (pattern == 0) continue;
    MotionImage image = none;
    set_signs(image.linear, all, pattern);
    if (!trials.keep(image)) continue;
    std::vector<std::string> names;
    for (const std::size_t i : all)
      if (changes(pattern, i)) names.push_back(info.states[i].name);
    image.name = fmt::format("a reflection of {}", fmt::join(names, ", "));
    found.push_back(std::move(image));
  }
  return found;
}

/// One image, then the other.
MotionImage composed(const MotionImage& first, const MotionImage& then) {
  return {then.linear * first.linear, then.of(first.shift), first.name + " and " + then.name};
}

/// q times i, j or k: a body that is turned by pi about an axis of its own before q places it.
Eigen::Matrix4d times_unit(int axis) {
  Eigen::Matrix4d product = Eigen::Matrix4d::Zero();
  const int a = 1 + axis, b = 1 + (axis + 1) % 3, c = 1 + (axis + 2) % 3;
  product(0, a) = -1.0;
  product(a, 0) = 1.0;
  product(b, c) = 1.0;
  product(c, b) = -1.0;
  return product;
}

}  // namespace

bool are_same_rates(const Eigen::VectorXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& sizes) {
  constexpr double kLastDigits = 64.0 * std::numeric_limits<double>::epsilon();
  const Eigen::ArrayXd allowed =
      1e-9 * a.cwiseAbs().cwiseMax(b.cwiseAbs()).array() + kLastDigits * sizes.array();
  return ((a - b).array().abs() <= allowed).all();
}

MotionSymmetry motion_symmetry(const models::ParametricModel& model, std::span<const DrawnInterval> box,
                               double window) {
  const models::ModelInfo& info = model.model().info();
  const std::size_t states = info.states.size();
  Trials trials(model, box);
  MotionSymmetry symmetry;
  symmetry.sizes = trials.sizes();
  symmetry.autonomous = trials.keep_in_time(window);
  for (std::size_t i = 0; i < states; ++i)
    symmetry.angles.push_back(!trials.keep_moved(i, 1.0) && trials.keep_moved(i, kFullTurn));

  const MotionImage none{Eigen::MatrixXd::Identity(std::ssize(info.states), std::ssize(info.states)),
                         Eigen::VectorXd::Zero(std::ssize(info.states)),
                         {}};
  std::vector<bool> in_group(states, false);
  const auto quaternion =
      std::ranges::find(info.groups, models::StateGroupKind::quaternion, &models::StateGroup::kind);
  for (const models::StateGroup& group : info.groups) {
    const int size = group.kind == models::StateGroupKind::quaternion ? 4 : 3;
    for (int k = 0; k < size; ++k) in_group[static_cast<std::size_t>(group.first + k)] = true;
  }
  const auto others = [&](std::size_t but) {
    std::vector<std::size_t> list;
    for (std::size_t i = 0; i < states; ++i)
      if (i != but && !in_group[i]) list.push_back(i);
    return list;
  };
  const auto add = [&](std::optional<MotionImage> found) {
    if (found) symmetry.images.push_back(std::move(*found));
  };
  if (quaternion != info.groups.end()) {
    for (int axis = 0; axis < 3; ++axis) {
      MotionImage turn = none;
      turn.linear.block<4, 4>(quaternion->first, quaternion->first) = times_unit(axis);
      turn.name = fmt::format("a half turn about the body's {} axis", "xyz"[axis]);
      add(with_signs(turn, others(states), trials));
    }
  }
  for (std::size_t i = 0; i < states; ++i) {
    if (!symmetry.angles[i] || in_group[i]) continue;
    MotionImage turn = none;
    turn.shift[static_cast<Eigen::Index>(i)] = std::numbers::pi;
    turn.name = fmt::format("a half turn of {} by pi", info.states[i].name);
    add(with_signs(turn, others(i), trials));
  }
  const std::size_t turns = symmetry.images.size();
  for (const MotionImage& reflection : reflections(none, info, trials)) {
    symmetry.images.push_back(reflection);
    for (std::size_t t = 0; t < turns; ++t)
      symmetry.images.push_back(composed(symmetry.images[t], reflection));
  }
  return symmetry;
}

}  // namespace samara::codebooks
