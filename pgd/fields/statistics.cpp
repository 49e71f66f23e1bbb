#include "samara/pgd/fields/statistics.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/unit_labels.h"
#include "samara/pgd/fields/field_check.h"
#include "samara/pgd/fields/variance_chain.h"
#include "samara/pgd/tensors/train_algebra.h"

namespace samara::pgd {

namespace {

/// What is asked for, as indices into the inputs.
struct Request {
  int free_axis = -1;
  std::vector<int> inputs;                 ///< axes, in order
  std::vector<std::vector<bool>> subsets;  ///< flags per input: each input alone, then the further subsets
};

std::vector<bool> subset_flags(const std::vector<Axis>& axes, const Request& request,
                               const std::vector<std::string>& names) {
  if (names.empty()) throw ArgumentError("a subset of inputs is empty, expected at least one axis");
  std::vector<bool> flags(request.inputs.size(), false);
  for (const std::string& name : names) {
    const int axis = axis_index(axes, name);
    const auto it = std::find(request.inputs.begin(), request.inputs.end(), axis);
    if (it == request.inputs.end()) {
      throw ArgumentError(fmt::format("a subset of inputs holds \"{}\", which is the free axis", name));
    }
    const auto k = static_cast<std::size_t>(it - request.inputs.begin());
    if (flags[k]) throw ArgumentError(fmt::format("a subset of inputs holds \"{}\" twice", name));
    flags[k] = true;
  }
  return flags;
}

Request read(const std::vector<Axis>& axes, const StatisticsOptions& options) {
  Request request;
  if (!options.free_axis.empty()) request.free_axis = axis_index(axes, options.free_axis);
  for (int k = 0; k < static_cast<int>(axes.size()); ++k) {
    if (k != request.free_axis) request.inputs.push_back(k);
  }
  if (request.inputs.empty()) {
    throw ArgumentError(
        fmt::format("\"{}\" is free and the only axis, expected at least one input", options.free_axis));
  }
  for (std::size_t k = 0; k < request.inputs.size(); ++k) {
    request.subsets.emplace_back(request.inputs.size(), false);
    request.subsets.back()[k] = true;
  }
  for (const auto& names : options.subsets) request.subsets.push_back(subset_flags(axes, request, names));
  return request;
}

void require_distribution(const Axis& axis, const QuadratureRule& rule) {
  const auto refuse = [&](const std::string& what) {
    throw ArgumentError(fmt::format("the distribution of \"{}\" has {}", axis.name(), what));
  };
  if (rule.nodes.size() != rule.weights.size())
    refuse(fmt::format("{} nodes and {} weights, expected one weight a node", rule.nodes.size(),
                       rule.weights.size()));
  for (Eigen::Index i = 0; i < rule.nodes.size(); ++i) {
    if (!(rule.weights[i] >= 0.0))
      refuse(fmt::format("the weight {}, expected none below 0", rule.weights[i]));
    if (!axis.contains(rule.nodes[i]))
      refuse(fmt::format("the node {}, expected one from {} to {}{}", rule.nodes[i], axis.lower(),
                         axis.upper(), unit_suffix(axis.unit())));
  }
  constexpr double kRoundOff = 1e-9;
  if (!(std::abs(rule.weights.sum() - 1.0) <= kRoundOff))
    refuse(fmt::format("weights that sum to {}, expected 1", rule.weights.sum()));
}

std::vector<InputMeasure> measures(const std::vector<Axis>& axes, const StatisticsOptions& options,
                                   const Request& request) {
  for (const auto& [name, rule] : options.distributions) {
    const int axis = axis_index(axes, name);
    if (axis == request.free_axis)
      throw ArgumentError(fmt::format("\"{}\" is the free axis, which has no distribution", name));
    require_distribution(axes[static_cast<std::size_t>(axis)], rule);
  }
  std::vector<InputMeasure> inputs;
  for (const int k : request.inputs) {
    const Axis& axis = axes[static_cast<std::size_t>(k)];
    const auto given = options.distributions.find(axis.name());
    inputs.push_back(given == options.distributions.end() ? InputMeasure(axis)
                                                          : InputMeasure(axis, given->second));
  }
  return inputs;
}

/// The result with names, and matrices of the right size.
Statistics prepare(const std::vector<Axis>& axes, const StatisticsOptions& options, const Request& request,
                   int outputs) {
  Statistics s;
  Eigen::Index columns = 1;
  if (request.free_axis >= 0) {
    s.free_nodes = axes[static_cast<std::size_t>(request.free_axis)].nodes();
    columns = s.free_nodes.size();
  }
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(outputs, columns);
  s.mean = s.variance = zero;
  s.constant = Eigen::MatrixXi::Zero(outputs, columns);
  for (const int k : request.inputs) s.inputs.push_back(axes[static_cast<std::size_t>(k)].name());
  s.first_order.assign(request.inputs.size(), zero);
  s.total.assign(request.inputs.size(), zero);
  for (const auto& names : options.subsets) s.subsets.push_back({names, zero, zero, zero});
  return s;
}

/// Enters the moments of one output at one node of the free axis.
void enter(const Moments& moments, Eigen::Index m, Eigen::Index i, Statistics& s) {
  s.mean(m, i) = moments.mean;
  if (moments.variance <= moments.round_off * moments.round_off) {
    s.constant(m, i) = 1;
    return;
  }
  s.variance(m, i) = moments.variance;
  const std::size_t inputs = s.inputs.size();
  for (std::size_t a = 0; a < moments.parts.size(); ++a) {
    const VarianceParts& part = moments.parts[a];
    if (a < inputs) {
      s.first_order[a](m, i) = part.closed / moments.variance;
      s.total[a](m, i) = part.total / moments.variance;
    } else {
      SubsetIndices& subset = s.subsets[a - inputs];
      subset.closed(m, i) = part.closed / moments.variance;
      subset.total(m, i) = part.total / moments.variance;
      subset.interaction(m, i) = part.interaction / moments.variance;
    }
  }
}

/// Cores of the inputs, nodal values, for one output at one free node.
std::vector<TrainCore> row_train(const TensorTrain& values, const Request& request, Eigen::Index output,
                                 Eigen::Index node) {
  TensorTrain row = values;
  if (request.free_axis >= 0) row = restricted(row, request.free_axis + 1, static_cast<int>(node));
  return restricted(row, 0, static_cast<int>(output)).cores;
}

}  // namespace

Statistics statistics(const SeparatedField& field, const StatisticsOptions& options) {
  const std::vector<Axis>& axes = field.axes();
  const Request request = read(axes, options);
  Statistics s = prepare(axes, options, request, field.output_count());
  const std::vector<InputMeasure> inputs = measures(axes, options, request);
  std::vector<Eigen::MatrixXd> factors;
  for (const int k : request.inputs) factors.push_back(field.factors()[static_cast<std::size_t>(k)]);
  // One row of weights for every output and free node.
  Eigen::MatrixXd rows(s.mean.size(), field.rank());
  for (Eigen::Index i = 0; i < s.mean.cols(); ++i) {
    auto block = rows.middleRows(i * s.mean.rows(), s.mean.rows());
    block = field.weights();
    if (request.free_axis >= 0) {
      block.array().rowwise() *= field.factors()[static_cast<std::size_t>(request.free_axis)].row(i).array();
    }
  }
  const std::vector<Moments> moments = sum_moments(inputs, factors, rows, request.subsets);
  for (Eigen::Index i = 0; i < s.mean.cols(); ++i) {
    for (Eigen::Index m = 0; m < s.mean.rows(); ++m) {
      enter(moments[static_cast<std::size_t>(i * s.mean.rows() + m)], m, i, s);
    }
  }
  return s;
}

Statistics statistics(const TrainField& field, const StatisticsOptions& options) {
  const std::vector<Axis>& axes = field.axes();
  const TensorTrain& values = field.train();
  const Request request = read(axes, options);
  Statistics s = prepare(axes, options, request, field.output_count());
  const std::vector<InputMeasure> inputs = measures(axes, options, request);
  for (Eigen::Index i = 0; i < s.mean.cols(); ++i) {
    for (Eigen::Index m = 0; m < s.mean.rows(); ++m) {
      enter(train_moments(inputs, row_train(values, request, m, i), request.subsets), m, i, s);
    }
  }
  return s;
}

Statistics statistics(const Field& field, const StatisticsOptions& options) {
  return field.train() != nullptr ? statistics(*field.train(), options) : statistics(*field.sum(), options);
}

}  // namespace samara::pgd
