#include "samara/pgd/evolution/evolution_terms.h"

#include <cmath>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::pgd {

namespace {
/// Inverse of the derivative matrix without the first node, per duration. Element by element, so that the
/// matrix has exact zeros where a node lies before another: the integral up to a node does not depend on
/// later ones.
Eigen::MatrixXd integration_matrix(const Axis& time) {
  const int inner = time.size() - 1;
  const int degree = time.degree();
  const Eigen::MatrixXd& local = time.element_basis().differentiation();
  const Eigen::MatrixXd per_unit = local.bottomRightCorner(degree, degree).partialPivLu().inverse();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(inner, inner);
  for (int e = 0; e < time.elements(); ++e) {
    const double half = 0.5 * (time.borders()[e + 1] - time.borders()[e]) / time.length();
    const int first = e * degree;
    matrix.block(first, first, degree, degree) = half * per_unit;
    // Later nodes see the whole element: the row of its last node.
    matrix.block(first + degree, first, inner - first - degree, degree).rowwise() =
        half * per_unit.row(degree - 1);
  }
  return matrix;
}
}  // namespace

EvolutionGrid::EvolutionGrid(const EvolutionProblem& problem) : problem_(problem) {
  const Axis& time = problem.time;
  const int inner = time.size() - 1;
  integration_ = integration_matrix(time);
  sizes_.push_back(inner);
  weights_.emplace_back();
  weights_.emplace_back(time.weights().tail(inner) / time.weights().tail(inner).sum());
  for (const Axis& axis : problem.parameters) {
    sizes_.push_back(axis.size());
    // The rule of the radau kind gives its first node no weight, and errors there would not count.
    weights_.emplace_back((axis.weights() / axis.measure()).cwiseMax(1e-3 / axis.size()));
  }
  for (const Eigen::VectorXd& w : weights_) root_weights_.emplace_back(w.cwiseSqrt());
  scales_ = Eigen::Map<const Eigen::VectorXd>(problem.scales.data(),
                                              static_cast<Eigen::Index>(problem.scales.size()));
}

double EvolutionGrid::size() const {
  double n = 1.0;
  for (const int s : sizes_) n *= s;
  return n;
}

SeparatedTensor EvolutionGrid::initial() const {
  std::vector<int> sizes = {states()};
  sizes.insert(sizes.end(), sizes_.begin(), sizes_.end());
  SeparatedTensor tensor = SeparatedTensor::zero(sizes);
  for (int s = 0; s < states(); ++s) {
    const InitialValue& initial = problem_.initial[static_cast<std::size_t>(s)];
    if (initial.axis < 0 && initial.value == 0.0) continue;
    std::vector<Eigen::VectorXd> columns;
    columns.emplace_back(Eigen::VectorXd::Unit(states(), s) / scales_[s]);
    for (const int n : sizes_) columns.emplace_back(Eigen::VectorXd::Ones(n));
    if (initial.axis < 0) {
      columns[0] *= initial.value;
    } else {
      columns[static_cast<std::size_t>(initial.axis) + 2] =
          problem_.parameters[static_cast<std::size_t>(initial.axis)].nodes();
    }
    tensor.append(SeparatedTensor::product(std::move(columns)));
  }
  return tensor;
}

Eigen::MatrixXd EvolutionGrid::gather(const SeparatedTensor& tensor, const IndexBatch& entries) {
  const Eigen::MatrixXd outputs = tensor.factors[0] * tensor.weights.asDiagonal();
  // Terms x nodes: the values of one entry are then contiguous.
  std::vector<Eigen::MatrixXd> by_term;
  for (std::size_t k = 1; k < tensor.factors.size(); ++k) by_term.emplace_back(tensor.factors[k].transpose());
  Eigen::MatrixXd values(outputs.rows(), entries.cols());
  Eigen::VectorXd product(tensor.rank());
  for (Eigen::Index j = 0; j < entries.cols(); ++j) {
    product.setOnes();
    for (std::size_t k = 0; k < by_term.size(); ++k) {
      product.array() *= by_term[k].col(entries(static_cast<Eigen::Index>(k), j)).array();
    }
    values.col(j).noalias() = outputs * product;
  }
  return values;
}

EvolutionGrid::Points EvolutionGrid::points(const SeparatedTensor& state, const IndexBatch& entries) const {
  Points p;
  p.x = scales_.asDiagonal() * gather(state, entries);
  p.t.resize(entries.cols());
  p.q.resize(static_cast<Eigen::Index>(problem_.parameters.size()), entries.cols());
  for (Eigen::Index j = 0; j < entries.cols(); ++j) {
    p.t[j] = problem_.time.nodes()[entries(0, j) + 1];
    for (Eigen::Index k = 0; k < p.q.rows(); ++k) {
      p.q(k, j) = problem_.parameters[static_cast<std::size_t>(k)].nodes()[entries(k + 1, j)];
    }
  }
  return p;
}

