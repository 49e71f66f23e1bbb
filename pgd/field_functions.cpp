#include "samara/pgd/field_functions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/cross_interpolation.h"
#include "samara/pgd/field_algebra.h"
#include "samara/pgd/field_check.h"
#include "samara/pgd/random.h"
#include "samara/pgd/separation.h"
#include "samara/pgd/tensor_algebra.h"
#include "samara/pgd/unit_algebra.h"

namespace samara::pgd {

namespace {

std::vector<int> grid_of(const std::vector<Axis>& axes) {
  std::vector<int> sizes;
  for (const Axis& axis : axes) sizes.push_back(axis.size());
  return sizes;
}

std::vector<double> coordinates(const std::vector<Axis>& axes, const std::vector<int>& node) {
  std::vector<double> x;
  for (std::size_t k = 0; k < axes.size(); ++k) x.push_back(axes[k].nodes()[node[k]]);
  return x;
}

/// "t = 0.1 s, C_D = 1.2 1"
std::string described(const std::vector<Axis>& axes, const std::vector<double>& x) {
  std::string text;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    text += fmt::format("{}{} = {:.6g} {}", k == 0 ? "" : ", ", axes[k].name(), x[k], axes[k].unit());
  }
  return text;
}

IndexBatch random_nodes(const std::vector<int>& sizes, int count, Random& random) {
  IndexBatch nodes(static_cast<Eigen::Index>(sizes.size()), count);
  for (int j = 0; j < count; ++j) {
    for (std::size_t k = 0; k < sizes.size(); ++k)
      nodes(static_cast<Eigen::Index>(k), j) = random.below(sizes[k]);
  }
  return nodes;
}

/// All outputs of a field at one node.
void values_at(const SeparatedField& field, Eigen::Ref<const Eigen::VectorXi> node, Eigen::VectorXd& products,
               Eigen::Ref<Eigen::VectorXd> values) {
  products.setOnes(field.rank());
  for (Eigen::Index k = 0; k < node.size(); ++k) {
    products.array() *= field.factors()[static_cast<std::size_t>(k)].row(node[k]).transpose().array();
  }
  values.noalias() = field.weights() * products;
}

/// One function of fields on its way from values to a field.
class Build {
 public:
  Build(const FieldReferences& fields, std::vector<OutputLabel> outputs, const PointFunction& function,
        const FunctionOptions& options)
      : fields_(fields),
        axes_(fields.front().get().axes()),
        sizes_(grid_of(axes_)),
        outputs_(std::move(outputs)),
        function_(function),
        options_(options),
        random_(options.seed),
        scale_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(outputs_.size()))) {
    for (const SeparatedField& field : fields) inputs_ += field.output_count();
    result_.grid_size = std::accumulate(sizes_.begin(), sizes_.end(), 1.0, std::multiplies<>());
  }

  FunctionResult run() {
    Eigen::MatrixXd values;
    evaluate(random_nodes(sizes_, options_.check_nodes, random_), values);
    if (!all_finite_) return std::move(result_);
    approximate();
    return std::move(result_);
  }

 private:
  /// Values of the function, outputs x nodes; keeps the largest of every output and the first bad node.
  void evaluate(const IndexBatch& nodes, Eigen::MatrixXd& values) {
    values.resize(scale_.size(), nodes.cols());
    Eigen::VectorXd input(inputs_);
    Eigen::VectorXd output(scale_.size());
    Eigen::VectorXd products;
    for (Eigen::Index j = 0; j < nodes.cols(); ++j) {
      Eigen::Index first = 0;
      for (const SeparatedField& field : fields_) {
        values_at(field, nodes.col(j), products, input.segment(first, field.output_count()));
        first += field.output_count();
      }
      output.setZero();
      function_(input, output);
      values.col(j) = output;
      if (output.allFinite()) {
        scale_ = scale_.cwiseMax(output.cwiseAbs());
      } else if (all_finite_) {
        refuse(std::vector<int>(nodes.col(j).begin(), nodes.col(j).end()), output);
      }
    }
    result_.evaluations += nodes.cols();
  }

  void refuse(const std::vector<int>& node, const Eigen::VectorXd& output) {
    all_finite_ = false;
    result_.status = FunctionStatus::not_finite;
    result_.point = coordinates(axes_, node);
    Eigen::Index m = 0;
    while (std::isfinite(output[m])) ++m;
    result_.message = fmt::format("{} is {} at {}", outputs_[static_cast<std::size_t>(m)].name, output[m],
                                  described(axes_, result_.point));
  }

  /// Train, sum, check; once more with a tighter sum if that is what the check missed by.
  void approximate() {
    const Eigen::VectorXd scale = (scale_.array() > 0.0).select(scale_, 1.0);
    const EntryFunction scaled = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      evaluate(entries, values);
      values = scale.cwiseInverse().asDiagonal() * values;
    };
    CrossOptions cross;
    cross.tolerance = 0.3 * options_.tolerance;
    cross.max_rank = options_.max_rank;
    cross.max_evaluations = options_.max_evaluations;
    cross.seed = options_.seed;
    const CrossResult train = interpolate(scaled, static_cast<int>(scale.size()), sizes_, cross);
    if (!all_finite_) return;
    const IndexBatch check = random_nodes(sizes_, options_.check_nodes, random_);
    Eigen::MatrixXd exact;
    evaluate(check, exact);
    if (!all_finite_) return;
    std::string sum_message;
    for (double share = 0.3; share > 1e-3; share *= 0.2) {
      // As a root mean square over the grid, the share of the tolerance; the largest error is checked.
      const double entries = result_.grid_size * static_cast<double>(scale.size());
      Separation sum =
          separate(train.train, share * options_.tolerance * std::sqrt(entries), options_.max_terms);
      // An output that is zero everywhere stays zero, whatever round-off the sum left there.
      const Eigen::VectorXd back = (scale_.array() > 0.0).select(scale, 0.0);
      sum.tensor.factors[0] = back.asDiagonal() * sum.tensor.factors[0];
      result_.field = field_from_nodal_values(axes_, outputs_, sum.tensor);
      result_.error = largest_error(check, exact);
      sum_message = sum.message;
      if (result_.error <= options_.tolerance || sum.status != SeparationStatus::met) break;
    }
    report(train, sum_message);
  }

  double largest_error(const IndexBatch& check, const Eigen::MatrixXd& exact) const {
    const Eigen::VectorXd scale = (scale_.array() > 0.0).select(scale_, 1.0);
    Eigen::VectorXd products;
    Eigen::VectorXd values(scale.size());
    double largest = 0.0;
    for (Eigen::Index j = 0; j < check.cols(); ++j) {
      values_at(*result_.field, check.col(j), products, values);
      largest = std::max(largest, (values - exact.col(j)).cwiseQuotient(scale).cwiseAbs().maxCoeff());
    }
    return largest;
  }

  void report(const CrossResult& train, const std::string& sum) {
    result_.tolerance_met = result_.error <= options_.tolerance;
    result_.status = result_.tolerance_met ? FunctionStatus::met : FunctionStatus::tolerance_missed;
    result_.message =
        fmt::format("error {:.3g} {} {:.3g} at {} check nodes; {} evaluations on a grid of {:.3g}",
                    result_.error, result_.tolerance_met ? "<=" : ">", options_.tolerance,
                    options_.check_nodes, result_.evaluations, result_.grid_size);
    if (!result_.tolerance_met) result_.message += fmt::format("; train: {}; sum: {}", train.message, sum);
  }

  const FieldReferences& fields_;
  const std::vector<Axis>& axes_;
  const std::vector<int> sizes_;
  const std::vector<OutputLabel> outputs_;
  const PointFunction& function_;
  const FunctionOptions& options_;
  Random random_;
  Eigen::Index inputs_ = 0;
  Eigen::VectorXd scale_;  ///< largest |value| per output
  bool all_finite_ = true;
  FunctionResult result_;
};

