#include "samara/pgd/axes/axis_checks.h"

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"

namespace samara::pgd {

std::string axis_text(const AxisLabel& label) {
  return fmt::format("axis \"{}\"", label.name);
}

void check_increasing(const AxisLabel& label, const Eigen::VectorXd& values, int least) {
  require(values.size() >= least, "the number of nodes", values.size(), fmt::format("at least {}", least),
          axis_text(label));
  if (!values.allFinite())
    throw ArgumentError(fmt::format("axis \"{}\" has a node that is not finite", label.name));
  for (Eigen::Index i = 1; i < values.size(); ++i) {
    if (!(values[i] > values[i - 1])) {
      throw ArgumentError(fmt::format("axis \"{}\" goes from {} to {}, expected increasing values",
                                      label.name, values[i - 1], values[i]));
    }
  }
}

void check_no_transform(const AxisLabel& label, const char* kind) {
  if (label.transform == Transform::none) return;
  throw ArgumentError(fmt::format("axis \"{}\" has the transform \"{}\", which a {} axis cannot have",
                                  label.name, to_string(label.transform), kind));
}

}  // namespace samara::pgd
