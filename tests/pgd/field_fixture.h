#pragma once

#include <string>
#include <vector>

#include "random_tensor.h"
#include "samara/pgd/axes/axis.h"
#include "samara/pgd/fields/field_algebra.h"
#include "samara/pgd/fields/separated_field.h"

/// Axes of three kinds and units, and random fields on them.
inline std::vector<samara::pgd::Axis> mixed_axes() {
  using samara::pgd::Axis;
  return {Axis::radau({"t", "s", samara::pgd::AxisRole::time}, 0.0, 2.0, 2, 3),
          Axis::chebyshev({"C_D"}, 0.5, 2.0, 5), Axis::p1({"x", "m"}, -0.3, 0.6, 4)};
}

inline samara::pgd::SeparatedField random_mixed_field(int outputs, int rank, std::uint64_t seed) {
  const std::vector<samara::pgd::Axis> axes = mixed_axes();
  std::vector<int> sizes = {outputs};
  for (const samara::pgd::Axis& axis : axes) sizes.push_back(axis.size());
  std::vector<samara::pgd::OutputLabel> labels;
  for (int m = 0; m < outputs; ++m) labels.push_back({std::string(1, static_cast<char>('u' + m)), "m/s"});
  return samara::pgd::field_from_nodal_values(axes, labels, random_tensor(sizes, rank, seed));
}

inline std::vector<double> random_point(const std::vector<samara::pgd::Axis>& axes,
                                        samara::pgd::Random& random) {
  std::vector<double> x;
  for (const samara::pgd::Axis& axis : axes) x.push_back(axis.lower() + axis.length() * random.uniform());
  return x;
}
