#include "samara/pgd/cross/nodal_approximation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/base/require.h"
#include "samara/base/unit_labels.h"
#include "samara/pgd/fields/field_algebra.h"
#include "samara/pgd/tensors/separation.h"

namespace samara::pgd {

std::vector<int> sizes_of(const std::vector<Axis>& axes) {
  std::vector<int> sizes;
  for (const Axis& axis : axes) sizes.push_back(axis.size());
  return sizes;
}

std::vector<double> coordinates(const std::vector<Axis>& axes, const std::vector<int>& node) {
  std::vector<double> x;
  for (std::size_t k = 0; k < axes.size(); ++k) x.push_back(axes[k].nodes()[node[k]]);
  return x;
}

Eigen::MatrixXd coordinates_at(const std::vector<Axis>& axes, const IndexBatch& nodes) {
  Eigen::MatrixXd x(nodes.rows(), nodes.cols());
  for (Eigen::Index k = 0; k < x.rows(); ++k)
    x.row(k) = axes[static_cast<std::size_t>(k)].nodes()(nodes.row(k)).transpose();
  return x;
}

Eigen::MatrixXd corner_points(const std::vector<Axis>& axes, std::size_t most_axes) {
  const auto d = static_cast<Eigen::Index>(axes.size());
  Eigen::MatrixXd points(d, axes.size() > most_axes ? 0 : Eigen::Index{1} << d);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    for (Eigen::Index k = 0; k < d; ++k) {
      const Axis& axis = axes[static_cast<std::size_t>(k)];
      points(k, j) = (j >> k) & 1 ? axis.upper() : axis.lower();
    }
  }
  return points;
}

Eigen::MatrixXd random_points(const std::vector<Axis>& axes, int count, Random& random) {
  Eigen::MatrixXd points(static_cast<Eigen::Index>(axes.size()), count);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    for (Eigen::Index k = 0; k < points.rows(); ++k) {
      const Axis& axis = axes[static_cast<std::size_t>(k)];
      points(k, j) = axis.lower() + random.uniform() * axis.length();
    }
  }
  return points;
}

std::string described(const std::vector<Axis>& axes, const std::vector<double>& x) {
  std::string text;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    text +=
        fmt::format("{}{} = {:.6g}{}", k == 0 ? "" : ", ", axes[k].name(), x[k], unit_suffix(axes[k].unit()));
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

void values_at(const SeparatedField& field, Eigen::Ref<const Eigen::VectorXi> node, Eigen::VectorXd& products,
               Eigen::Ref<Eigen::VectorXd> values) {
  products.setOnes(field.rank());
  for (Eigen::Index k = 0; k < node.size(); ++k) {
    products.array() *= field.factors()[static_cast<std::size_t>(k)].row(node[k]).transpose().array();
  }
  values.noalias() = field.weights() * products;
}

namespace {

constexpr int kCheckNodes = 500;  // random ones, for scales before and for the error afterwards

/// One function on its way from values to a field.
class Build {
 public:
  Build(const std::vector<Axis>& axes, std::vector<OutputLabel> outputs, const NodeFunction& function,
        const FunctionOptions& options)
      : axes_(axes),
        sizes_(sizes_of(axes_)),
        outputs_(std::move(outputs)),
        function_(function),
        options_(options),
        random_(options.seed),
        scale_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(outputs_.size()))) {
    result_.grid_size = std::accumulate(sizes_.begin(), sizes_.end(), 1.0, std::multiplies<>());
  }

  FunctionResult run() {
    Eigen::MatrixXd values;
    evaluate(random_nodes(sizes_, kCheckNodes, random_), values);
    if (!all_finite_) return std::move(result_);
    approximate();
    return std::move(result_);
  }

 private:
  /// Values of the function, outputs x nodes; keeps the largest of every output and the first bad node.
  void evaluate(const IndexBatch& nodes, Eigen::MatrixXd& values) {
    values.resize(scale_.size(), nodes.cols());
    Eigen::VectorXd output(scale_.size());
    for (Eigen::Index j = 0; j < nodes.cols(); ++j) {
      output.setZero();
      function_(nodes.col(j), output);
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
    result_.status = Termination::not_finite;
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
    const IndexBatch check = random_nodes(sizes_, kCheckNodes, random_);
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
      if (result_.error <= options_.tolerance || sum.status != Termination::converged) break;
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
    result_.status = result_.tolerance_met ? Termination::converged : Termination::missed;
    result_.message =
        fmt::format("error {:.3g} {} {:.3g} at {} check nodes; {} evaluations on a grid of {:.3g}",
                    result_.error, result_.tolerance_met ? "<=" : ">", options_.tolerance, kCheckNodes,
                    result_.evaluations, result_.grid_size);
    if (!result_.tolerance_met) result_.message += fmt::format("; train: {}; sum: {}", train.message, sum);
  }

  const std::vector<Axis>& axes_;
  const std::vector<int> sizes_;
  const std::vector<OutputLabel> outputs_;
  const NodeFunction& function_;
  const FunctionOptions& options_;
  Random random_;
  Eigen::VectorXd scale_;  ///< largest |value| per output
  bool all_finite_ = true;
  FunctionResult result_;
};

void validate(const FunctionOptions& o) {
  constexpr std::string_view kWhere = "function of fields";
  require(o.tolerance > 0.0, "tolerance", o.tolerance, "more than 0", kWhere);
  require(o.max_rank > 0, "max_rank", o.max_rank, "at least 1", kWhere);
  require(o.max_terms > 0, "max_terms", o.max_terms, "at least 1", kWhere);
  require(o.max_evaluations > 0, "max_evaluations", o.max_evaluations, "at least 1", kWhere);
}

}  // namespace

FunctionResult approximate_nodal(const std::vector<Axis>& axes, std::vector<OutputLabel> outputs,
                                 const NodeFunction& function, const FunctionOptions& options) {
  validate(options);
  return Build(axes, std::move(outputs), function, options).run();
}

}  // namespace samara::pgd
