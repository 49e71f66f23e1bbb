#include "samara/models/bodies/size_check.h"

#include <fmt/format.h>

#include "samara/base/require.h"

namespace samara::models {

void require_sizes(const Eigen::Vector3d& sizes, const char* what, const char* where) {
  for (int k = 0; k < 3; ++k) require_positive(sizes[k], fmt::format("{} {} [m]", what, "xyz"[k]), where);
}

}  // namespace samara::models
