#include "samara/pgd/nonlinear/decoupling.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/base/errors.h"
#include "samara/pgd/evolution/evolution_terms.h"
#include "samara/pgd/nonlinear/decoupled_terms.h"
#include "samara/pgd/nonlinear/monomial_product.h"
#include "samara/pgd/tensors/compression.h"
#include "samara/pgd/tensors/tensor_algebra.h"
#include "samara/pgd/tensors/train_algebra.h"

namespace samara::pgd {

namespace {

using SteadyClock = std::chrono::steady_clock;

double seconds_since(SteadyClock::time_point begin) {
  return std::chrono::duration<double>(SteadyClock::now() - begin).count();
}

/// Products and linear problems are solved to this part of the correction that is expected.
constexpr double kInexact = 0.05;
/// And never better than this part of the tolerance.
constexpr double kFloor = 0.5;
constexpr double kProductShare = 0.3;
/// Of the tolerance, what compression at the end of a slab may cost.
constexpr double kCarried = 0.3;
/// Corrections of so many scales belong to no solution.
constexpr double kLargestTerm = 1e4;
/// Corners of the box that are looked at for the largest correction.
constexpr int kMostCornersOfTerms = 10;

/// The iteration on one slab: fields in one place, steps as functions. Tensors have the modes (time nodes
/// after the first, parameters..); unknowns are over their scales, less their values at the start.
class SlabDecoupling {
 public:
  /// @param problem its time axis is the slab @param start per unknown, one node on the time mode
  SlabDecoupling(const EvolutionProblem& problem, const DecouplingOptions& options,
                 const std::vector<SeparatedTensor>& start, int slab, DecouplingResult& result)
      : problem_(problem),
        options_(options),
        grid_(problem),
        terms_(problem.system->polynomial()->terms()),
        slab_(slab),
        result_(result) {
    root_entries_ = std::sqrt(grid_.size());
    for (const SeparatedTensor& values : start) {
      start_.push_back(applied(values, 0, Eigen::MatrixXd(Eigen::MatrixXd::Ones(grid_.sizes()[0], 1))));
      unknowns_.push_back(SeparatedTensor::zero(grid_.sizes()));
      initial_.push_back(rounded(to_train(start_.back()), 1e-3 * options.tolerance * root_entries_));
      states_.push_back(initial_.back());
    }
  }

  Termination run() {
    while (!stopped_) {
      if (cancelled()) break;
      iterate();
      if (!converged() && !diverged() && !out_of_terms()) out_of_iterations();
    }
    return result_.status;
  }

  /// In SI units.
  std::vector<SeparatedField> fields() const {
    std::vector<SeparatedField> result;
    for (int m = 0; m < grid_.states(); ++m) result.push_back(field(m));
    return result;
  }

  /// The start of the next slab.
  std::vector<SeparatedTensor> end() const {
    const double entries = root_entries_ / std::sqrt(grid_.sizes()[0]);
    std::vector<SeparatedTensor> result;
    Eigen::MatrixXd last = Eigen::MatrixXd::Zero(1, grid_.sizes()[0]);
    last(0, last.cols() - 1) = 1.0;
    const double tolerance = kCarried * options_.tolerance * entries;
    for (std::size_t m = 0; m < unknowns_.size(); ++m) {
      if (options_.form == DecoupledForm::trains) {
        result.push_back(to_separated(rounded(applied(states_[m], 0, last), tolerance), 0.1 * tolerance));
        continue;
      }
      SeparatedTensor whole = unknowns_[m];
      whole.append(start_[m]);
      result.push_back(compress(applied(std::move(whole), 0, last), tolerance).tensor);
    }
    return result;
  }

 private:
  double scale(int m) const { return problem_.scales[static_cast<std::size_t>(m)]; }

  /// All unknowns once, one after the other.
  void iterate() {
    const SteadyClock::time_point begin = SteadyClock::now();
    DecouplingRecord record;
    record.slab = slab_;
    record.accuracy = accuracy_ = accuracy();
    const std::vector<TensorTrain> before = states_;
    for (int m = 0; m < grid_.states(); ++m) {
      solve(m, record);
      const auto state = static_cast<std::size_t>(m);
      record.correction =
          std::max(record.correction, distance(states_[state], before[state]) / root_entries_);
    }
    if (iterations_++ > 0) {
      // Corrections that are lost in what the linear problems leave tell nothing.
      const DecouplingRecord& last = result_.history.back();
      if (last.correction > last.accuracy) record.contraction = record.correction / last.correction;
    }
    record.seconds = seconds_since(begin);
    result_.history.push_back(std::move(record));
    before_ = before;
  }

