#include "samara/pgd/linear/enrichment.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/linear/factor_update.h"
#include "samara/pgd/linear/fixed_point.h"
#include "samara/pgd/linear/residual.h"
#include "samara/pgd/tensors/random.h"

namespace samara::pgd {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

constexpr int kMostGuesses = 1000;

void validate(const EnrichOptions& o) {
  constexpr std::string_view kWhere = "enrich";
  require(o.residual_tolerance > 0.0, "residual_tolerance", o.residual_tolerance, "more than 0", kWhere);
  require(o.amplitude_tolerance >= 0.0, "amplitude_tolerance", o.amplitude_tolerance, "at least 0", kWhere);
  require(o.max_rank >= 1, "max_rank", o.max_rank, "at least 1", kWhere);
  require(o.stagnation_terms >= 1, "stagnation_terms", o.stagnation_terms, "at least 1", kWhere);
  require(o.max_fixed_point_iterations >= 1, "max_fixed_point_iterations", o.max_fixed_point_iterations,
          "at least 1", kWhere);
  require(o.fixed_point_tolerance > 0.0, "fixed_point_tolerance", o.fixed_point_tolerance, "more than 0",
          kWhere);
  require(o.update_sweeps >= 0, "update_sweeps", o.update_sweeps, "at least 0", kWhere);
  require(o.update_tolerance >= 0.0, "update_tolerance", o.update_tolerance, "at least 0", kWhere);
  require(o.first_guesses >= 1 && o.first_guesses <= kMostGuesses, "first_guesses", o.first_guesses,
          "1 to 1000", kWhere);
  require(o.max_seconds >= 0.0, "max_seconds", o.max_seconds, "at least 0", kWhere);
}

/// One solve: the problem, its projection, and what has been found so far.
class Enrichment {
 public:
  Enrichment(const LinearProblem& problem, const EnrichOptions& options)
      : options_(options),
        start_(Clock::now()),
        form_(project(problem, options.projection)),
        residual_(problem),
        systems_(make_mode_systems(form_.a, options.solver)),
        fixed_point_(form_, systems_),
        random_(options.seed) {
    state_.solution = SeparatedTensor::zero(problem.rhs.sizes());
    state_.residual = measure(state_.solution);
    state_.random_state = options.seed;
  }

  bool has_no_source() const { return residual_.is_zero(); }

  void start_from(const SeparatedTensor& tensor) {
    state_.solution = tensor;
    state_.solution.normalise();
    improve();
  }

  /// @throws ArgumentError if the state's residual is not that of its solution in this problem
  void start_from(const EnrichState& state) {
    if (measure(state.solution) != state.residual) {
      throw ArgumentError(
          fmt::format("the state has the residual {}, its solution {} in this problem: it belongs to another",
                      state.residual, measure(state.solution)));
    }
    state_ = state;
    random_ = Random(state.random_state);
  }

  EnrichResult run() {
    while (!finished()) {
      const Clock::time_point term_start = Clock::now();
      Product product = find_product();
      if (product.amplitude == 0.0) break;
      TermRecord record{product.amplitude, product.iterations, product.converged, 0.0, 0.0};
      state_.largest_amplitude = std::max(state_.largest_amplitude, product.amplitude);
      const SeparatedTensor before = state_.solution;
      const double residual_before = state_.residual;
      state_.solution.append(SeparatedTensor::product(std::move(product.factors)), record.amplitude);
      improve();
      if (is_worse(residual_before)) {
        state_.solution = before;
        state_.residual = residual_before;
      } else if (state_.residual > residual_before && residual_before < state_.best_residual) {
        state_.best = before;
        state_.best_residual = residual_before;
      }
      record.residual = state_.residual;
      record.seconds = seconds_since(term_start);
      state_.history.push_back(record);
      state_.random_state = random_.state();
      if (options_.checkpoint) options_.checkpoint(state_);
    }
    take_best();
    return {std::move(state_.solution), why_, std::move(message_), state_.residual, std::move(state_.history),
            seconds_since(start_)};
  }

 private:
  /// The best product for what is left of the right-hand side; more first guesses than asked for if they were
  /// orthogonal to it or led to singular systems.
  Product find_product() {
    fixed_point_.deflate(state_.solution);
    Product best;
    bool singular = false;
    int found = 0;
    constexpr int kMoreGuesses = 2;
    for (int attempt = 0; attempt < options_.first_guesses + kMoreGuesses; ++attempt) {
      if (found == options_.first_guesses) break;
      Product product = random_guess();
      fixed_point_.run(
          {options_.max_fixed_point_iterations, options_.fixed_point_tolerance, options_.acceleration},
          product);
      singular = singular || product.singular;
      if (product.singular || product.amplitude == 0.0) continue;
      ++found;
      if (found == 1 || product.gain > best.gain) best = std::move(product);
    }
    if (found > 0) return best;
    best.amplitude = 0.0;
    if (singular) {
      stop(Termination::failed, fmt::format("a one-dimensional problem is singular at term {}", rank() + 1));
    } else {
      stop(Termination::stagnated, fmt::format("no product lowers the residual {:.3g}", state_.residual));
    }
    return best;
  }

  Product random_guess() {
    Product product;
    for (int k = 0; k < form_.b.modes(); ++k) {
      product.factors.emplace_back(
          Eigen::VectorXd::NullaryExpr(form_.b.size(k), [this](Eigen::Index) { return random_.normal(); }));
    }
    return product;
  }

  /// Least squares that raise the residual have lost their digits to the squared condition number; no
  /// projection may lead to numbers that are not finite.
  bool is_worse(double residual_before) const {
    if (!std::isfinite(state_.residual)) return true;
    return options_.projection == Projection::minimal_residual && state_.residual > residual_before;
  }

