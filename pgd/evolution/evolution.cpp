#include "samara/pgd/evolution/evolution.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/base/errors.h"
#include "samara/pgd/cross/cross_interpolation.h"
#include "samara/pgd/cross/entry_table.h"
#include "samara/pgd/evolution/evolution_checks.h"
#include "samara/pgd/evolution/evolution_terms.h"
#include "samara/pgd/evolution/polynomial_system.h"
#include "samara/pgd/tensors/compression.h"
#include "samara/pgd/tensors/separation.h"

namespace samara::pgd {

namespace {

using SteadyClock = std::chrono::steady_clock;

/// Times the modes' scale vectors, to and from the weighted norm.
std::vector<Eigen::VectorXd> inverse(const std::vector<Eigen::VectorXd>& scale) {
  std::vector<Eigen::VectorXd> result;
  for (const Eigen::VectorXd& s : scale) result.emplace_back(s.cwiseInverse());
  return result;
}

/// Accuracy of f relative to the residual expected.
constexpr double kNoise = 0.02;

/// Newton's iteration: the state in one place, the steps as functions.
class Newton {
 public:
  Newton(const EvolutionProblem& problem, const EvolutionOptions& options, const SeparatedField* guess)
      : options_(options), grid_(problem), start_(grid_.initial()) {
    std::vector<int> sizes = {grid_.states()};
    sizes.insert(sizes.end(), grid_.sizes().begin(), grid_.sizes().end());
    w_ = SeparatedTensor::zero(sizes);
    if (guess != nullptr) w_ = compressed(grid_.from_field(*guess), 0.3 * options.tolerance);
  }

  EvolutionResult run() {
    const SteadyClock::time_point begin = SteadyClock::now();
    while (!stopped_) {
      const SteadyClock::time_point iteration_begin = SteadyClock::now();
      record_ = {};
      record_.step = step_;
      record_.rank = w_.rank();
      if (!is_cancelled() && approximate_residual() && !finished() && approximate_jacobian()) solve_linear();
      record_.seconds = std::chrono::duration<double>(SteadyClock::now() - iteration_begin).count();
      history_.push_back(record_);
    }
    EvolutionResult result{grid_.field(w_), status_, message_, std::move(history_)};
    result.residual = std::isfinite(residual_) ? residual_ : 1.0;
    result.nonlinearity_error = nonlinearity_error_;
    result.rhs_evaluations = rhs_evaluations_;
    result.jacobian_evaluations = jacobian_evaluations_;
    result.grid_size = grid_.size();
    result.seconds = std::chrono::duration<double>(SteadyClock::now() - begin).count();
    return result;
  }

 private:
  /// S f(x0 + W), and the residual S f - W. f is approximated well below the residual: what is noise there
  /// has high rank, and the linear solve would spend its terms on it. @returns false if f is not finite.
  bool approximate_residual() {
    SeparatedTensor state = w_;
    state.append(start_);
    const EntryFunction rhs = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      if (is_cancelled()) return no_values(grid_.states(), entries, values);
      grid_.rhs(state, entries, values);
    };
    EntryTable known(rhs, grid_.states(), grid_.sizes());  // asked once, at whatever accuracy
    const double floor = 0.3 * options_.tolerance;
    double accuracy = std::max(floor, kNoise * expected_residual());
    previous_residual_ = residual_;
    while (true) {
      if (!approximate_integral(known, accuracy)) return false;
      SeparatedTensor residual = integral_;
      residual.append(scaled_modes(w_, grid_.root_weights()), -1.0);
      residual_ = norm(residual);
      if (accuracy <= floor || accuracy <= 2.0 * kNoise * residual_) break;
      accuracy = std::max(floor, kNoise * residual_);
    }
    record_.residual = residual_;
    return true;
  }

  /// Before the first residual is known: what a start from nothing, or from a guess, should leave.
  double expected_residual() const {
    if (history_.empty()) return w_.rank() == 0 ? 1.0 : 10.0 * options_.tolerance;
    return std::min(1.0, options_.linear_tolerance * residual_);
  }

