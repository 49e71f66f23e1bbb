#include "samara/pgd/fields/variance_chain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/SparseCholesky>

#include "samara/pgd/tensors/tensor_train.h"
#include "samara/pgd/tensors/thin_qr.h"

namespace samara::pgd {

namespace {

constexpr double kRoundOff = 1e-14;

/// Maps of one coordinate of a sum of products, on terms x terms forms.
class TermMaps {
 public:
  TermMaps(const InputMeasure& input, const Eigen::MatrixXd& factor)
      : mean_(factor.transpose() * input.mean) {
    const Eigen::MatrixXd centred = input.root * (factor.rowwise() - mean_.transpose());
    covariance_ = centred.transpose() * centred;
    means_ = mean_ * mean_.transpose();
  }
  const Eigen::VectorXd& mean() const { return mean_; }
  Eigen::MatrixXd e(const Eigen::MatrixXd& x) const { return x.cwiseProduct(means_); }
  Eigen::MatrixXd v(const Eigen::MatrixXd& x) const { return x.cwiseProduct(covariance_); }
  static Eigen::MatrixXd add(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) { return x + y; }
  static Eigen::MatrixXd zero(Eigen::Index rank) { return Eigen::MatrixXd::Zero(rank, rank); }

 private:
  Eigen::VectorXd mean_;
  Eigen::MatrixXd means_, covariance_;
};

/// Maps of one coordinate of a train, on roots: a matrix B stands for the form B^T B, which is never formed,
/// because a large mean would cost it all digits of a small variance.
class CoreMaps {
 public:
  CoreMaps(const InputMeasure& input, const TrainCore& core)
      : mean_(Eigen::MatrixXd::Zero(core.left, core.right)) {
    for (int i = 0; i < core.size; ++i) mean_ += input.mean[i] * core.slice(i);
    Eigen::MatrixXd values(core.size, Eigen::Index{core.left} * core.right);
    for (int i = 0; i < core.size; ++i) {
      const Eigen::MatrixXd slice = core.slice(i) - mean_;
      values.row(i) = Eigen::Map<const Eigen::RowVectorXd>(slice.data(), slice.size());
    }
    const Eigen::MatrixXd centred = input.root * values;
    for (Eigen::Index i = 0; i < centred.rows(); ++i) {
      const Eigen::VectorXd row = centred.row(i).transpose();
      centred_.emplace_back(Eigen::Map<const Eigen::MatrixXd>(row.data(), core.left, core.right));
    }
  }
  const Eigen::MatrixXd& mean() const { return mean_; }
  Eigen::MatrixXd e(const Eigen::MatrixXd& x) const { return x * mean_; }
  Eigen::MatrixXd v(const Eigen::MatrixXd& x) const {
    Eigen::MatrixXd rows(x.rows() * static_cast<Eigen::Index>(centred_.size()), mean_.cols());
    for (std::size_t i = 0; i < centred_.size(); ++i) {
      rows.middleRows(static_cast<Eigen::Index>(i) * x.rows(), x.rows()) = x * centred_[i];
    }
    return shortened(rows);
  }
  static Eigen::MatrixXd add(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
    Eigen::MatrixXd rows(x.rows() + y.rows(), x.cols());
    rows << x, y;
    return shortened(rows);
  }
  static Eigen::MatrixXd zero(Eigen::Index rank) { return {0, rank}; }

 private:
  /// The same form with at most as many rows as columns.
  static Eigen::MatrixXd shortened(const Eigen::MatrixXd& rows) {
    return rows.rows() <= rows.cols() ? rows : qr_factor(rows);
  }

  Eigen::MatrixXd mean_;
  std::vector<Eigen::MatrixXd> centred_;  ///< left x right, per row of the root
};

enum class Others { averaged, kept };

/// Q at the end of the chain, see the header.
template <class Maps>
Eigen::MatrixXd variance_of(const std::vector<Maps>& maps, const InputSubset& active, Others others,
                            const Eigen::MatrixXd& start) {
  Eigen::MatrixXd p = start;
  Eigen::MatrixXd q = Maps::zero(start.cols());
  for (std::size_t k = 0; k < maps.size(); ++k) {
    const Maps& map = maps[k];
    const bool averaged = !active[k] && others == Others::averaged;
    q = averaged ? map.e(q) : Maps::add(map.e(q), map.v(q));
    if (active[k]) q = Maps::add(q, map.v(p));
    p = active[k] || averaged ? map.e(p) : Maps::add(map.e(p), map.v(p));
  }
  return q;
}

/// The variance of the component that depends on exactly the active coordinates.
template <class Maps>
Eigen::MatrixXd interaction_of(const std::vector<Maps>& maps, const InputSubset& active,
                               const Eigen::MatrixXd& start) {
  Eigen::MatrixXd p = start;
  for (std::size_t k = 0; k < maps.size(); ++k) p = active[k] ? maps[k].v(p) : maps[k].e(p);
  return p;
}

/// Computes all forms that are asked for; store(form, slot) puts one where slot(moments) says.
template <class Maps, class Store>
void all_forms(const std::vector<Maps>& maps, const std::vector<InputSubset>& subsets,
               const Eigen::MatrixXd& start, Store store) {
  const InputSubset all(maps.size(), true);
  store(variance_of(maps, all, Others::averaged, start),
        [](Moments& moments) -> double& { return moments.variance; });
  for (std::size_t a = 0; a < subsets.size(); ++a) {
    store(variance_of(maps, subsets[a], Others::averaged, start),
          [a](Moments& moments) -> double& { return moments.parts[a].closed; });
    store(variance_of(maps, subsets[a], Others::kept, start),
          [a](Moments& moments) -> double& { return moments.parts[a].total; });
    store(interaction_of(maps, subsets[a], start),
          [a](Moments& moments) -> double& { return moments.parts[a].interaction; });
  }
}

/// Root mean square of every term, without weights.
Eigen::VectorXd term_sizes(const std::vector<InputMeasure>& inputs,
                           const std::vector<Eigen::MatrixXd>& factors) {
  Eigen::VectorXd sizes = Eigen::VectorXd::Ones(factors.front().cols());
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    sizes.array() *= (inputs[k].root * factors[k]).colwise().norm().transpose().array();
  }
  return sizes;
}

/// The smallest matrix with the same lengths |root v|.
SparseMatrix shortest(const Eigen::MatrixXd& root) {
  return (root.rows() > root.cols() ? qr_factor(root) : root).sparseView();
}

}  // namespace