  void take_best() {
    if (!(state_.best_residual < state_.residual)) return;
    message_ +=
        fmt::format("; the best residual was {:.3g} with {} terms", state_.best_residual, state_.best.rank());
    state_.solution = std::move(state_.best);
    state_.residual = state_.best_residual;
  }

  /// Projects the weights of the present terms, updates their factors if that pays, measures the residual.
  void improve() {
    if (state_.solution.rank() == 0) {
      state_.residual = measure(state_.solution);
      return;
    }
    project_weights(form_, state_.solution);
    state_.residual = measure(state_.solution);
    if (options_.update_sweeps == 0) return;
    SeparatedTensor updated = state_.solution;
    if (!update_factors(form_, systems_, updated,
                        {options_.update_sweeps, options_.update_tolerance, options_.solver})) {
      return;
    }
    const double residual = measure(updated);
    if (residual < state_.residual) {
      state_.solution = std::move(updated);
      state_.residual = residual;
    }
  }

  double measure(const SeparatedTensor& u) const {
    switch (options_.residual) {
      case ResidualKind::fast:
        return residual_.fast(u);
      case ResidualKind::exact:
        return residual_.exact(u);
      case ResidualKind::resolved:
        break;
    }
    return residual_.resolved(u);
  }

  int rank() const { return state_.solution.rank(); }

  bool finished() {
    return residual_reached() || amplitude_reached() || max_rank_reached() || time_is_up() || stagnated() ||
           cancelled();
  }

  bool residual_reached() {
    if (!(state_.residual <= options_.residual_tolerance)) return false;
    return stop(Termination::converged, fmt::format("residual {:.3g} <= {:.3g} with {} terms",
                                                    state_.residual, options_.residual_tolerance, rank()));
  }

  bool amplitude_reached() {
    if (state_.history.empty()) return false;
    const double newest = state_.history.back().amplitude;
    if (!(newest < options_.amplitude_tolerance * state_.largest_amplitude)) return false;
    return stop(Termination::converged,
                fmt::format("term {} has amplitude {:.3g}, below {:.3g} of the largest", rank(), newest,
                            options_.amplitude_tolerance));
  }

  bool max_rank_reached() {
    if (rank() < options_.max_rank) return false;
    return stop(Termination::rank_limit,
                fmt::format("residual {:.3g} > {:.3g} with all {} terms allowed", state_.residual,
                            options_.residual_tolerance, options_.max_rank));
  }

  bool time_is_up() {
    if (options_.max_seconds == 0.0 || seconds_since(start_) < options_.max_seconds) return false;
    return stop(Termination::max_seconds,
                fmt::format("residual {:.3g} > {:.3g} with {} terms after the {} s allowed", state_.residual,
                            options_.residual_tolerance, rank(), options_.max_seconds));
  }

  bool stagnated() {
    const auto span = static_cast<std::size_t>(options_.stagnation_terms);
    const auto& history = state_.history;
    if (history.size() <= span) return false;
    if (state_.residual < 0.95 * history[history.size() - 1 - span].residual) return false;
    return stop(Termination::stagnated, fmt::format("the last {} terms left the residual at {:.3g} > {:.3g}",
                                                    span, state_.residual, options_.residual_tolerance));
  }

  bool cancelled() {
    if (!options_.progress) return false;
    // Residuals fall geometrically: the fraction done is one of logarithms.
    const double fraction =
        std::clamp(std::log(state_.residual) / std::log(options_.residual_tolerance), 0.0, 1.0);
    if (options_.progress({"enrichment", fraction})) return false;
    return stop(Termination::cancelled,
                fmt::format("cancelled with {} terms at residual {:.3g}", rank(), state_.residual));
  }

  bool stop(Termination why, std::string message) {
    why_ = why;
    message_ = std::move(message);
    return true;
  }

  const EnrichOptions& options_;
  const Clock::time_point start_;
  const ProjectedForm form_;
  const Residual residual_;
  std::vector<ModeSystem> systems_;
  FixedPoint fixed_point_;
  Random random_;
  EnrichState state_;
  Termination why_ = Termination::failed;
  std::string message_;
};

void check_tensor(const char* what, const SeparatedTensor& tensor, const LinearProblem& problem,
                  const EnrichOptions& options) {
  tensor.validate(what);
  if (tensor.rank() > options.max_rank) {
    throw ArgumentError(fmt::format("the {} has {} terms, more than the {} of max_rank", what, tensor.rank(),
                                    options.max_rank));
  }
  if (tensor.sizes() == problem.rhs.sizes()) return;
  throw ArgumentError(fmt::format("the {} has sizes {}, the right-hand side {}", what,
                                  fmt::join(tensor.sizes(), " x "), fmt::join(problem.rhs.sizes(), " x ")));
}

}  // namespace

EnrichResult enrich(const LinearProblem& problem, const EnrichOptions& options,
                    const SeparatedTensor* start) {
  validate(options);
  problem.validate();
  if (start != nullptr) check_tensor("start", *start, problem, options);
  Enrichment enrichment(problem, options);
  if (start != nullptr && !enrichment.has_no_source()) enrichment.start_from(*start);
  return enrichment.run();
}

EnrichResult enrich(const LinearProblem& problem, const EnrichOptions& options, const EnrichState& state) {
  validate(options);
  problem.validate();
  check_tensor("state", state.solution, problem, options);
  Enrichment enrichment(problem, options);
  enrichment.start_from(state);
  return enrichment.run();
}

}  // namespace samara::pgd