  /// Euclidean accuracy per entry for the correction that this iteration should make.
  double accuracy() const {
    const double floor = kFloor * options_.tolerance;
    if (iterations_ == 0) return std::max(floor, kInexact);
    const DecouplingRecord& last = result_.history.back();
    const double ratio = iterations_ > 1 ? std::min(1.0, last.contraction) : 1.0;
    return std::clamp(kInexact * ratio * last.correction, floor, last.accuracy);
  }

  void solve(int m, DecouplingRecord& record) {
    if (options_.form == DecoupledForm::trains) {
      integrate(m, record);
    } else {
      enrich_unknown(m, record);
    }
  }

  /// Nothing to solve: the next field is x0 + S g.
  void integrate(int m, DecouplingRecord& record) {
    const auto state = static_cast<std::size_t>(m);
    const TensorTrain increment = source(m);
    states_[state] = increment.cores.empty() ? initial_[state]
                                             : rounded(sum(initial_[state], increment),
                                                       kProductShare * accuracy_ * root_entries_);
    const std::vector<int> ranks = states_[state].ranks();
    record.terms.push_back(*std::max_element(ranks.begin(), ranks.end()));
    too_long_ = too_long_ || record.terms.back() > options_.max_rank;
  }

  /// The linear problem of one unknown, (I - S a) W = S (a x0 + g).
  void enrich_unknown(int m, DecouplingRecord& record) {
    const auto state = static_cast<std::size_t>(m);
    const TensorTrain sources = source(m);
    SeparatedTensor rhs = sources.cores.empty()
                              ? SeparatedTensor::zero(grid_.sizes())
                              : to_separated(sources, kProductShare * accuracy_ * root_entries_);
    const LinearProblem linear{own_operator(grid_, m), std::move(rhs), {}};
    record.source_terms = std::max(record.source_terms, linear.rhs.rank());
    const double size = norm(linear.rhs);
    if (size == 0.0) {
      record.terms.push_back(0);
      return;
    }
    EnrichOptions enrichment;
    enrichment.projection = options_.projection;
    enrichment.residual_tolerance = std::min(0.9, accuracy_ * root_entries_ / size);
    enrichment.max_rank = options_.max_rank;
    enrichment.residual = ResidualKind::fast;
    enrichment.seed = options_.seed + static_cast<std::uint64_t>(result_.history.size());
    const SeparatedTensor& last = unknowns_[state];
    EnrichResult solved = enrich(linear, enrichment, last.rank() > 0 ? &last : nullptr);
    const double residual = solved.residual * size / root_entries_;
    record.linear_residual = std::max(record.linear_residual, residual);
    unknowns_[state] = std::move(solved.solution);
    SeparatedTensor whole = unknowns_[state];
    whole.append(start_[state]);
    states_[state] = rounded(to_train(whole), 0.1 * accuracy_ * root_entries_);
    record.terms.push_back(unknowns_[state].rank());
  }

  /// S (a x0 + g) by products of the last known fields.
  TensorTrain source(int m) const {
    const double tolerance = kProductShare * accuracy_ * root_entries_;
    const int times = grid_.sizes()[0];
    const auto product = [&](const TensorTrain& a, const TensorTrain& b) {
      return rounded_hadamard(a, b, tolerance);
    };
    TensorTrain total;
    for (const Monomial& term : terms_) {
      if (term.state != m || term.coefficient == 0.0) continue;
      const bool own = options_.form == DecoupledForm::sums && is_own_linear(term);
      const auto state = [&](int k) {
        const auto index = static_cast<std::size_t>(k);
        return scaled(own ? initial_[index] : states_[index], scale(k));
      };
      TensorTrain one = monomial_product(term, term.coefficient * grid_.duration() / scale(m), times,
                                         problem_.parameters, state, product);
      total = total.cores.empty() ? std::move(one) : rounded(sum(total, one), tolerance);
    }
    if (total.cores.empty()) return total;
    return rounded(applied(std::move(total), 0, grid_.integration()), tolerance);
  }

  bool converged() {
    const DecouplingRecord& last = result_.history.back();
    const double enough = options_.tolerance;
    const double ratio = last.contraction;
    // What is left of a contracting iteration is about ratio / (1 - ratio) of its last correction.
    const bool settled = last.correction <= enough ||
                         (ratio > 0.0 && ratio < 0.5 && last.correction * ratio / (1.0 - ratio) <= enough);
    if (!settled || too_long_ || std::max(last.accuracy, last.linear_residual) > enough) return false;
    return stop(
        Termination::converged,
        fmt::format("{} iterations, the last correction is {:.3g} of the scales, its ratio to the one "
                    "before {:.3g}",
                    iterations_, last.correction, ratio));
  }