void validate(const FieldReferences& fields, const std::vector<OutputLabel>& outputs,
              const FunctionOptions& o) {
  if (fields.empty() || outputs.empty()) {
    throw ArgumentError(fmt::format("a function of {} fields with {} outputs, expected at least one of each",
                                    fields.size(), outputs.size()));
  }
  for (const SeparatedField& field : fields) {
    require_same_axes("function", fields.front().get().axes(), field.axes());
  }
  const auto require = [](bool holds, const char* field, double value) {
    if (!holds)
      throw ArgumentError(fmt::format("FunctionOptions::{} is {}, expected more than 0", field, value));
  };
  require(o.tolerance > 0.0, "tolerance", o.tolerance);
  require(o.check_nodes > 0, "check_nodes", o.check_nodes);
  require(o.max_rank > 0, "max_rank", o.max_rank);
  require(o.max_terms > 0, "max_terms", o.max_terms);
  require(o.max_evaluations > 0, "max_evaluations", static_cast<double>(o.max_evaluations));
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
  const std::vector<int> sizes = grid_of(field.axes());
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
  validate(fields, outputs, options);
  return Build(fields, std::move(outputs), function, options).run();
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
    result.status = FunctionStatus::sign_change;
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
  int changed = -1;  // the denominator that was not of its sign at a node visited
  const PointFunction divide = [&](const Eigen::VectorXd& x, Eigen::VectorXd& y) {
    for (int m = 0; m < p.count; ++m) {
      const int n = m * p.g_step;
      const double denominator = x[second + n];
      y[m] = x[m * p.f_step] / denominator;
      if (signs[n] * denominator > 0.0) continue;
      y[m] = std::numeric_limits<double>::quiet_NaN();
      changed = n;
    }
  };
  FunctionResult result = function_of({f, g}, std::move(outputs), divide, options);
  if (changed >= 0) return refuse(changed, result.point, std::move(result));
  return result;
}

}  // namespace samara::pgd
