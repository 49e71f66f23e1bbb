#include "samara/pgd/separate_function.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/cross_interpolation.h"
#include "samara/pgd/random.h"
#include "samara/pgd/separation.h"
#include "samara/pgd/tensor_train.h"

namespace samara::pgd {

namespace {

/// The function on the nodes of the axes.
class NodalFunction {
 public:
  NodalFunction(const std::function<double(std::span<const double>)>& f, const std::vector<Axis>& axes)
      : f_(f), axes_(axes), x_(axes.size()) {}

  double operator()(const auto& index) {
    for (std::size_t k = 0; k < axes_.size(); ++k)
      x_[k] = axes_[k].nodes()[index[static_cast<Eigen::Index>(k)]];
    return f_(x_);
  }
  std::string point(const std::vector<int>& index) const {
    std::string text;
    for (std::size_t k = 0; k < axes_.size(); ++k)
      text += fmt::format("{}{} = {}", k == 0 ? "" : ", ", axes_[k].name(), axes_[k].nodes()[index[k]]);
    return text;
  }

 private:
  const std::function<double(std::span<const double>)>& f_;
  const std::vector<Axis>& axes_;
  std::vector<double> x_;
};

/// The first mode of a train, of size one, taken into the second.
TensorTrain without_first_mode(TensorTrain train) {
  TrainCore merged(1, train.cores[1].size, train.cores[1].right);
  merged.right_unfolding() = train.cores[0].left_unfolding() * train.cores[1].right_unfolding();
  train.cores[1] = std::move(merged);
  train.cores.erase(train.cores.begin());
  return train;
}

ArgumentError not_finite(const NodalFunction& function, const std::vector<int>& index) {
  return ArgumentError(fmt::format("the function to separate is not finite at {}", function.point(index)));
}

double largest_difference(const SeparatedTensor& tensor, NodalFunction& function, std::uint64_t seed) {
  constexpr int kPoints = 500;
  Random random(seed);
  double largest = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    Eigen::VectorXi index(tensor.modes());
    for (int k = 0; k < tensor.modes(); ++k) index[k] = random.below(tensor.size(k));
    const std::vector<int> entry(index.begin(), index.end());
    const double value = function(index);
    if (!std::isfinite(value)) throw not_finite(function, entry);
    largest = std::max(largest, std::abs(tensor.entry(entry) - value));
  }
  return largest;
}

}  // namespace

SeparatedFunction separate(const std::function<double(std::span<const double>)>& f,
                           const std::vector<Axis>& axes, const SeparateOptions& options) {
  if (axes.empty()) throw ArgumentError("a function of no axes cannot be separated");
  if (!(options.tolerance > 0.0)) {
    throw ArgumentError(
        fmt::format("SeparateOptions::tolerance is {}, expected more than 0", options.tolerance));
  }
  std::vector<int> sizes;
  double nodes = 1.0;
  for (const Axis& axis : axes) {
    sizes.push_back(axis.size());
    nodes *= axis.size();
  }
  NodalFunction function(f, axes);
  const EntryFunction entries = [&](const IndexBatch& batch, Eigen::MatrixXd& values) {
    for (Eigen::Index j = 0; j < batch.cols(); ++j) values(0, j) = function(batch.col(j));
  };
  // The cross interpolation takes an absolute tolerance: the size of f comes from a rough one.
  CrossOptions cross{.tolerance = 1e300, .max_rank = 1, .seed = options.seed};
  const double size = interpolate(entries, 1, sizes, cross).largest;
  cross.tolerance = 0.3 * options.tolerance * std::max(size, 1e-300);
  cross.max_rank = options.max_rank;
  const CrossResult found = interpolate(entries, 1, sizes, cross);
  if (found.status == CrossStatus::not_finite) throw not_finite(function, found.bad_entry);
  SeparatedFunction result;
  result.evaluations = found.evaluations;
  result.grid_size = found.grid_size;
  // Root mean square per node against the largest value; the check below is on the largest difference.
  const double budget = 0.1 * options.tolerance * found.largest * std::sqrt(nodes);
  result.tensor = separate(without_first_mode(found.train), budget).tensor;
  result.error = found.largest > 0.0
                     ? largest_difference(result.tensor, function, options.seed + 1) / found.largest
                     : 0.0;
  result.tolerance_met = found.status == CrossStatus::converged && result.error <= options.tolerance;
  if (!result.tolerance_met) {
    result.message =
        fmt::format("the separated function differs by {:.3g} of its largest value, {:.3g} was asked for: {}",
                    result.error, options.tolerance, found.message);
  }
  return result;
}

}  // namespace samara::pgd
