#include "samara/pgd/linear/residual.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/tensor_train.h"
#include "samara/pgd/tensors/thin_qr.h"

namespace samara::pgd {

namespace {

SeparatedTensor measured(SeparatedTensor tensor, const std::vector<RowMeasure>& measures) {
  for (std::size_t k = 0; k < measures.size(); ++k) tensor.factors[k] = measures[k].apply(tensor.factors[k]);
  return tensor;
}

using Link = OperatorChain::Link;

constexpr double kRounding = std::numeric_limits<double>::epsilon();

/// <D U, D U>, carried from mode to mode for every pair of states.
class SquaredNorm {
 public:
  SquaredNorm(const OperatorChain& chain, const Eigen::VectorXd& weights) : chain_(chain) {
    pairs_.push_back(weights * weights.transpose());
  }

  void visit(int mode, const std::vector<Eigen::MatrixXd>& applied) {
    const auto after = static_cast<std::size_t>(chain_.states(mode + 1));
    const auto before = static_cast<std::size_t>(chain_.states(mode));
    const Eigen::Index terms = pairs_.front().rows();
    std::vector<Eigen::MatrixXd> next(after * after, Eigen::MatrixXd::Zero(terms, terms));
    const std::size_t parts = applied.size();
    std::vector<Eigen::MatrixXd> grams(parts * parts);
    for (const Link& a : chain_.mode(mode).links) {
      for (const Link& b : chain_.mode(mode).links) {
        Eigen::MatrixXd& gram =
            grams[static_cast<std::size_t>(a.part) * parts + static_cast<std::size_t>(b.part)];
        if (gram.size() == 0) {
          gram.noalias() = applied[static_cast<std::size_t>(a.part)].transpose() *
                           applied[static_cast<std::size_t>(b.part)];
        }
        next[static_cast<std::size_t>(a.to) * after + static_cast<std::size_t>(b.to)].array() +=
            pairs_[static_cast<std::size_t>(a.from) * before + static_cast<std::size_t>(b.from)].array() *
            gram.array();
      }
    }
    pairs_ = std::move(next);
  }

  double value() const { return pairs_.front().sum(); }

 private:
  const OperatorChain& chain_;
  std::vector<Eigen::MatrixXd> pairs_;
};

/// Columns of one mode's unfolding of D U: for every state after it, `terms` columns of rows carry x size.
void add_operator_columns(const OperatorChain::Mode& mode, const std::vector<Eigen::MatrixXd>& applied,
                          const Eigen::MatrixXd& carry, Eigen::Index terms, Eigen::MatrixXd& unfolding) {
  for (const Link& link : mode.links) {
    const Eigen::MatrixXd& factor = applied[static_cast<std::size_t>(link.part)];
    for (Eigen::Index r = 0; r < terms; ++r) {
      Eigen::Map<Eigen::MatrixXd>(unfolding.col(link.to * terms + r).data(), carry.rows(), factor.rows()) +=
          carry.col(link.from * terms + r) * factor.col(r).transpose();
    }
  }
}

}  // namespace

Residual::Residual(const LinearProblem& problem)
    : chain_(problem.op),
      measures_(row_measures(problem)),
      rhs_(measured(problem.rhs, measures_)),
      rhs_norm_(norm(rhs_)) {
  Eigen::ArrayXd sizes = rhs_.weights.cwiseAbs();
  for (const Eigen::MatrixXd& factor : rhs_.factors) sizes *= factor.colwise().norm().transpose().array();
  rhs_squares_ = sizes.square().sum();
  if (rhs_norm_ <= 10.0 * kRounding * sizes.sum()) rhs_norm_ = 0.0;
}

std::vector<Eigen::MatrixXd> Residual::applied(int mode, const SeparatedTensor& u) const {
  const auto k = static_cast<std::size_t>(mode);
  std::vector<Eigen::MatrixXd> results;
  for (const ModeOperator& part : chain_.mode(mode).parts)
    results.push_back(measures_[k].apply(part.apply(u.factors[k])));
  return results;
}

Residual::Squared Residual::squared(const SeparatedTensor& u) const {
  SquaredNorm square(chain_, u.weights);
  ChainProducts mixed(chain_, rhs_.rank(), u.rank());
  ChainProducts sizes(chain_, 1, u.rank());
  for (int k = 0; k < chain_.modes(); ++k) {
    const std::vector<Eigen::MatrixXd> y = applied(k, u);
    square.visit(k, y);
    for (std::size_t p = 0; p < y.size(); ++p) {
      const int part = static_cast<int>(p);
      mixed.gram(k, part).noalias() = rhs_.factors[static_cast<std::size_t>(k)].transpose() * y[p];
      sizes.gram(k, part) = y[p].colwise().squaredNorm();
    }
  }
  mixed.start(rhs_.weights * u.weights.transpose());
  sizes.start(u.weights.cwiseAbs2().transpose());
  for (int k = 0; k < chain_.modes(); ++k) {
    mixed.advance(k);
    sizes.advance(k);
  }
  // The inner products of all pairs of terms are added up; their rounding errors are independent.
  const double scale = sizes.total().sum() + rhs_squares_;
  return {square.value() - 2.0 * mixed.total().sum() + rhs_norm_ * rhs_norm_, kRounding * scale};
}

double Residual::rounding(const SeparatedTensor& u) const {
  ChainProducts sizes(chain_, 1, u.rank());
  for (int k = 0; k < chain_.modes(); ++k) {
    const auto mode = static_cast<std::size_t>(k);
    // Rounding has no preferred sign: a measure that smooths must not see it add up.
    Random random(mode + 1);
    const Eigen::VectorXd signs = Eigen::VectorXd::NullaryExpr(
        rhs_.factors[mode].rows(), [&](Eigen::Index) { return random.uniform() < 0.5 ? -1.0 : 1.0; });
    const std::vector<ModeOperator>& parts = chain_.mode(k).parts;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const Eigen::MatrixXd sums = signs.asDiagonal() * parts[p].apply_magnitudes(u.factors[mode]);
      sizes.gram(k, static_cast<int>(p)) = measures_[mode].apply(sums).colwise().norm();
    }
  }
  sizes.start(u.weights.cwiseAbs().transpose());
  for (int k = 0; k < chain_.modes(); ++k) sizes.advance(k);
  return kRounding * sizes.total().sum() / rhs_norm_;
}

