#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/tensors/separated_tensor.h"

namespace samara::pgd {

struct SeparateOptions {
  /// Of the nodal values, relative to the largest; part of the problem's error budget.
  double tolerance = 1e-8;
  int max_rank = 100;
  std::uint64_t seed = 1;
};

struct SeparatedFunction {
  SeparatedTensor tensor;      ///< nodal values over the axes
  double error = 0.0;          ///< largest difference at random nodes, relative to the largest value
  bool tolerance_met = false;  ///< at 500 random nodes; a peak that none of them sees stays unseen
  long evaluations = 0;        ///< nodes where f was evaluated, checks included
  double grid_size = 0.0;
  std::string message = {};  ///< why the tolerance is missed
};

/// A function of several coordinates as a sum of products of functions of one: what a coefficient or source
/// that does not factor (not affine) needs before it can stand in a separated operator. By cross
/// interpolation of the nodal values, which visits few of them, and compression.
/// @param f takes one coordinate per axis
/// @throws ArgumentError if there is no axis, an option is out of range, or f is not finite at a node that
/// was asked for.
SeparatedFunction separate(const std::function<double(std::span<const double>)>& f,
                           const std::vector<Axis>& axes, const SeparateOptions& options = {});

}  // namespace samara::pgd
