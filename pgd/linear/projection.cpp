#include "samara/pgd/linear/projection.h"

#include <map>
#include <utility>

#include "samara/pgd/linear/row_measure.h"

namespace samara::pgd {

namespace {

Eigen::VectorXd weights_of(const LinearProblem& problem, std::size_t k) {
  return k < problem.row_weights.size() ? problem.row_weights[k] : Eigen::VectorXd();
}

ProjectedForm project_galerkin(const LinearProblem& problem) {
  const OperatorChain chain(problem.op);
  std::vector<std::vector<ModeOperator>> parts;
  for (int k = 0; k < chain.modes(); ++k) {
    std::vector<ModeOperator>& scaled = parts.emplace_back();
    for (const ModeOperator& part : chain.mode(k).parts)
      scaled.push_back(part.row_scaled(weights_of(problem, static_cast<std::size_t>(k))));
  }
  return {OperatorChain(std::move(parts), chain.terms()), scaled_modes(problem.rhs, problem.row_weights)};
}

/// D^T S^T S G.
SeparatedTensor adjoint_rhs(const LinearProblem& problem, const std::vector<RowMeasure>& measures) {
  SeparatedTensor measured = problem.rhs;
  SeparatedOperator adjoint;
  for (std::size_t k = 0; k < measures.size(); ++k)
    measured.factors[k] = measures[k].squared(problem.rhs.factors[k]);
  for (const auto& term : problem.op.terms) {
    std::vector<ModeOperator> transposed;
    for (const ModeOperator& part : term)
      transposed.push_back(part.transposed_times({}, ModeOperator::identity(part.rows())));
    adjoint.terms.push_back(std::move(transposed));
  }
  return adjoint.apply(measured);
}

ProjectedForm project_minimal_residual(const LinearProblem& problem) {
  const OperatorChain chain(problem.op);
  const std::vector<RowMeasure> measures = row_measures(problem);
  const auto& terms = chain.terms();
  std::vector<std::vector<ModeOperator>> parts(static_cast<std::size_t>(chain.modes()));
  std::vector<std::vector<int>> pairs(terms.size() * terms.size(), std::vector<int>(parts.size()));
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const std::vector<ModeOperator>& distinct = chain.mode(static_cast<int>(k)).parts;
    std::map<std::pair<int, int>, int> known;
    for (std::size_t i = 0; i < terms.size(); ++i) {
      for (std::size_t j = 0; j < terms.size(); ++j) {
        const auto [it, is_new] =
            known.try_emplace({terms[i][k], terms[j][k]}, static_cast<int>(parts[k].size()));
        if (is_new) {
          const ModeOperator& left = distinct[static_cast<std::size_t>(terms[i][k])];
          const ModeOperator& right = distinct[static_cast<std::size_t>(terms[j][k])];
          parts[k].push_back(measures[k].between(left, right));
        }
        pairs[i * terms.size() + j][k] = it->second;
      }
    }
  }
  return {OperatorChain(std::move(parts), std::move(pairs)), adjoint_rhs(problem, measures)};
}

}  // namespace

ProjectedForm project(const LinearProblem& problem, Projection projection) {
  return projection == Projection::galerkin ? project_galerkin(problem) : project_minimal_residual(problem);
}

}  // namespace samara::pgd
