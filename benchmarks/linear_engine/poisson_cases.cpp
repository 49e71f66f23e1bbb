// -Laplace u = 1 on the unit cube in 2 to 50 dimensions.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "cases.h"
#include "examples/linear_engine/poisson.h"
#include "samara/pgd/linear/enrichment.h"
#include "samara/pgd/tensors/tensor_train.h"

namespace samara::benchmarks {

namespace {

using namespace pgd;

EnrichOptions settings(int max_rank, int sweeps) {
  EnrichOptions options;
  options.projection = Projection::galerkin;
  options.residual_tolerance = 1e-15;
  options.max_rank = max_rank;
  options.update_sweeps = sweeps;
  options.stagnation_terms = max_rank;
  return options;
}

/// Eigenvalues and eigenvectors of second-order differences on n inner nodes.
struct Modes {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;

  explicit Modes(int n) : values(n), vectors(n, n) {
    for (int k = 0; k < n; ++k) {
      const double angle = std::numbers::pi * (k + 1) / (n + 1);
      values[k] = 2.0 * (1.0 - std::cos(angle)) * (n + 1) * (n + 1);
      for (int i = 0; i < n; ++i) vectors(i, k) = std::sqrt(2.0 / (n + 1)) * std::sin(angle * (i + 1));
    }
  }
};

/// Relative L2 error against the exact discrete solution, in the eigenvectors' coordinates, entry by entry.
double exact_error(const SeparatedTensor& u, const Modes& modes) {
  const Eigen::Index n = modes.values.size();
  const Eigen::VectorXd load = modes.vectors.transpose() * Eigen::VectorXd::Ones(n);
  std::vector<Eigen::MatrixXd> factors;
  for (const Eigen::MatrixXd& factor : u.factors) factors.emplace_back(modes.vectors.transpose() * factor);
  double error = 0.0;
  double size = 0.0;
  std::vector<Eigen::Index> index(u.factors.size(), 0);
  for (bool more = true; more;) {
    double eigenvalue = 0.0;
    double entry = 1.0;
    Eigen::ArrayXd terms = u.weights.array();
    for (std::size_t k = 0; k < index.size(); ++k) {
      eigenvalue += modes.values[index[k]];
      entry *= load[index[k]];
      terms *= factors[k].row(index[k]).transpose().array();
    }
    const double exact = entry / eigenvalue;
    error += std::pow(terms.sum() - exact, 2);
    size += exact * exact;
    more = false;
    for (std::size_t k = 0; k < index.size() && !more; ++k) {
      more = ++index[k] < n;
      if (!more) index[k] = 0;
    }
  }
  return std::sqrt(error / size);
}

/// The inverse of a sum as a sum of products: 1 / s = integral of exp(-s exp(x) + x) by the trapezoidal rule,
/// which converges exponentially (Hackbusch 2015, section 9.8).
SeparatedTensor by_exponential_sums(int dimensions, const Modes& modes) {
  constexpr double kStep = 0.25;
  const double largest = dimensions * modes.values.maxCoeff();
  const double smallest = dimensions * modes.values.minCoeff();
  const double from = std::log(1e-14 / largest);
  const double to = std::log(40.0 / smallest);
  const Eigen::VectorXd load = modes.vectors.transpose() * Eigen::VectorXd::Ones(modes.values.size());
  SeparatedTensor sum = SeparatedTensor::zero(
      std::vector<int>(static_cast<std::size_t>(dimensions), static_cast<int>(modes.values.size())));
  for (double x = from; x <= to; x += kStep) {
    const Eigen::VectorXd decay = (-std::exp(x) * modes.values.array()).exp() * load.array();
    const Eigen::VectorXd column = modes.vectors * decay;
    sum.append(
        SeparatedTensor::product(std::vector<Eigen::VectorXd>(static_cast<std::size_t>(dimensions), column)),
        kStep * std::exp(x));
  }
  return sum;
}

double relative_difference(const SeparatedTensor& a, const SeparatedTensor& reference) {
  SeparatedTensor difference = a;
  difference.append(reference, -1.0);
  return norm(difference) / norm(reference);
}

void run_low(const Options& options, int dimensions, int nodes, const std::vector<int>& ranks) {
  const std::string name = fmt::format("poisson{}d", dimensions);
  if (!options.wants(name)) return;
  const Modes modes(nodes);
  const LinearProblem problem = poisson(dimensions, nodes);
  for (const int sweeps : {4, 0}) {
    EnrichOptions with = settings(ranks.back(), sweeps);
    with.checkpoint = [&](const EnrichState& state) {
      const int rank = state.solution.rank();
      if (std::find(ranks.begin(), ranks.end(), rank) == ranks.end()) return;
      print({kLinearEngine, name, fmt::format("{}error_rank{}", sweeps == 0 ? "greedy_" : "", rank),
             exact_error(state.solution, modes), "1"});
    };
    enrich(problem, with);
  }
}

void run_high(const Options& options, int dimensions, int max_rank) {
  const std::string name = fmt::format("poisson{}d", dimensions);
  if (!options.wants(name)) return;
  const LinearProblem problem = poisson(dimensions, 63);
  EnrichOptions with = settings(max_rank, 4);
  with.residual_tolerance = 1e-3;
  const EnrichResult result = enrich(problem, with);
  print({kLinearEngine, name, "residual", result.residual, "1"});
  print({kLinearEngine, name, "rank", static_cast<double>(result.solution.rank()), "1"});
  print({kLinearEngine, name, "time", result.seconds, "s"});
  print({kLinearEngine, name, "error_exponential_sums",
         relative_difference(result.solution, by_exponential_sums(dimensions, Modes(63))), "1"});
  const EnrichResult greedy = enrich(problem, settings(result.solution.rank(), 0));
  print({kLinearEngine, name, "greedy_residual", greedy.residual, "1"});
}

}  // namespace

void run_poisson(const Options& options) {
  run_low(options, 2, 63, {5, 10});
  run_low(options, 3, 63, {10, 30});
  run_low(options, 6, 9, {20});
  run_high(options, 10, 20);
  run_high(options, 20, 30);
  run_high(options, 50, 30);
}

}  // namespace samara::benchmarks