  bool approximate_integral(EntryTable& known, double accuracy) {
    CrossOptions cross;
    cross.tolerance = accuracy;
    cross.max_rank = options_.max_rank;
    // Other guard entries every time.
    cross.seed = options_.seed + static_cast<std::uint64_t>(rhs_evaluations_);
    cross.start = rhs_pivots_;
    const EntryFunction f = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      values = known.fetch(entries);
    };
    const long before = known.evaluations();
    CrossResult result = interpolate(f, grid_.states(), grid_.sizes(), cross);
    record_.evaluations += known.evaluations() - before;
    rhs_evaluations_ += known.evaluations() - before;
    if (!cross_is_finite(result, "the right-hand side")) return false;
    rhs_pivots_ = std::move(result.pivots);
    nonlinearity_error_ = result.guard_error;
    TensorTrain integral = std::move(result.train);
    apply_integration(integral.cores[1]);
    // Scaled to the weighted norm, in which rounding is right.
    scale_modes(integral, grid_.root_weights());
    std::optional<SeparatedTensor> sum =
        as_sum(rounded(std::move(integral), 0.2 * accuracy), 0.2 * accuracy, "the right-hand side");
    if (!sum) return false;
    integral_ = std::move(*sum);
    return true;
  }

  /// A train as a sum of products, none if that takes too many.
  std::optional<SeparatedTensor> as_sum(const TensorTrain& train, double tolerance, const char* what) {
    double products = 1.0;
    for (const int rank : train.ranks()) products *= rank;
    if (products <= options_.max_terms) return to_separated(train);
    Separation separation = separate(train, tolerance, options_.max_terms);
    if (separation.status == SeparationStatus::met) return std::move(separation.tensor);
    stop(Termination::rank_limit,
         fmt::format("{} takes more than the {} products allowed, a train of ranks {} in all {:.3g}; slabs "
                     "need no such sums and may go further",
                     what, options_.max_terms, fmt::join(train.ranks(), ", "), separation.chains));
    return std::nullopt;
  }

  /// What a function that is no longer asked answers: it ends a cross interpolation.
  static void no_values(int outputs, const IndexBatch& entries, Eigen::MatrixXd& values) {
    values.setConstant(outputs, entries.cols(), std::numeric_limits<double>::quiet_NaN());
  }

  static void scale_modes(TensorTrain& train, const std::vector<Eigen::VectorXd>& scale) {
    for (std::size_t k = 0; k < train.cores.size(); ++k) {
      TrainCore& core = train.cores[k];
      if (scale[k].size() == 0) continue;
      for (Eigen::Index j = 0; j < core.data.size(); ++j)
        core.data[j] *= scale[k][(j / core.left) % core.size];
    }
  }

  void apply_integration(TrainCore& core) const {
    for (int r = 0; r < core.right; ++r) {
      Eigen::Map<Eigen::MatrixXd> slab(core.data.data() + Eigen::Index{core.left} * core.size * r, core.left,
                                       core.size);
      slab = (slab * grid_.integration().transpose()).eval();
    }
  }

  bool cross_is_finite(const CrossResult& result, const char* what) {
    if (result.status != CrossStatus::not_finite) return true;
    if (stopped_) return false;  // cancelled on the way
    // A step too long may leave the domain of f: the caller shortens it before this counts.
    if (shorten_step()) return false;
    stop(Termination::not_finite,
         fmt::format("{} is not finite at {}", what, grid_.describe(result.bad_entry)));
    return false;
  }

  bool finished() { return converged() || grew() || out_of_iterations() || is_cancelled(); }

  bool converged() {
    if (!(residual_ <= options_.tolerance)) return false;
    if (nonlinearity_error_ > options_.tolerance) {
      return stop(Termination::stagnated,
                  fmt::format("residual {:.3g}, but f is approximated only to {:.3g} > {:.3g}", residual_,
                              nonlinearity_error_, options_.tolerance));
    }
    return stop(Termination::converged, fmt::format("residual {:.3g} <= {:.3g} after {} iterations",
                                                    residual_, options_.tolerance, history_.size()));
  }

  /// A residual that grew asks for a shorter step, and ends the iteration when steps are short already.
  bool grew() {
    if (std::isfinite(residual_) && (history_.empty() || residual_ < previous_residual_)) {
      step_ = 1.0;
      return false;
    }
    if (residual_ < 10.0 * options_.tolerance) {
      return stop(Termination::stagnated,
                  fmt::format("the residual stays at {:.3g} > {:.3g}", residual_, options_.tolerance));
    }
    if (shorten_step()) return true;
    return stop(
        Termination::diverged,
        fmt::format(
            "the residual grew from {:.3g} to {:.3g} even with a step of {:.3g}: the solution may not "
            "exist on the whole box",
            previous_residual_, residual_, step_));
  }