InputMeasure::InputMeasure(const Axis& axis) : mean(axis.weights() / axis.weights().sum()) {
  // M = L L^T
  const Eigen::SimplicialLLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> cholesky(axis.mass());
  root = SparseMatrix(cholesky.matrixU()) * (1.0 / std::sqrt(axis.measure()));
}

InputMeasure::InputMeasure(const Axis& axis, const QuadratureRule& rule)
    : mean(Eigen::VectorXd::Zero(axis.size())) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(rule.nodes.size(), axis.size());
  InterpolationStencil stencil = axis.make_stencil();
  for (Eigen::Index i = 0; i < rule.nodes.size(); ++i) {
    axis.interpolate(rule.nodes[i], stencil, false);
    const Eigen::Index nodes = stencil.value.size();
    mean.segment(stencil.first, nodes) += rule.weights[i] * stencil.value;
    rows.row(i).segment(stencil.first, nodes) = std::sqrt(rule.weights[i]) * stencil.value.transpose();
  }
  root = shortest(rows);
}

std::vector<Moments> sum_moments(const std::vector<InputMeasure>& inputs,
                                 const std::vector<Eigen::MatrixXd>& factors, const Eigen::MatrixXd& rows,
                                 const std::vector<InputSubset>& subsets) {
  const Eigen::Index rank = rows.cols();
  std::vector<Moments> result(static_cast<std::size_t>(rows.rows()));
  for (Moments& moments : result) moments.parts.resize(subsets.size());
  if (rank == 0) return result;
  std::vector<TermMaps> maps;
  Eigen::VectorXd means = Eigen::VectorXd::Ones(rank);
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    maps.emplace_back(inputs[k], factors[k]);
    means.array() *= maps[k].mean().array();
  }
  const Eigen::VectorXd mean = rows * means;
  const Eigen::VectorXd sizes = rows.cwiseAbs() * term_sizes(inputs, factors);
  all_forms(maps, subsets, Eigen::MatrixXd::Ones(rank, rank), [&](const Eigen::MatrixXd& form, auto slot) {
    const Eigen::VectorXd values = (rows * form).cwiseProduct(rows).rowwise().sum();
    for (Eigen::Index j = 0; j < values.size(); ++j) slot(result[static_cast<std::size_t>(j)]) = values[j];
  });
  for (Eigen::Index j = 0; j < rows.rows(); ++j) {
    Moments& moments = result[static_cast<std::size_t>(j)];
    // Terms much larger than their sum: the forms above have lost digits, orthonormal cores have not.
    const double noise = std::numeric_limits<double>::epsilon() * sizes[j] * sizes[j];
    if (noise > 1e-10 * moments.variance) {
      const TensorTrain train = to_train(SeparatedTensor{rows.row(j).transpose(), factors});
      moments = train_moments(inputs, train.cores, subsets);
    }
    moments.mean = mean[j];
    moments.round_off = kRoundOff * sizes[j];
  }
  return result;
}

Moments train_moments(const std::vector<InputMeasure>& inputs, const std::vector<TrainCore>& cores,
                      const std::vector<InputSubset>& subsets) {
  std::vector<CoreMaps> maps;
  Eigen::MatrixXd mean = Eigen::MatrixXd::Ones(1, 1);
  Eigen::MatrixXd square = mean;  // root of the mean square
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    maps.emplace_back(inputs[k], cores[k]);
    mean = (mean * maps[k].mean()).eval();
    square = CoreMaps::add(maps[k].e(square), maps[k].v(square));
  }
  Moments moments;
  moments.mean = mean(0, 0);
  moments.round_off = kRoundOff * square.norm();
  moments.parts.resize(subsets.size());
  all_forms(maps, subsets, Eigen::MatrixXd::Ones(1, 1),
            [&](const Eigen::MatrixXd& form, auto slot) { slot(moments) = form.squaredNorm(); });
  return moments;
}

}  // namespace samara::pgd
