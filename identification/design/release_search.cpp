#include "samara/identification/design/release_search.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <nlopt.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/sobol_points.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

/// Of the logarithm of the mean variance: a gain below it is none.
constexpr double kGain = 1e-4;

/// The coordinates that are not held, as the unit cube.
class ReleaseBox {
 public:
  explicit ReleaseBox(const Experiment& experiment) : coordinates_(experiment.coordinates) {
    for (std::size_t k = 0; k < coordinates_.size(); ++k) {
      if (coordinates_[k].lower < coordinates_[k].upper) free_.push_back(k);
    }
  }

  int dimensions() const { return static_cast<int>(free_.size()); }

  Release at(const double* unit) const {
    Release release;
    for (const ReleaseCoordinate& c : coordinates_) release.push_back(c.lower);
    for (std::size_t k = 0; k < free_.size(); ++k) {
      const ReleaseCoordinate& c = coordinates_[free_[k]];
      release[free_[k]] = std::clamp(c.lower + unit[k] * (c.upper - c.lower), c.lower, c.upper);
    }
    return release;
  }

  std::vector<double> unit_of(const Release& release) const {
    std::vector<double> unit;
    for (const std::size_t k : free_) {
      const ReleaseCoordinate& c = coordinates_[k];
      unit.push_back(std::clamp((release[k] - c.lower) / (c.upper - c.lower), 0.0, 1.0));
    }
    return unit;
  }

 private:
  const std::vector<ReleaseCoordinate>& coordinates_;
  std::vector<std::size_t> free_;
};

/// Places in the box, and what a capture at each says.
struct Candidates {
  std::vector<Release> releases;
  std::vector<Informations> informations;
};

Candidates candidates_of(CaptureEvaluator& evaluator, const ReleaseBox& box, std::uint64_t seed) {
  const int count = std::clamp(64 * box.dimensions(), 128, 512);
  const Eigen::MatrixXd points = codebooks::sobol_points(box.dimensions(), count, seed);
  Candidates candidates;
  for (Eigen::Index k = 0; k < count; ++k) candidates.releases.push_back(box.at(points.col(k).data()));
  candidates.informations = evaluator.informations(candidates.releases);
  const bool any = std::ranges::any_of(candidates.informations, [](const Informations& one) {
    return std::ranges::any_of(one, [](const Eigen::MatrixXd& draw) { return draw.squaredNorm() > 0.0; });
  });
  if (any) return candidates;
  throw NoResultError(
      fmt::format("none of {} releases in the box has a trajectory to the end of the film that depends on "
                  "the coefficients; a "
                  "shorter film or another box was expected",
                  count));
}

/// A set of captures, and what they leave open.
struct Chosen {
  std::vector<Release> releases;
  std::vector<Informations> informations;
  Informations sum;
  double log_variance = 0.0;

  Informations without(std::size_t capture) const {
    Informations rest = sum;
    subtract(informations[capture], rest);
    return rest;
  }
  void put(std::size_t capture, Release release, Informations information, const Precision& precision) {
    sum = without(capture);
    add(information, sum);
    releases[capture] = std::move(release);
    informations[capture] = std::move(information);
    log_variance = precision.log_variance(sum);
  }
};

/// Candidates by the variance that each leaves beside the others, the best first.
std::vector<std::pair<double, std::size_t>> ranked(const Candidates& candidates, const Informations& others,
                                                   const Precision& precision) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < candidates.releases.size(); ++k) {
    Informations sum = others;
    add(candidates.informations[k], sum);
    order.emplace_back(precision.log_variance(sum), k);
  }
  std::ranges::sort(order);
  return order;
}

/// One by one, the best beside those before it.
Chosen chosen_greedily(const Candidates& candidates, const Precision& precision, int captures) {
  Chosen chosen{.releases = {}, .informations = {}, .sum = precision.so_far()};
  for (int k = 0; k < captures; ++k) {
    const auto [log_variance, best] = ranked(candidates, chosen.sum, precision).front();
    chosen.releases.push_back(candidates.releases[best]);
    chosen.informations.push_back(candidates.informations[best]);
    add(chosen.informations.back(), chosen.sum);
    chosen.log_variance = log_variance;
  }
  return chosen;
}

/// Each for another candidate, as long as that gains.
void exchange(const Candidates& candidates, const Precision& precision, Chosen& chosen) {
  constexpr int kMostSweeps = 20;
  bool moved = chosen.releases.size() > 1;
  for (int sweep = 0; moved && sweep < kMostSweeps; ++sweep) {
    moved = false;
    for (std::size_t k = 0; k < chosen.releases.size(); ++k) {
      const auto [log_variance, best] = ranked(candidates, chosen.without(k), precision).front();
      if (!(log_variance < chosen.log_variance - kGain)) continue;
      chosen.put(k, candidates.releases[best], candidates.informations[best], precision);
      moved = true;
    }
  }
}

