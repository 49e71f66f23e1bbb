#include "samara/pgd/enrichment.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/factor_update.h"
#include "samara/pgd/fixed_point.h"
#include "samara/pgd/random.h"

namespace samara::pgd {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void validate(const EnrichOptions& o) {
  const auto require = [](bool holds, const char* field, double value, const char* expected) {
    if (!holds)
      throw ArgumentError(fmt::format("EnrichOptions::{} is {}, expected {}", field, value, expected));
  };
  require(o.residual_tolerance > 0.0, "residual_tolerance", o.residual_tolerance, "more than 0");
  require(o.amplitude_tolerance >= 0.0, "amplitude_tolerance", o.amplitude_tolerance, "at least 0");
  require(o.max_rank >= 1, "max_rank", o.max_rank, "at least 1");
  require(o.stagnation_terms >= 1, "stagnation_terms", o.stagnation_terms, "at least 1");
  require(o.max_fixed_point_iterations >= 1, "max_fixed_point_iterations", o.max_fixed_point_iterations,
          "at least 1");
  require(o.fixed_point_tolerance > 0.0, "fixed_point_tolerance", o.fixed_point_tolerance, "more than 0");
  require(o.update_sweeps >= 0, "update_sweeps", o.update_sweeps, "at least 0");
}

/// One solve: the problem, its projection, and what has been found so far.
class Enrichment {
 public:
  Enrichment(const LinearProblem& problem, const EnrichOptions& options, const SeparatedTensor* start)
      : problem_(problem),
        options_(options),
        form_(project(problem, options.projection)),
        fixed_point_(form_.a),
        random_(options.seed) {
    result_.solution = SeparatedTensor::zero(problem.rhs.sizes());
    if (start != nullptr && start->rank() > 0) {
      result_.solution = *start;
      result_.solution.normalise();
      improve();
    } else {
      result_.residual = measure(result_.solution);
    }
  }

  EnrichResult run() {
    const Clock::time_point start = Clock::now();
    while (!finished()) {
      const Clock::time_point term_start = Clock::now();
      Product product = find_product();
      if (product.amplitude == 0.0) break;
      TermRecord record{product.amplitude, product.iterations, product.converged, 0.0, 0.0};
      add(std::move(product));
      record.residual = result_.residual;
      record.seconds = seconds_since(term_start);
      result_.history.push_back(record);
    }
    result_.seconds = seconds_since(start);
    return std::move(result_);
  }

 private:
  /// The best product for what is left of the right-hand side, with one more first guess if the first one was
  /// orthogonal to it or led to a singular system.
  Product find_product() {
    SeparatedTensor deflated = form_.b;
    deflated.append(form_.a.apply(result_.solution), -1.0);
    Product product;
    for (int attempt = 0; attempt < 3; ++attempt) {
      product = Product{};
      for (int k = 0; k < deflated.modes(); ++k) {
        product.factors.emplace_back(Eigen::VectorXd::NullaryExpr(
            deflated.size(k), [this](Eigen::Index) { return random_.normal(); }));
      }
      fixed_point_.run(deflated, {options_.max_fixed_point_iterations, options_.fixed_point_tolerance},
                       product);
      if (!product.singular && product.amplitude != 0.0) return product;
      product.amplitude = 0.0;
    }
    if (product.singular) {
      stop(Termination::singular,
           fmt::format("a one-dimensional problem is singular at term {}", rank() + 1));
    } else {
      stop(Termination::stagnation, fmt::format("no product lowers the residual {:.3g}", result_.residual));
    }
    return product;
  }

  void add(Product product) {
    const double amplitude = product.amplitude;
    result_.solution.append(SeparatedTensor::product(std::move(product.factors)), amplitude);
    improve();
  }