void EvolutionGrid::rhs(const SeparatedTensor& state, const IndexBatch& entries,
                        Eigen::MatrixXd& values) const {
  const Points p = points(state, entries);
  problem_.system->rhs(p.t, p.x, p.q, values);
  values = (duration() * scales_.cwiseInverse()).asDiagonal() * values;
}

void EvolutionGrid::jacobian(const SeparatedTensor& state, const IndexBatch& entries,
                             Eigen::MatrixXd& values) const {
  const Points p = points(state, entries);
  problem_.system->jacobian(p.t, p.x, p.q, values);
  const Eigen::MatrixXd scaling = duration() * scales_.cwiseInverse() * scales_.transpose();
  values = Eigen::Map<const Eigen::VectorXd>(scaling.data(), scaling.size()).asDiagonal() * values;
}

SeparatedOperator EvolutionGrid::linear_operator(const SeparatedTensor& jacobian) const {
  SeparatedOperator op;
  std::vector<ModeOperator> identity = {ModeOperator::identity(states())};
  for (const int n : sizes_) identity.push_back(ModeOperator::identity(n));
  op.terms.push_back(std::move(identity));
  for (Eigen::Index r = 0; r < jacobian.rank(); ++r) {
    const Eigen::VectorXd matrix = -jacobian.weights[r] * jacobian.factors[0].col(r);
    std::vector<ModeOperator> term;
    term.push_back(ModeOperator::dense(Eigen::Map<const Eigen::MatrixXd>(matrix.data(), states(), states())));
    term.push_back(ModeOperator::dense(integration_ * jacobian.factors[1].col(r).asDiagonal()));
    for (std::size_t k = 2; k < jacobian.factors.size(); ++k) {
      term.push_back(ModeOperator::diagonal(jacobian.factors[k].col(r)));
    }
    op.terms.push_back(std::move(term));
  }
  return op;
}

SeparatedField EvolutionGrid::field(const SeparatedTensor& w) const {
  SeparatedTensor all = w;
  // The initial values need no sum on the time axis beyond a constant; w vanishes at the start.
  const SeparatedTensor start = initial();
  all.append(start);
  std::vector<Axis> axes = {problem_.time};
  axes.insert(axes.end(), problem_.parameters.begin(), problem_.parameters.end());
  std::vector<Eigen::MatrixXd> factors;
  Eigen::MatrixXd time(problem_.time.size(), all.rank());
  time.row(0).head(w.rank()).setZero();
  time.row(0).tail(start.rank()).setOnes();
  time.bottomRows(problem_.time.size() - 1) = all.factors[1];
  factors.push_back(std::move(time));
  for (std::size_t k = 2; k < all.factors.size(); ++k) factors.push_back(all.factors[k]);
  const Eigen::MatrixXd weights = scales_.asDiagonal() * all.factors[0] * all.weights.asDiagonal();
  return SeparatedField(std::move(axes), problem_.states, std::move(factors), weights);
}

SeparatedTensor EvolutionGrid::from_field(const SeparatedField& field) const {
  SeparatedTensor w;
  w.weights = Eigen::VectorXd::Ones(field.rank());
  w.factors.push_back(scales_.cwiseInverse().asDiagonal() * field.weights());
  const auto resample = [&](int axis, const Eigen::VectorXd& nodes) {
    InterpolationStencil stencil = field.axes()[static_cast<std::size_t>(axis)].make_stencil();
    Eigen::VectorXd values(field.rank());
    Eigen::MatrixXd factor(nodes.size(), field.rank());
    for (Eigen::Index i = 0; i < nodes.size(); ++i) {
      field.factor_values(axis, nodes[i], stencil, values);
      factor.row(i) = values.transpose();
    }
    return factor;
  };
  w.factors.push_back(resample(0, problem_.time.nodes().tail(problem_.time.size() - 1)));
  for (std::size_t k = 0; k < problem_.parameters.size(); ++k) {
    w.factors.push_back(resample(static_cast<int>(k) + 1, problem_.parameters[k].nodes()));
  }
  w.append(initial(), -1.0);
  return w;
}

std::string EvolutionGrid::describe(const std::vector<int>& entry) const {
  std::string text = fmt::format("{} = {:.6g} {}", problem_.time.name(), problem_.time.nodes()[entry[0] + 1],
                                 problem_.time.unit());
  for (std::size_t k = 0; k < problem_.parameters.size(); ++k) {
    const Axis& axis = problem_.parameters[k];
    text += fmt::format(", {} = {:.6g} {}", axis.name(), axis.nodes()[entry[k + 1]], axis.unit());
  }
  return text;
}

}  // namespace samara::pgd
