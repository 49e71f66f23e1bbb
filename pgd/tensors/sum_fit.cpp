#include "samara/pgd/tensors/sum_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <Eigen/QR>

#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/train_algebra.h"

namespace samara::pgd {

namespace {

/// Least squares over the factors of one mode at a time.
class AlternatingFit {
 public:
  AlternatingFit(const TensorTrain& target, SeparatedTensor start)
      : target_(target), size_(norm(target)), u_(std::move(start)) {
    left_.resize(target.cores.size());
    right_.resize(target.cores.size());
    gram_.resize(target.cores.size());
  }

  const SeparatedTensor& sum() const { return u_; }
  void set(SeparatedTensor sum) { u_ = std::move(sum); }

  /// Sweeps until `tolerance` is met or the error falls too slowly to get there. @returns the error.
  double improve(double tolerance, int max_sweeps) {
    u_.normalise();
    prepare();
    std::vector<double> errors = {measure()};
    for (int sweep = 0; sweep < max_sweeps && errors.back() > tolerance; ++sweep) {
      for (int k = 0; k < u_.modes(); ++k) update(k, true);
      for (int k = u_.modes() - 1; k >= 0; --k) update(k, false);
      errors.push_back(measure());
      if (stalls(errors, tolerance, max_sweeps - sweep)) break;
    }
    return errors.back();
  }

  /// ||u - target||: by inner products while they resolve it, else by orthogonalisation.
  double measure() const {
    const double square = size_ * size_ - 2.0 * overlap() + inner(u_, u_);
    if (square > 1e-12 * (size_ * size_ + u_.weights.squaredNorm())) return std::sqrt(square);
    return distance(to_train(u_), target_);
  }

 private:
  /// True if the error, falling on as in the last sweeps, would still be above the tolerance at the end.
  static bool stalls(const std::vector<double>& errors, double tolerance, int sweeps_left) {
    constexpr std::size_t kWindow = 4;
    if (errors.size() <= kWindow) return false;
    const double gain = errors.back() / errors[errors.size() - 1 - kWindow];
    return errors.back() * std::pow(gain, 2.0 * sweeps_left / kWindow) > tolerance;
  }

  /// Interfaces after every mode and the Gram matrices of the factors.
  void prepare() {
    const Eigen::Index terms = u_.weights.size();
    left_.front() = Eigen::MatrixXd::Ones(terms, 1);
    right_.back() = Eigen::MatrixXd::Ones(terms, 1);
    for (std::size_t k = right_.size(); k-- > 0;) {
      gram_[k] = u_.factors[k].transpose() * u_.factors[k];
      if (k > 0) right_[k - 1] = contracted_right(k);
    }
  }

  /// Row r: core k with the factors of term r up to mode k, terms x right rank.
  Eigen::MatrixXd contracted_left(std::size_t k) const {
    const TrainCore& core = target_.cores[k];
    const Eigen::MatrixXd carried = left_[k] * core.right_unfolding();  // terms x (n right)
    Eigen::MatrixXd result(carried.rows(), core.right);
    for (int q = 0; q < core.right; ++q) {
      const auto block = carried.middleCols(Eigen::Index{q} * core.size, core.size);
      result.col(q) = block.cwiseProduct(u_.factors[k].transpose()).rowwise().sum();
    }
    return result;
  }

  /// Row r: core k with the factors of term r from mode k on, terms x left rank.
  Eigen::MatrixXd contracted_right(std::size_t k) const {
    const TrainCore& core = target_.cores[k];
    const Eigen::MatrixXd carried = core.left_unfolding() * right_[k].transpose();  // (left n) x terms
    Eigen::MatrixXd result(right_[k].rows(), core.left);
    for (Eigen::Index r = 0; r < carried.cols(); ++r) {
      const Eigen::Map<const Eigen::MatrixXd> block(carried.col(r).data(), core.left, core.size);
      result.row(r) = (block * u_.factors[k].col(r)).transpose();
    }
    return result;
  }

  /// Target against all factors but those of mode k: n x terms.
  Eigen::MatrixXd contracted_others(std::size_t k) const {
    const TrainCore& core = target_.cores[k];
    const Eigen::MatrixXd carried = core.left_unfolding() * right_[k].transpose();  // (left n) x terms
    Eigen::MatrixXd result(core.size, carried.cols());
    for (Eigen::Index r = 0; r < carried.cols(); ++r) {
      const Eigen::Map<const Eigen::MatrixXd> block(carried.col(r).data(), core.left, core.size);
      result.col(r) = block.transpose() * left_[k].row(r).transpose();
    }
    return result;
  }

  /// <u, target> from the interfaces at the first mode.
  double overlap() const {
    return u_.weights.dot(contracted_others(0).cwiseProduct(u_.factors[0]).colwise().sum().transpose());
  }

