#include "samara/pgd/linear/operator_chain.h"

#include <catch2/catch.hpp>

#include "random_tensor.h"

using namespace samara::pgd;

namespace {

ModeOperator random_part(int size, int kind, Random& random) {
  const Eigen::MatrixXd values =
      Eigen::MatrixXd::NullaryExpr(size, size, [&](Eigen::Index, Eigen::Index) { return random.normal(); });
  if (kind == 0) return ModeOperator::identity(size);
  if (kind == 1) return ModeOperator::diagonal(values.col(0));
  if (kind == 2) return ModeOperator::sparse(values.sparseView(1.0, 1.0));
  return ModeOperator::dense(values);
}

/// Products of parts along every path of the chain, summed: the operator as a dense matrix on all modes.
Eigen::MatrixXd dense(const SeparatedOperator& op) {
  Eigen::MatrixXd sum;
  for (const auto& term : op.terms) {
    Eigen::MatrixXd product = Eigen::MatrixXd::Identity(1, 1);
    for (const ModeOperator& part : term) {
      const Eigen::MatrixXd matrix = part.apply(Eigen::MatrixXd::Identity(part.cols(), part.cols()));
      Eigen::MatrixXd larger(product.rows() * matrix.rows(), product.cols() * matrix.cols());
      for (Eigen::Index i = 0; i < product.rows(); ++i) {
        for (Eigen::Index j = 0; j < product.cols(); ++j)
          larger.block(i * matrix.rows(), j * matrix.cols(), matrix.rows(), matrix.cols()) =
              product(i, j) * matrix;
      }
      product = larger;
    }
    sum = sum.size() == 0 ? product : Eigen::MatrixXd(sum + product);
  }
  return sum;
}

Eigen::VectorXd dense(const SeparatedTensor& tensor) {
  Eigen::MatrixXd columns = tensor.weights.transpose();
  for (const Eigen::MatrixXd& factor : tensor.factors) {
    Eigen::MatrixXd larger(columns.rows() * factor.rows(), columns.cols());
    for (Eigen::Index i = 0; i < columns.rows(); ++i)
      larger.middleRows(i * factor.rows(), factor.rows()) = factor * columns.row(i).asDiagonal();
    columns = larger;
  }
  return columns.rowwise().sum();
}

/// <V, A U> summed over all terms, by the chain.
double by_chain(const SeparatedOperator& op, const SeparatedTensor& v, const SeparatedTensor& u) {
  const OperatorChain chain(op);
  ChainProducts products(chain, v.rank(), u.rank());
  for (int k = 0; k < chain.modes(); ++k)
    products.refresh(k, v.factors[static_cast<std::size_t>(k)], u.factors[static_cast<std::size_t>(k)]);
  products.start(v.weights * u.weights.transpose());
  for (int k = 0; k < chain.modes(); ++k) products.advance(k);
  return products.total().sum();
}

SeparatedOperator laplacian(int dimensions) {
  Random random(1);
  const ModeOperator second = random_part(4, 2, random);
  SeparatedOperator op;
  for (int i = 0; i < dimensions; ++i) {
    op.terms.emplace_back(static_cast<std::size_t>(dimensions), ModeOperator::identity(4));
    op.terms.back()[static_cast<std::size_t>(i)] = second;
  }
  return op;
}

}  // namespace

TEST_CASE("a chain of random terms is the sum of the terms") {
  const std::vector<int> sizes = {3, 4, 2};
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    SeparatedOperator op;
    const int terms = 1 + random.below(6);
    for (int i = 0; i < terms; ++i) {
      op.terms.emplace_back();
      // Identities are common, so that terms share.
      for (const int n : sizes)
        op.terms.back().push_back(random_part(n, std::max(0, random.below(8) - 4), random));
    }
    if (seed % 3 == 0) op.terms.push_back(op.terms.front());  // a term that stands twice counts twice
    const SeparatedTensor u = random_tensor(sizes, 3, seed + 100);
    const SeparatedTensor v = random_tensor(sizes, 2, seed + 200);
    const double expected = dense(v).dot(dense(op) * dense(u));
    CHECK(by_chain(op, v, u) == Approx(expected).epsilon(1e-12).margin(1e-10));
  }
}

TEST_CASE("a Laplacian has two states and three kinds of links, however many dimensions") {
  for (const int d : {3, 10, 40}) {
    const OperatorChain chain(laplacian(d));
    for (int k = 1; k < d; ++k) CHECK(chain.states(k) == 2);
    CHECK(chain.states(0) == 1);
    CHECK(chain.states(d) == 1);
    for (int k = 1; k + 1 < d; ++k) CHECK(chain.mode(k).links.size() == 3);
    for (int k = 0; k < d; ++k) CHECK(chain.mode(k).parts.size() == 2);
  }
}

TEST_CASE("coefficients of a mode are what the sum over the other modes leaves") {
  const std::vector<int> sizes = {4, 4, 4};
  const SeparatedOperator op = laplacian(3);
  const OperatorChain chain(op);
  const SeparatedTensor u = random_tensor(sizes, 2, 5);
  ChainProducts products(chain, 2, 2);
  for (int k = 0; k < 3; ++k)
    products.refresh(k, u.factors[static_cast<std::size_t>(k)], u.factors[static_cast<std::size_t>(k)]);
  products.start();
  for (int k = 0; k < 3; ++k) {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(2, 2);
    const auto& c = products.coefficients(k);
    for (std::size_t p = 0; p < c.size(); ++p)
      sum.array() += c[p].array() * products.gram(k, static_cast<int>(p)).array();
    products.advance(k);
    if (k == 2) CHECK((sum - products.total()).norm() < 1e-12 * sum.norm());
  }
}