  /// Projects the weights of the present terms, updates their factors if that pays, measures the residual.
  void improve() {
    project_weights(form_, result_.solution);
    result_.residual = measure(result_.solution);
    if (options_.update_sweeps == 0) return;
    SeparatedTensor updated = result_.solution;
    if (!update_factors(form_, updated, options_.update_sweeps)) return;
    const double residual = measure(updated);
    if (residual < result_.residual) {
      result_.solution = std::move(updated);
      result_.residual = residual;
    }
  }

  /// Relative residual; the exact one where the cheap one no longer resolves it.
  double measure(const SeparatedTensor& u) const {
    const double residual = fast_relative_residual(problem_, u);
    return residual < 1e-6 ? relative_residual(problem_, u) : residual;
  }

  int rank() const { return result_.solution.rank(); }

  bool finished() {
    return residual_reached() || amplitude_reached() || max_rank_reached() || stagnated() || cancelled();
  }

  bool residual_reached() {
    if (!(result_.residual <= options_.residual_tolerance)) return false;
    return stop(Termination::residual, fmt::format("residual {:.3g} <= {:.3g} with {} terms",
                                                   result_.residual, options_.residual_tolerance, rank()));
  }

  bool amplitude_reached() {
    if (result_.history.empty()) return false;
    double largest = 0.0;
    for (const TermRecord& record : result_.history) largest = std::max(largest, record.amplitude);
    const double newest = result_.history.back().amplitude;
    if (!(newest < options_.amplitude_tolerance * largest)) return false;
    return stop(Termination::amplitude,
                fmt::format("term {} has amplitude {:.3g}, below {:.3g} of the largest", rank(), newest,
                            options_.amplitude_tolerance));
  }

  bool max_rank_reached() {
    if (rank() < options_.max_rank) return false;
    return stop(Termination::max_rank,
                fmt::format("residual {:.3g} > {:.3g} with all {} terms allowed", result_.residual,
                            options_.residual_tolerance, options_.max_rank));
  }

  bool stagnated() {
    const auto span = static_cast<std::size_t>(options_.stagnation_terms);
    const auto& history = result_.history;
    if (history.size() <= span) return false;
    if (result_.residual < 0.95 * history[history.size() - 1 - span].residual) return false;
    return stop(Termination::stagnation, fmt::format("the last {} terms left the residual at {:.3g} > {:.3g}",
                                                     span, result_.residual, options_.residual_tolerance));
  }

  bool cancelled() {
    if (!options_.progress) return false;
    // Residuals fall geometrically: the fraction done is one of logarithms.
    const double fraction =
        std::clamp(std::log(result_.residual) / std::log(options_.residual_tolerance), 0.0, 1.0);
    if (options_.progress({"enrichment", fraction})) return false;
    return stop(Termination::cancelled,
                fmt::format("cancelled with {} terms at residual {:.3g}", rank(), result_.residual));
  }

  bool stop(Termination why, std::string message) {
    result_.termination = why;
    result_.message = std::move(message);
    return true;
  }

  const LinearProblem& problem_;
  const EnrichOptions& options_;
  const ProjectedForm form_;
  FixedPoint fixed_point_;
  Random random_;
  EnrichResult result_;
};

}  // namespace

EnrichResult enrich(const LinearProblem& problem, const EnrichOptions& options,
                    const SeparatedTensor* start) {
  validate(options);
  problem.validate();
  if (start != nullptr && start->rank() > 0 && start->sizes() != problem.rhs.sizes()) {
    throw ArgumentError(fmt::format("the start has sizes {}, the right-hand side {}",
                                    fmt::join(start->sizes(), " x "), fmt::join(problem.rhs.sizes(), " x ")));
  }
  return Enrichment(problem, options, start).run();
}

std::string to_string(Termination termination) {
  switch (termination) {
    case Termination::residual:
      return "residual";
    case Termination::amplitude:
      return "amplitude";
    case Termination::max_rank:
      return "max_rank";
    case Termination::stagnation:
      return "stagnation";
    case Termination::singular:
      return "singular";
    case Termination::cancelled:
      return "cancelled";
  }
  return "unknown";
}

}  // namespace samara::pgd