  void update(int mode, bool forward) {
    const auto k = static_cast<std::size_t>(mode);
    Eigen::MatrixXd gram = Eigen::MatrixXd::Ones(u_.rank(), u_.rank());
    for (std::size_t j = 0; j < gram_.size(); ++j) {
      if (j != k) gram.array() *= gram_[j].array();
    }
    // A step towards the least squares from where we are: the small damping keeps terms that are nearly
    // parallel from growing against each other.
    constexpr double kDamping = 1e-15;  // round-off of a Gram matrix
    gram.diagonal().array() += kDamping;
    const Eigen::MatrixXd present = u_.factors[k] * u_.weights.asDiagonal();
    const Eigen::MatrixXd rhs = contracted_others(k) + kDamping * present;
    Eigen::MatrixXd factor = gram.ldlt().solve(Eigen::MatrixXd(rhs.transpose())).transpose();
    if (!factor.allFinite()) return;
    const Eigen::VectorXd lengths = factor.colwise().norm().transpose();
    if (lengths.minCoeff() == 0.0) return;
    u_.weights = lengths;
    u_.factors[k] = factor * lengths.cwiseInverse().asDiagonal();
    gram_[k] = u_.factors[k].transpose() * u_.factors[k];
    if (forward && k + 1 < left_.size()) left_[k + 1] = contracted_left(k);
    if (!forward && k > 0) right_[k - 1] = contracted_right(k);
  }

  const TensorTrain& target_;
  double size_;
  SeparatedTensor u_;
  std::vector<Eigen::MatrixXd> left_;   ///< per mode: terms x left rank, target and u before the mode
  std::vector<Eigen::MatrixXd> right_;  ///< per mode: terms x right rank, after the mode
  std::vector<Eigen::MatrixXd> gram_;   ///< per mode: terms x terms
};

SeparatedTensor random_product(const TensorTrain& like, Random& random) {
  std::vector<Eigen::VectorXd> columns;
  for (const TrainCore& core : like.cores) {
    columns.emplace_back(
        Eigen::VectorXd::NullaryExpr(core.size, [&random](Eigen::Index) { return random.normal(); }));
  }
  SeparatedTensor product = SeparatedTensor::product(std::move(columns));
  product.normalise();
  return product;
}

/// The best product for what the sum leaves of the target.
SeparatedTensor next_term(const TensorTrain& target, const SeparatedTensor& sum, Random& random) {
  constexpr int kSweeps = 5;
  const TensorTrain rest = sum.rank() == 0 ? target : pgd::sum(target, to_train(sum), -1.0);
  AlternatingFit product(rest, random_product(target, random));
  product.improve(0.0, kSweeps);
  return product.sum();
}

/// The sum without its smallest term, improved again, as long as it meets the tolerance.
void drop_terms(AlternatingFit& fit, SumFit& best, const SumFitOptions& options) {
  while (best.tensor.rank() > std::max(options.start_rank, 1)) {
    Eigen::Index smallest = 0;
    best.tensor.weights.cwiseAbs().minCoeff(&smallest);
    std::vector<int> others;
    for (int r = 0; r < best.tensor.rank(); ++r) {
      if (r != smallest) others.push_back(r);
    }
    SeparatedTensor shorter = best.tensor;
    shorter.keep(others);
    fit.set(std::move(shorter));
    const double error = fit.improve(options.tolerance, options.max_sweeps);
    if (error > options.tolerance) return;
    best = {fit.sum(), error, true};
  }
}

/// True if the error, falling on per term as over the last half of the terms, would still be above the
/// tolerance with all terms allowed. Before twice the lower bound it may still drop at once.
bool hopeless(const std::vector<double>& errors, const SumFitOptions& options) {
  const auto rank = static_cast<int>(errors.size());
  if (rank < 2 * options.start_rank + 10) return false;
  const double gain = errors.back() / errors[errors.size() / 2];
  const double halves_left = 2.0 * (options.max_rank - rank) / rank;
  return errors.back() * std::pow(gain, halves_left) > options.tolerance;
}

}  // namespace

SumFit fit_sum(const TensorTrain& target, const SumFitOptions& options) {
  // Fewer terms than the lower bound cannot do: they are a start for those that follow.
  constexpr int kStartSweeps = 2;
  Random random(1);
  std::vector<int> sizes;
  for (const TrainCore& core : target.cores) sizes.push_back(core.size);
  AlternatingFit fit(target, SeparatedTensor::zero(sizes));
  SumFit best{SeparatedTensor::zero(sizes), norm(target), false};
  best.met = best.error <= options.tolerance;
  std::vector<double> errors;
  while (!best.met && best.tensor.rank() < options.max_rank && !hopeless(errors, options)) {
    SeparatedTensor longer = best.tensor;
    longer.append(next_term(target, best.tensor, random));
    fit.set(std::move(longer));
    const bool enough = fit.sum().rank() >= options.start_rank;
    errors.push_back(fit.improve(options.tolerance, enough ? options.max_sweeps : kStartSweeps));
    best = {fit.sum(), errors.back(), errors.back() <= options.tolerance};
  }
  if (best.met) drop_terms(fit, best, options);
  return best;
}

}  // namespace samara::pgd