  bool diverged() {
    const DecouplingRecord& last = result_.history.back();
    growths_ = last.contraction > 1.0 ? growths_ + 1 : 0;
    if (last.correction < kLargestTerm && growths_ < options_.patience) return false;
    result_.where = largest_correction();
    std::vector<std::string> coordinates = {
        fmt::format("{} = {:.6g}", problem_.time.name(), result_.where[0])};
    for (std::size_t k = 0; k < problem_.parameters.size(); ++k)
      coordinates.push_back(fmt::format("{} = {:.6g}", problem_.parameters[k].name(), result_.where[k + 1]));
    return stop(
        Termination::diverged,
        fmt::format("contraction is lost: after {} iterations corrections grow, by {:.3g} from the last one "
                    "to {:.3g} of the scales, largest near {}; shorter times, Newton's iteration or slabs "
                    "may go further",
                    iterations_, last.contraction, last.correction, fmt::join(coordinates, ", ")));
  }

  /// Linear problems that are solved no better than the iteration changes lead nowhere.
  bool out_of_terms() {
    const DecouplingRecord& last = result_.history.back();
    if (too_long_) {
      return stop(Termination::rank_limit, fmt::format("a train takes ranks up to {}, {} are allowed",
                                                       result_.largest_rank(), options_.max_rank));
    }
    if (last.linear_residual <= std::max(options_.tolerance, 1.1 * last.accuracy) ||
        last.correction > 3.0 * last.linear_residual)
      return false;
    return stop(
        Termination::rank_limit,
        fmt::format("with {} terms, of at most {}, the linear problems keep a residual of {:.3g} of "
                    "the scales, {:.3g} is wanted",
                    result_.largest_rank(), options_.max_rank, last.linear_residual, options_.tolerance));
  }

  bool out_of_iterations() {
    if (iterations_ < options_.max_iterations) return false;
    return stop(Termination::max_iterations,
                fmt::format("{} iterations leave a correction of {:.3g} of the scales, {:.3g} is wanted",
                            iterations_, result_.history.back().correction, options_.tolerance));
  }

  bool cancelled() {
    if (!options_.progress) return false;
    double done = 0.0;
    if (iterations_ > 0) {
      const double correction = std::min(1.0, result_.history.back().correction);
      done = std::clamp(std::log(correction) / std::log(options_.tolerance), 0.0, 1.0);
    }
    if (options_.progress({fmt::format("decoupling, slab {} of {}", slab_ + 1, options_.slabs),
                           (slab_ + done) / options_.slabs}))
      return false;
    return stop(Termination::cancelled, fmt::format("cancelled after {} iterations", iterations_));
  }

  bool stop(Termination status, std::string message) {
    result_.status = status;
    result_.message = std::move(message);
    return stopped_ = true;
  }

  /// Where an unknown changed most in the last iteration, of the corners of the box.
  std::vector<double> largest_correction() const {
    const std::size_t d = problem_.parameters.size();
    const std::size_t corners = std::size_t{1} << std::min<std::size_t>(d, kMostCornersOfTerms);
    std::vector<int> index(d + 1), worst(d + 1);
    double largest = -1.0;
    for (std::size_t corner = 0; corner < corners; ++corner) {
      for (std::size_t k = 0; k < d; ++k)
        index[k + 1] = k < kMostCornersOfTerms && (corner >> k) & 1 ? grid_.sizes()[k + 1] - 1 : 0;
      for (index[0] = 0; index[0] < grid_.sizes()[0]; ++index[0]) {
        for (std::size_t m = 0; m < states_.size(); ++m) {
          const double change = std::abs(states_[m].entry(index) - before_[m].entry(index));
          if (!(change > largest)) continue;
          largest = change;
          worst = index;
        }
      }
    }
    std::vector<double> at = {problem_.time.nodes()[worst[0] + 1]};
    for (std::size_t k = 0; k < d; ++k) at.push_back(problem_.parameters[k].nodes()[worst[k + 1]]);
    return at;
  }

  /// W as a sum of products.
  SeparatedTensor increment_of(std::size_t state) const {
    if (options_.form == DecoupledForm::sums) return unknowns_[state];
    const double tolerance = kCarried * options_.tolerance * root_entries_;
    return to_separated(rounded(sum(states_[state], initial_[state], -1.0), tolerance), tolerance);
  }

