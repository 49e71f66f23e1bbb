// An operator of one's own: u(x) - m * integral of exp(-|x - y|) u(y) dy = 1 on (0,1) (Fredholm's equation of
// the second kind) for all strengths m in [0, 0.9]. Any matrix can stand on an axis; this one is dense.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <Eigen/LU>

#include "samara/pgd/linear/enrichment.h"
#include "samara/pgd/linear/parametric_problem.h"

int main() {
  using namespace samara::pgd;
  const Axis x =
      Axis::p1({"x"}, 0.0, 1.0, 101);  // its role is not space: equations hold at the nodes
  const Axis m = Axis::chebyshev({"m"}, 0.0, 0.9, 14);
  Eigen::MatrixXd kernel(x.size(), x.size());
  for (int i = 0; i < x.size(); ++i) {
    for (int j = 0; j < x.size(); ++j)
      kernel(i, j) = std::exp(-std::abs(x.nodes()[i] - x.nodes()[j])) * x.weights()[j];
  }

  ParametricProblem equation({x, m});
  equation.add_term({});  // the identity
  equation.add_term({{"x", ModeOperator::dense(kernel)}, {"m", ModeOperator::diagonal(m.nodes())}},
                    -1.0);
  equation.add_source({});
  EnrichOptions options;
  options.residual_tolerance = 1e-10;
  const EnrichResult result = enrich(equation.assemble(), options);
  std::printf("%s: %s\n", to_string(result.termination).c_str(), result.message.c_str());

  // The same, solved directly at one strength.
  const int last = m.size() - 1;
  const Eigen::MatrixXd matrix =
      Eigen::MatrixXd::Identity(x.size(), x.size()) - m.nodes()[last] * kernel;
  const Eigen::VectorXd direct = matrix.lu().solve(Eigen::VectorXd::Ones(x.size()));
  double largest = 0.0;
  for (int i = 0; i < x.size(); ++i) {
    const std::vector<int> index = {i, last};
    largest = std::max(largest, std::abs(result.solution.entry(index) - direct[i]));
  }
  std::printf("largest difference from the direct solution at m = %.1f: %.1e\n", m.nodes()[last],
              largest);
  return result.termination == samara::Termination::converged && largest < 1e-8 ? 0 : 1;
}