/// What NLopt calls, in C: one release, beside what the other captures say.
struct Move {
  CaptureEvaluator& evaluator;
  const Precision& precision;
  const ReleaseBox& box;
  Informations others;
  nlopt_opt optimiser = nullptr;
  std::exception_ptr thrown = nullptr;
  double log_variance = std::numeric_limits<double>::infinity();
  Release release = {};
  Informations information = {};

  double look_at(const double* unit) {
    Release here = box.at(unit);
    Informations found = evaluator.informations({here}).front();
    Informations sum = others;
    add(found, sum);
    const double value = precision.log_variance(sum);
    if (value < log_variance) {
      log_variance = value;
      release = std::move(here);
      information = std::move(found);
    }
    return value;
  }
};

double moved_to(unsigned /*size*/, const double* unit, double* /*gradient*/, void* data) {
  Move& move = *static_cast<Move*>(data);
  try {
    return move.look_at(unit);
  } catch (...) {
    move.thrown = std::current_exception();  // not through C
    nlopt_force_stop(move.optimiser);
    return 0.0;
  }
}

void descend(Move& move, const Release& start) {
  const auto size = static_cast<unsigned>(move.box.dimensions());
  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> optimiser(nlopt_create(NLOPT_LN_SBPLX, size),
                                                                         &nlopt_destroy);
  constexpr double kFirstStep = 0.1, kLastStep = 2e-3;
  move.optimiser = optimiser.get();
  nlopt_set_lower_bounds1(optimiser.get(), 0.0);
  nlopt_set_upper_bounds1(optimiser.get(), 1.0);
  nlopt_set_min_objective(optimiser.get(), &moved_to, &move);
  nlopt_set_initial_step1(optimiser.get(), kFirstStep);
  nlopt_set_xtol_abs1(optimiser.get(), kLastStep);
  nlopt_set_maxeval(optimiser.get(), static_cast<int>(30 + 25 * size));
  std::vector<double> unit = move.box.unit_of(start);
  double least = 0.0;
  nlopt_optimize(optimiser.get(), unit.data(), &least);
  move.optimiser = nullptr;
  if (move.thrown) std::rethrow_exception(move.thrown);
}

bool goes_on(const DesignOptions& options, int sweep, std::size_t capture) {
  if (!options.progress) return true;
  return options.progress({.stage = fmt::format("moving releases, sweep {}", sweep + 1),
                           .fraction = static_cast<double>(capture) / options.captures});
}

/// Each anywhere in the box, the others held, in turns; in the first sweep also from the next best candidates.
void move_releases(CaptureEvaluator& evaluator, const Candidates& candidates, const Precision& precision,
                   const ReleaseBox& box, const DesignOptions& options, Chosen& chosen) {
  constexpr int kMostSweeps = 3;
  constexpr std::size_t kStarts = 3;
  double gain = 2.0 * kGain;
  for (int sweep = 0; sweep < kMostSweeps && gain > kGain; ++sweep) {
    const double before = chosen.log_variance;
    for (std::size_t k = 0; k < chosen.releases.size(); ++k) {
      if (!goes_on(options, sweep, k)) return;
      Move move{.evaluator = evaluator, .precision = precision, .box = box, .others = chosen.without(k)};
      descend(move, chosen.releases[k]);
      const auto order = ranked(candidates, move.others, precision);
      for (std::size_t start = 0; sweep == 0 && start < kStarts; ++start)
        descend(move, candidates.releases[order[start].second]);
      if (move.log_variance < chosen.log_variance)
        chosen.put(k, std::move(move.release), std::move(move.information), precision);
    }
    gain = chosen.releases.size() > 1 ? before - chosen.log_variance : 0.0;
  }
}

/// Median over sets of neighbouring Sobol' points, which fill the box.
double random_error(const Candidates& candidates, const Precision& precision, int captures) {
  constexpr std::size_t kSets = 101;
  std::vector<double> errors;
  const std::size_t count = candidates.informations.size();
  for (std::size_t set = 0; set < kSets; ++set) {
    Informations sum = precision.so_far();
    for (std::size_t k = 0; k < static_cast<std::size_t>(captures); ++k)
      add(candidates.informations[(set * static_cast<std::size_t>(captures) + k) % count], sum);
    errors.push_back(precision.error(sum));
  }
  return median(std::move(errors));
}

}  // namespace

FoundReleases search_releases(CaptureEvaluator& evaluator, const Experiment& experiment,
                              const Precision& precision, const DesignOptions& options) {
  const ReleaseBox box(experiment);
  if (box.dimensions() == 0) {
    return {.releases = std::vector<Release>(static_cast<std::size_t>(options.captures), box.at(nullptr)),
            .random_error = std::numeric_limits<double>::quiet_NaN()};
  }
  const Candidates candidates = candidates_of(evaluator, box, options.seed);
  Chosen chosen = chosen_greedily(candidates, precision, options.captures);
  exchange(candidates, precision, chosen);
  move_releases(evaluator, candidates, precision, box, options, chosen);
  return {.releases = std::move(chosen.releases),
          .random_error = random_error(candidates, precision, options.captures)};
}

}  // namespace samara::identification