  /// x0 + W in SI units.
  SeparatedField field(int m) const {
    const auto state = static_cast<std::size_t>(m);
    const SeparatedTensor increment = increment_of(state);
    SeparatedTensor whole = increment;
    whole.append(start_[state]);
    std::vector<Axis> axes = {problem_.time};
    axes.insert(axes.end(), problem_.parameters.begin(), problem_.parameters.end());
    std::vector<Eigen::MatrixXd> factors = whole.factors;
    factors[0].resize(problem_.time.size(), whole.rank());
    factors[0].row(0).head(increment.rank()).setZero();  // W vanishes at the start
    factors[0].row(0).tail(start_[state].rank()) = start_[state].factors[0].row(0);
    factors[0].bottomRows(problem_.time.size() - 1) = whole.factors[0];
    return SeparatedField(std::move(axes), {problem_.states[state]}, std::move(factors),
                          scale(m) * whole.weights.transpose());
  }

  const EvolutionProblem& problem_;
  const DecouplingOptions& options_;
  const EvolutionGrid grid_;
  const std::vector<Monomial>& terms_;
  const int slab_;
  DecouplingResult& result_;
  double root_entries_ = 1.0;
  std::vector<SeparatedTensor> start_;     ///< x0 of every unknown
  std::vector<TensorTrain> initial_;       ///< the same as trains
  std::vector<SeparatedTensor> unknowns_;  ///< W
  std::vector<TensorTrain> states_;        ///< x0 + W, rounded
  std::vector<TensorTrain> before_;        ///< the same an iteration ago
  double accuracy_ = 0.0;
  int iterations_ = 0;
  int growths_ = 0;
  bool too_long_ = false;  ///< a train has longer ranks than are allowed
  bool stopped_ = false;
};

void validate(const EvolutionProblem& problem, const DecouplingOptions& options) {
  problem.validate();
  if (problem.system->polynomial() == nullptr) {
    throw ArgumentError(
        "solve_decoupled: the system is not known as a polynomial, expected one whose coupled terms are "
        "products of its unknowns and parameters (a PolynomialSystem)");
  }
  if (problem.time.basis() != Basis::radau || problem.time.elements() < options.slabs) {
    throw ArgumentError(
        fmt::format("solve_decoupled: a time axis of {} elements of the kind {} for {} slabs, expected radau "
                    "and at least "
                    "one element for each slab",
                    problem.time.elements(), to_string(problem.time.basis()), options.slabs));
  }
  if (options.tolerance > 0.0 && options.slabs > 0 && options.max_iterations > 0 && options.max_rank > 0 &&
      options.patience > 0)
    return;
  throw ArgumentError(fmt::format(
      "DecouplingOptions: tolerance {}, slabs {}, max_iterations {}, max_rank {}, patience {}; expected "
      "positive numbers",
      options.tolerance, options.slabs, options.max_iterations, options.max_rank, options.patience));
}

/// Slab number `slab` of `slabs` parts of the time axis.
Axis slab_axis(const Axis& time, int slab, int slabs) {
  const int first = time.elements() * slab / slabs;
  const int last = time.elements() * (slab + 1) / slabs;
  return Axis::radau({time.name(), time.unit(), AxisRole::time},
                     time.borders().segment(first, last - first + 1), time.degree());
}

}  // namespace

DecouplingResult solve_decoupled(const EvolutionProblem& problem, const DecouplingOptions& options) {
  validate(problem, options);
  const SteadyClock::time_point begin = SteadyClock::now();
  DecouplingResult result;
  result.reached = problem.time.lower();
  std::vector<SeparatedTensor> start;
  for (std::size_t m = 0; m < problem.states.size(); ++m) start.push_back(initial_tensor(problem, m));
  for (int number = 0; number < options.slabs; ++number) {
    EvolutionProblem slab = problem;
    slab.time = slab_axis(problem.time, number, options.slabs);
    SlabDecoupling decoupling(slab, options, start, number, result);
    if (decoupling.run() != Termination::converged) {
      result.message = fmt::format("between t = {:.6g} and {:.6g}: {}", slab.time.lower(), slab.time.upper(),
                                   result.message);
      break;
    }
    result.slabs.push_back(decoupling.fields());
    result.reached = slab.time.upper();
    if (number + 1 < options.slabs) start = decoupling.end();
  }
  result.seconds = seconds_since(begin);
  return result;
}

}  // namespace samara::pgd
