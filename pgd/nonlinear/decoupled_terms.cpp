#include "samara/pgd/nonlinear/decoupled_terms.h"

#include <utility>

namespace samara::pgd {

bool is_own_linear(const Monomial& term) {
  for (std::size_t m = 0; m < term.state_powers.size(); ++m) {
    if (term.state_powers[m] != (static_cast<int>(m) == term.state ? 1 : 0)) return false;
  }
  return true;
}

SeparatedTensor initial_tensor(const EvolutionProblem& problem, std::size_t state) {
  const InitialValue& initial = problem.initial[state];
  std::vector<Eigen::VectorXd> columns = {Eigen::VectorXd::Ones(1)};
  for (const Axis& axis : problem.parameters) columns.emplace_back(Eigen::VectorXd::Ones(axis.size()));
  if (initial.axis >= 0) {
    const auto axis = static_cast<std::size_t>(initial.axis);
    columns[axis + 1] = problem.parameters[axis].nodes();
  }
  SeparatedTensor tensor = SeparatedTensor::product(std::move(columns));
  tensor.weights *= (initial.axis >= 0 ? 1.0 : initial.value) / problem.scales[state];
  return tensor;
}

SeparatedOperator own_operator(const EvolutionGrid& grid, int state) {
  const EvolutionProblem& problem = grid.problem();
  SeparatedOperator op;
  std::vector<ModeOperator> identity;
  for (const int size : grid.sizes()) identity.push_back(ModeOperator::identity(size));
  op.terms.push_back(identity);
  for (const Monomial& term : problem.system->polynomial()->terms()) {
    if (term.state != state || !is_own_linear(term)) continue;
    std::vector<ModeOperator> parts = identity;
    parts[0] = ModeOperator::dense(-term.coefficient * grid.duration() * grid.integration());
    for (std::size_t k = 0; k < term.parameter_powers.size(); ++k) {
      if (term.parameter_powers[k] == 0) continue;
      parts[k + 1] = ModeOperator::diagonal(
          problem.parameters[k].nodes().array().pow(term.parameter_powers[k]).matrix());
    }
    op.terms.push_back(std::move(parts));
  }
  return op;
}

}  // namespace samara::pgd
