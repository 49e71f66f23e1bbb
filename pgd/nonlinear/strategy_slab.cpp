#include "samara/pgd/nonlinear/strategy_slab.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/base/parallel.h"
#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/evolution/slab_collocation.h"
#include "samara/pgd/evolution/slab_train.h"
#include "samara/pgd/tensors/train_algebra.h"

namespace samara::pgd {

namespace {

constexpr Eigen::Index kChunk = 512;  ///< points of one call of the system
constexpr int kMostCornerAxes = 5;
/// A largest error is seldom more than this many times the root mean square.
constexpr double kPeak = 6.0;
/// Crosses that miss their tolerance by less than this are let pass: it is a share of the slab's.
constexpr double kSlack = 2.0;

/// Euclidean norm of errors whose largest entry is about `largest`.
double norm_of(double largest, const TensorTrain& train) {
  return largest / kPeak * std::sqrt(full_size(train));
}

/// Behind the list of outputs, whose rank is their number.
int largest_rank(const TensorTrain& train) {
  const std::vector<int> ranks = train.ranks();
  return ranks.size() < 2 ? 1 : *std::max_element(ranks.begin() + 1, ranks.end());
}

}  // namespace

Eigen::MatrixXd for_all_states(const Eigen::MatrixXd& pattern, int states) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(states * pattern.rows(), states * pattern.cols());
  for (Eigen::Index i = 0; i < pattern.rows(); ++i) {
    for (Eigen::Index j = 0; j < pattern.cols(); ++j)
      matrix.block(states * i, states * j, states, states).diagonal().setConstant(pattern(i, j));
  }
  return matrix;
}

StrategySlab::StrategySlab(const EvolutionProblem& problem, int number, TensorTrain start, double tolerance,
                           int max_rank, Random& random, StrategyCounts& counts)
    : problem_(problem),
      number_(number),
      begin_(problem.time.borders()[number]),
      length_(problem.time.borders()[number + 1] - begin_),
      scales_(Eigen::Map<const Eigen::VectorXd>(problem.scales.data(),
                                                static_cast<Eigen::Index>(problem.scales.size()))),
      sizes_(sizes_of(problem.parameters)),
      start_(std::move(start)),
      tolerance_(tolerance),
      max_rank_(max_rank),
      random_(random),
      counts_(counts) {
  const SlabTime time(problem.time.degree());
  integration_ = time.integration;
  nodes_ = begin_ + length_ * time.nodes.tail(time.points()).array();
}

Eigen::MatrixXd StrategySlab::parameters_at(const IndexBatch& entries) const {
  return coordinates_at(problem_.parameters, entries);
}

IndexBatch StrategySlab::training_entries(int random) const {
  const auto d = static_cast<int>(sizes_.size());
  const int corners = d <= kMostCornerAxes ? 1 << d : 0;
  IndexBatch entries(d, corners + 1 + random);
  for (int k = 0; k < d; ++k) {
    const int size = sizes_[static_cast<std::size_t>(k)];
    for (int j = 0; j < corners; ++j) entries(k, j) = (j >> k) & 1 ? size - 1 : 0;
    entries(k, corners) = size / 2;
  }
  entries.rightCols(random) = random_entries(random);
  return entries;
}

IndexBatch StrategySlab::random_entries(int count) const {
  return random_nodes(sizes_, count, random_);
}

Eigen::MatrixXd StrategySlab::rates(const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                                    const std::vector<int>& nodes) const {
  const Eigen::Index n = states();
  const auto times = static_cast<Eigen::Index>(nodes.size());
  Eigen::MatrixXd result(n * times, x.cols());
  const Eigen::Index points = times * x.cols();
  parallel_for((points + kChunk - 1) / kChunk, [&](Eigen::Index c) {
    const Eigen::Index first = c * kChunk;
    const Eigen::Index count = std::min(kChunk, points - first);
    Eigen::VectorXd t(count);
    Eigen::MatrixXd states_here(n, count), parameters_here(q.rows(), count), f;
    for (Eigen::Index j = 0; j < count; ++j) {
      const Eigen::Index entry = (first + j) / times;
      const Eigen::Index i = (first + j) % times;
      t[j] = nodes_[nodes[static_cast<std::size_t>(i)]];
      states_here.col(j) = scales_.cwiseProduct(x.col(entry).segment(n * i, n));
      parameters_here.col(j) = q.col(entry);
    }
    problem_.system->rhs(t, states_here, parameters_here, f);
    for (Eigen::Index j = 0; j < count; ++j) {
      result.col((first + j) / times).segment(n * ((first + j) % times), n) =
          length_ * f.col(j).cwiseQuotient(scales_);
    }
  });
  counts_.rhs += points;
  return result;
}