  bool shorten_step() {
    if (full_step_.rank() == 0 || step_ < 0.1) return false;
    step_ *= 0.5;
    residual_ = previous_residual_;
    w_ = before_step_;
    w_.weights *= 1.0 - step_;
    w_.append(full_step_, step_);
    w_ = compressed(w_, 0.1 * options_.linear_tolerance * residual_);
    return true;
  }

  bool out_of_iterations() {
    if (static_cast<int>(history_.size()) < options_.max_iterations) return false;
    return stop(Termination::max_iterations,
                fmt::format("residual {:.3g} > {:.3g} after all {} iterations allowed", residual_,
                            options_.tolerance, options_.max_iterations));
  }

  bool is_cancelled() {
    if (stopped_ || !options_.progress) return stopped_;
    const double known = std::isfinite(residual_) ? residual_ : 1.0;
    const double fraction = std::clamp(std::log(known) / std::log(options_.tolerance), 0.0, 1.0);
    if (options_.progress({"Newton", fraction})) return false;
    return stop(Termination::cancelled, std::isfinite(residual_)
                                            ? fmt::format("cancelled at residual {:.3g}", residual_)
                                            : std::string("cancelled before the first residual"));
  }

  /// J(x0 + W), to the accuracy the inexact iteration needs. @returns false if it is not finite.
  bool approximate_jacobian() {
    SeparatedTensor state = w_;
    state.append(start_);
    const EntryFunction j = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      if (is_cancelled()) return no_values(grid_.states() * grid_.states(), entries, values);
      grid_.jacobian(state, entries, values);
    };
    CrossOptions cross;
    cross.max_rank = options_.max_rank;
    cross.seed = options_.seed + 1000 + history_.size();
    cross.start = jacobian_pivots_;
    cross.tolerance = options_.linear_tolerance * std::max(jacobian_size_, 1e-12);
    CrossResult result = interpolate(j, grid_.states() * grid_.states(), grid_.sizes(), cross);
    record_.evaluations += result.evaluations;
    jacobian_evaluations_ += result.evaluations;
    if (!cross_is_finite(result, "the Jacobian")) return false;
    jacobian_pivots_ = std::move(result.pivots);
    jacobian_size_ = std::max(result.largest, 1.0);
    const double accuracy = options_.linear_tolerance * jacobian_size_;
    const std::optional<SeparatedTensor> sum = as_sum(result.train, 0.3 * accuracy, "the Jacobian");
    if (!sum) return false;
    jacobian_ = compressed(*sum, accuracy);
    record_.jacobian_terms = jacobian_.rank();
    return true;
  }

  /// (I - S J) W' = S (f - J W), started from the terms of W.
  void solve_linear() {
    const double wanted = std::max(options_.linear_tolerance * residual_, 0.5 * options_.tolerance);
    LinearProblem problem;
    problem.op = grid_.linear_operator(jacobian_);
    problem.rhs = scaled_modes(integral_, inverse(grid_.root_weights()));
    problem.row_weights = grid_.weights();
    SeparatedTensor linear_part = problem.op.apply(w_);
    linear_part.append(w_, -1.0);
    problem.rhs.append(linear_part);
    EnrichOptions linear;
    linear.projection = options_.projection;
    linear.residual_tolerance = wanted / norm(scaled_modes(problem.rhs, grid_.root_weights()));
    // Newton measures its own residual: the linear one need not be resolved beyond its tolerance.
    constexpr double kInnerProductsResolve = 1e-6;
    if (linear.residual_tolerance > kInnerProductsResolve) linear.residual = ResidualKind::fast;
    linear.max_rank = options_.max_rank;
    linear.seed = options_.seed + history_.size();
    linear.progress = [this](const Progress&) { return !is_cancelled(); };
    EnrichResult result = enrich(problem, linear, &w_);
    if (stopped_) return;
    record_.rhs_terms = problem.rhs.rank();
    record_.linear = result.termination;
    record_.linear_residual = result.residual / linear.residual_tolerance * wanted;
    if (record_.linear_residual > 0.9 * residual_) {
      stop(Termination::stagnated,
           fmt::format("the linear solve of iteration {} failed: {}", history_.size() + 1, result.message));
      return;
    }
    before_step_ = w_;
    w_ = std::move(result.solution);
    full_step_ = w_;
  }

  /// Compression in the weighted norm. It spends what it is given and cross interpolation spends the same, so
  /// that each gets a part of the tolerance.
  SeparatedTensor compressed(const SeparatedTensor& tensor, double tolerance) const {
    CompressionResult result = compress(scaled_modes(tensor, grid_.root_weights()), 0.3 * tolerance);
    return scaled_modes(std::move(result.tensor), inverse(grid_.root_weights()));
  }

  bool stop(Termination status, std::string message) {
    status_ = status;
    message_ = std::move(message);
    stopped_ = true;
    return true;
  }

  const EvolutionOptions& options_;
  const EvolutionGrid grid_;
  const SeparatedTensor start_;
  SeparatedTensor w_, before_step_, full_step_, integral_, jacobian_;
  CrossPivots rhs_pivots_, jacobian_pivots_;
  EvolutionRecord record_;
  std::vector<EvolutionRecord> history_;
  Termination status_ = Termination::diverged;
  std::string message_;
  bool stopped_ = false;
  double step_ = 1.0;
  double residual_ = std::numeric_limits<double>::infinity();
  double previous_residual_ = std::numeric_limits<double>::infinity();
  double jacobian_size_ = 1.0;
  double nonlinearity_error_ = 0.0;
  long rhs_evaluations_ = 0;
  long jacobian_evaluations_ = 0;
};

}  // namespace