double Residual::fast(const SeparatedTensor& u) const {
  if (is_zero()) return u.rank() == 0 ? 0.0 : std::numeric_limits<double>::infinity();
  if (u.rank() == 0) return 1.0;
  const Squared square = squared(u);
  if (!std::isfinite(square.value)) return std::numeric_limits<double>::quiet_NaN();
  return std::max(std::sqrt(std::max(square.value, square.noise)) / rhs_norm_, rounding(u));
}

double Residual::exact(const SeparatedTensor& u) const {
  if (is_zero()) return u.rank() == 0 ? 0.0 : std::numeric_limits<double>::infinity();
  const Eigen::Index terms = u.rank();
  const Eigen::Index sources = rhs_.rank();
  // Cores of D U - G block by block, as in to_train(): columns of `carry` are states x terms, then sources.
  Eigen::MatrixXd carry(1, terms + sources);
  carry << u.weights.transpose(), -rhs_.weights.transpose();
  double residual = 0.0;
  for (int k = 0; k < chain_.modes(); ++k) {
    const std::vector<Eigen::MatrixXd> y = applied(k, u);
    const Eigen::MatrixXd& g = rhs_.factors[static_cast<std::size_t>(k)];
    const Eigen::Index operator_columns = chain_.states(k + 1) * terms;
    Eigen::MatrixXd unfolding = Eigen::MatrixXd::Zero(carry.rows() * g.rows(), operator_columns + sources);
    add_operator_columns(chain_.mode(k), y, carry, terms, unfolding);
    for (Eigen::Index m = 0; m < sources; ++m) {
      Eigen::Map<Eigen::MatrixXd>(unfolding.col(operator_columns + m).data(), carry.rows(), g.rows()) =
          carry.col(carry.cols() - sources + m) * g.col(m).transpose();
    }
    if (k + 1 == chain_.modes()) {
      residual = unfolding.rowwise().sum().norm() / rhs_norm_;
    } else {
      carry = qr_factor(unfolding);
    }
  }
  return terms == 0 || !std::isfinite(residual) ? residual : std::max(residual, rounding(u));
}

double Residual::resolved(const SeparatedTensor& u) const {
  constexpr double kClear = 1e2;  // of the square: the residual itself is then known to half a per cent
  if (is_zero() || u.rank() == 0) return fast(u);
  const Squared square = squared(u);
  if (square.value > kClear * square.noise) return std::max(std::sqrt(square.value) / rhs_norm_, rounding(u));
  return exact(u);
}

double fast_relative_residual(const LinearProblem& problem, const SeparatedTensor& u) {
  return Residual(problem).fast(u);
}

double relative_residual(const LinearProblem& problem, const SeparatedTensor& u) {
  return Residual(problem).exact(u);
}

}  // namespace samara::pgd