Eigen::MatrixXd StrategySlab::rates(const Eigen::MatrixXd& x, const Eigen::MatrixXd& q) const {
  std::vector<int> all(static_cast<std::size_t>(points()));
  std::iota(all.begin(), all.end(), 0);
  return rates(x, q, all);
}

Eigen::MatrixXd StrategySlab::jacobians(const Eigen::MatrixXd& x, const Eigen::MatrixXd& q) const {
  const Eigen::Index n = states();
  const Eigen::Index times = points();
  Eigen::MatrixXd result(n * n * times, x.cols());
  const Eigen::VectorXd factors =
      length_ *
      (scales_.cwiseInverse() * scales_.transpose()).reshaped().eval();  // by state, column by column
  const Eigen::Index per_chunk = std::max<Eigen::Index>(1, kChunk / times);
  parallel_for((x.cols() + per_chunk - 1) / per_chunk, [&](Eigen::Index c) {
    const Eigen::Index first = c * per_chunk;
    const Eigen::Index entries = std::min(per_chunk, x.cols() - first);
    const Eigen::VectorXd t = nodes_.replicate(entries, 1);
    const Eigen::MatrixXd here =
        scales_.asDiagonal() * x.middleCols(first, entries).reshaped(n, times * entries);
    Eigen::MatrixXd parameters_here(q.rows(), times * entries), values;
    for (Eigen::Index j = 0; j < entries; ++j)
      parameters_here.middleCols(times * j, times) = q.col(first + j).replicate(1, times);
    problem_.system->jacobian(t, here, parameters_here, values);
    result.middleCols(first, entries) = (factors.asDiagonal() * values).reshaped(n * n * times, entries);
  });
  counts_.jacobian += times * x.cols();
  return result;
}

Outcome<TensorTrain> StrategySlab::separate(const EntryFunction& function, int outputs, double tolerance,
                                            CrossPivots& pivots, const char* what) const {
  CrossOptions options;
  options.tolerance = tolerance;
  options.max_rank = max_rank_;
  options.max_sweeps = 30;
  options.guard_entries = 100;
  options.seed = random_.bits();
  options.start = pivots;
  CrossResult result = interpolate(function, outputs, sizes_, options);
  const double end = begin_ + length_;
  if (result.status == Termination::not_finite) {
    const std::vector<double> at = coordinates(problem_.parameters, result.bad_entry);
    return Ending{
        Termination::not_finite,
        fmt::format("{} is not finite between t = {:.6g} and {:.6g} at {}", what, begin_, end, described(at)),
        at};
  }
  if (!(result.guard_error <= kSlack * tolerance)) {
    return Ending{
        Termination::rank_limit,
        fmt::format("between t = {:.6g} and {:.6g} {} is separated to {:.3g} only with ranks up to {} of {} "
                    "after {} sweeps, {:.3g} is wanted",
                    begin_, end, what, result.guard_error, largest_rank(result.train), max_rank_,
                    result.sweeps, tolerance)};
  }
  pivots = std::move(result.pivots);
  return std::move(result.train);
}

TensorTrain StrategySlab::compressed(TensorTrain train, double tolerance) const {
  const double bound = norm_of(tolerance, train);
  return rounded(std::move(train), bound);
}

TensorTrain StrategySlab::product(const TensorTrain& a, const TensorTrain& b, double tolerance) const {
  return rounded_hadamard(a, b, norm_of(tolerance, a));
}

TensorTrain StrategySlab::at_points(const TensorTrain& iterate) const {
  return last_rows(iterate, rows());
}

TensorTrain StrategySlab::start_at_points() const {
  return applied(start_, 0, for_all_states(Eigen::MatrixXd::Ones(points(), 1), states()));
}

TensorTrain StrategySlab::constant() const {
  return applied(start_, 0, for_all_states(Eigen::MatrixXd::Ones(points() + 1, 1), states()));
}

std::string StrategySlab::described(const std::vector<double>& coordinates) const {
  return pgd::described(problem_.parameters, coordinates);
}

}  // namespace samara::pgd