void check_states(const EvolutionSystem* system, const std::vector<OutputLabel>& states,
                  const std::vector<double>& scales, const std::vector<InitialValue>& initial,
                  std::size_t parameters) {
  if (system == nullptr) throw ArgumentError("the evolution problem has no system");
  const auto n = static_cast<std::size_t>(system->state_count());
  if (n == 0 || states.size() != n || scales.size() != n || initial.size() != n) {
    throw ArgumentError(
        fmt::format("the system has {} states; {} labels, {} scales and {} initial values were given", n,
                    states.size(), scales.size(), initial.size()));
  }
  const PolynomialSystem* polynomial = system->polynomial();
  if (polynomial != nullptr && static_cast<std::size_t>(polynomial->parameter_count()) != parameters) {
    throw ArgumentError(fmt::format("the polynomial system has {} parameters, the problem {} axes",
                                    polynomial->parameter_count(), parameters));
  }
  for (std::size_t s = 0; s < n; ++s) {
    if (!(scales[s] > 0.0) || !std::isfinite(scales[s])) {
      throw ArgumentError(
          fmt::format("the scale of {} is {}, expected a positive number", states[s].name, scales[s]));
    }
    if (initial[s].axis >= static_cast<int>(parameters) || !std::isfinite(initial[s].value)) {
      throw ArgumentError(
          fmt::format("the initial value of {} is {} or axis {} of {}, expected a finite number or an axis",
                      states[s].name, initial[s].value, initial[s].axis, parameters));
    }
  }
}

void EvolutionProblem::validate() const {
  check_states(system, states, scales, initial, parameters.size());
  if (!time.has_elements() || time.transform() != Transform::none) {
    throw ArgumentError(
        fmt::format("the time axis \"{}\" is {} with the transform \"{}\", expected elements and \"none\"",
                    time.name(), to_string(time.basis()), to_string(time.transform())));
  }
}

namespace {
void check_guess(const EvolutionProblem& problem, const SeparatedField& guess) {
  std::vector<std::string> expected = {problem.time.name()};
  for (const Axis& axis : problem.parameters) expected.push_back(axis.name());
  std::vector<std::string> found;
  for (const Axis& axis : guess.axes()) found.push_back(axis.name());
  if (found != expected || guess.output_count() != problem.system->state_count()) {
    throw ArgumentError(fmt::format("the guess has {} outputs over ({}), expected {} over ({})",
                                    guess.output_count(), fmt::join(found, ", "),
                                    problem.system->state_count(), fmt::join(expected, ", ")));
  }
}
}  // namespace

EvolutionResult solve_evolution(const EvolutionProblem& problem, const EvolutionOptions& options,
                                const SeparatedField* guess) {
  problem.validate();
  if (guess != nullptr) check_guess(problem, *guess);
  if (!(options.tolerance > 0.0) || !(options.linear_tolerance > 0.0) || options.max_iterations < 1 ||
      options.max_rank < 1 || options.max_terms < 1) {
    throw ArgumentError(fmt::format(
        "EvolutionOptions: tolerance {}, linear_tolerance {}, max_iterations {}, max_rank {}, max_terms {}; "
        "expected positive numbers",
        options.tolerance, options.linear_tolerance, options.max_iterations, options.max_rank,
        options.max_terms));
  }
  return Newton(problem, options, guess).run();
}

}  // namespace samara::pgd
