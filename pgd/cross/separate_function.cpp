#include "samara/pgd/cross/separate_function.h"

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/cross/nodal_approximation.h"

namespace samara::pgd {

SeparatedFunction separate(const std::function<double(std::span<const double>)>& f,
                           const std::vector<Axis>& axes, const SeparateOptions& options) {
  if (axes.empty()) throw ArgumentError("a function of no axes cannot be separated");
  std::vector<double> x(axes.size());
  const NodeFunction at_node = [&](Eigen::Ref<const Eigen::VectorXi> node, Eigen::VectorXd& value) {
    for (std::size_t k = 0; k < axes.size(); ++k) x[k] = axes[k].nodes()[node[static_cast<Eigen::Index>(k)]];
    value[0] = f(x);
  };
  FunctionOptions how;
  how.tolerance = options.tolerance;
  how.max_rank = options.max_rank;
  how.seed = options.seed;
  const FunctionResult found = approximate_nodal(axes, {{"f"}}, at_node, how);
  if (!found.field) throw ArgumentError("the function to separate cannot be: " + found.message);
  SeparatedFunction result;
  result.tensor = {found.field->weights().row(0).transpose(), found.field->factors()};
  result.tensor.normalise();
  result.error = found.error;
  result.tolerance_met = found.tolerance_met;
  result.evaluations = found.evaluations;
  result.grid_size = found.grid_size;
  result.message = found.message;
  return result;
}

}  // namespace samara::pgd
