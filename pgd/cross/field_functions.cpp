#include "samara/pgd/cross/field_functions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/base/unit_labels.h"
#include "samara/pgd/cross/nodal_approximation.h"
#include "samara/pgd/fields/field_check.h"
#include "samara/pgd/tensors/random.h"

namespace samara::pgd {

namespace {

void validate(const FieldReferences& fields, const std::vector<OutputLabel>& outputs) {
  require(!fields.empty(), "the number of fields", fields.size(), "at least 1", "function of fields");
  require(!outputs.empty(), "the number of outputs", outputs.size(), "at least 1", "function of fields");
  for (const SeparatedField& field : fields) {
    require_same_axes("function", fields.front().get().axes(), field.axes());
  }
}

/// Which outputs meet: equally many, or one with all.
struct Pairs {
  int count = 0;
  int f_step = 1;
  int g_step = 1;
};

Pairs pairs(const char* what, const SeparatedField& f, const SeparatedField& g) {
  const int nf = f.output_count();
  const int ng = g.output_count();
  if (nf != ng && nf != 1 && ng != 1) {
    throw ArgumentError(fmt::format(
        "{} of fields of {} and {} outputs, expected the same number, or one for all", what, nf, ng));
  }
  return {std::max(nf, ng), nf == 1 ? 0 : 1, ng == 1 ? 0 : 1};
}

/// The smallest value of sign * output m on the grid that coordinate descent from a start finds: along one
/// grid line after the other.
double descend(const SeparatedField& field, int m, double sign, Eigen::VectorXi& node) {
  constexpr int kSweeps = 3;
  double best = 0.0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (Eigen::Index k = 0; k < node.size(); ++k) {
      Eigen::VectorXd products = sign * field.weights().row(m).transpose();
      for (Eigen::Index j = 0; j < node.size(); ++j) {
        if (j != k)
          products.array() *= field.factors()[static_cast<std::size_t>(j)].row(node[j]).transpose().array();
      }
      best = (field.factors()[static_cast<std::size_t>(k)] * products).minCoeff(&node[k]);
    }
  }
  return best;
}

/// A node where output m is zero or has not the sign it has elsewhere; empty if none was found. Sets the
/// sign.
std::vector<int> sign_change(const SeparatedField& field, int m, Random& random, double& sign) {
  constexpr int kStarts = 16;
  const std::vector<int> sizes = sizes_of(field.axes());
  sign = 0.0;
  Eigen::VectorXd products;
  Eigen::VectorXd values(field.output_count());
  for (int i = 0; i < kStarts; ++i) {
    Eigen::VectorXi node = random_nodes(sizes, 1, random).col(0);
    values_at(field, node, products, values);
    if (sign == 0.0) sign = values[m] < 0.0 ? -1.0 : 1.0;
    if (!(sign * values[m] > 0.0) || !(descend(field, m, sign, node) > 0.0))
      return {node.begin(), node.end()};
  }
  return {};
}

}  // namespace

FunctionResult function_of(const FieldReferences& fields, std::vector<OutputLabel> outputs,
                           const PointFunction& function, const FunctionOptions& options) {
  validate(fields, outputs);
  Eigen::Index inputs = 0;
  for (const SeparatedField& field : fields) inputs += field.output_count();
  Eigen::VectorXd input(inputs);
  Eigen::VectorXd products;
  const NodeFunction at_node = [&](Eigen::Ref<const Eigen::VectorXi> node, Eigen::VectorXd& values) {
    Eigen::Index first = 0;
    for (const SeparatedField& field : fields) {
      values_at(field, node, products, input.segment(first, field.output_count()));
      first += field.output_count();
    }
    function(input, values);
  };
  return approximate_nodal(fields.front().get().axes(), std::move(outputs), at_node, options);
}

FunctionResult product(const SeparatedField& f, const SeparatedField& g, const FunctionOptions& options) {
  require_same_axes("product", f.axes(), g.axes());
  const Pairs p = pairs("product", f, g);
  std::vector<OutputLabel> outputs;
  for (int m = 0; m < p.count; ++m) {
    const OutputLabel& a = f.outputs()[static_cast<std::size_t>(m * p.f_step)];
    const OutputLabel& b = g.outputs()[static_cast<std::size_t>(m * p.g_step)];
    outputs.push_back({a.name + " " + b.name, unit_product(a.unit, b.unit)});
  }
  const int second = f.output_count();
  return function_of(
      {f, g}, std::move(outputs),
      [&](const Eigen::VectorXd& x, Eigen::VectorXd& y) {
        for (int m = 0; m < p.count; ++m) y[m] = x[m * p.f_step] * x[second + m * p.g_step];
      },
      options);
}

FunctionResult quotient(const SeparatedField& f, const SeparatedField& g, const FunctionOptions& options) {
  require_same_axes("quotient", f.axes(), g.axes());
  const Pairs p = pairs("quotient", f, g);
  std::vector<OutputLabel> outputs;
  for (int m = 0; m < p.count; ++m) {
    const OutputLabel& a = f.outputs()[static_cast<std::size_t>(m * p.f_step)];
    const OutputLabel& b = g.outputs()[static_cast<std::size_t>(m * p.g_step)];
    outputs.push_back({a.name + " / " + b.name, unit_quotient(a.unit, b.unit)});
  }
  Random random(options.seed);
  const auto refuse = [&](int m, std::vector<double> point, FunctionResult result) {
    result.field.reset();
    result.tolerance_met = false;
    result.status = Termination::sign_change;
    result.message = fmt::format("the denominator {} is zero or changes its sign at {}",
                                 g.outputs()[static_cast<std::size_t>(m)].name, described(g.axes(), point));
    result.point = std::move(point);
    return result;
  };
  Eigen::VectorXd signs(g.output_count());
  for (int m = 0; m < g.output_count(); ++m) {
    const std::vector<int> node = sign_change(g, m, random, signs[m]);
    if (!node.empty()) return refuse(m, coordinates(g.axes(), node), {});
  }
  const int second = f.output_count();
  // The denominator that was not of its sign at the first node without a value, which is the one that is told.
  int changed = -1;
  bool is_finite = true;  // so far
  const PointFunction divide = [&](const Eigen::VectorXd& x, Eigen::VectorXd& y) {
    for (int m = 0; m < p.count; ++m) {
      const int n = m * p.g_step;
      const double denominator = x[second + n];
      y[m] = x[m * p.f_step] / denominator;
      const bool keeps_sign = signs[n] * denominator > 0.0;
      if (!keeps_sign) y[m] = std::numeric_limits<double>::quiet_NaN();
      if (!keeps_sign && is_finite) changed = n;
      is_finite = is_finite && std::isfinite(y[m]);
    }
  };
  FunctionResult result = function_of({f, g}, std::move(outputs), divide, options);
  if (changed < 0) return result;
  const std::vector<double> point = result.point;
  return refuse(changed, point, std::move(result));
}

}  // namespace samara::pgd
