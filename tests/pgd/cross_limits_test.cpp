#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/pgd/cross/cross_interpolation.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

TEST_CASE("cross interpolation refuses what it cannot work on") {
  const EntryFunction one = [](const IndexBatch&, Eigen::MatrixXd& values) { values.setOnes(); };
  const auto refused = [&](int outputs, const std::vector<int>& sizes, const CrossOptions& options,
                           const std::string& field) {
    CHECK_THROWS_WITH(interpolate(one, outputs, sizes, options), Contains(": " + field + " is "));
  };
  refused(0, {3, 3}, {}, "the number of outputs");
  refused(1, {}, {}, "the number of modes");
  refused(1, {3, 0}, {}, "the size of mode 1");
  refused(1, {3, 3}, {.tolerance = 0.0}, "tolerance");
  refused(1, {3, 3}, {.tolerance = std::numeric_limits<double>::quiet_NaN()}, "tolerance");
  refused(1, {3, 3}, {.max_rank = 0}, "max_rank");
  refused(1, {3, 3}, {.max_sweeps = 0}, "max_sweeps");
  refused(1, {3, 3}, {.guard_entries = 0}, "guard_entries");
}

TEST_CASE("grids up to 2^63 entries are interpolated and larger ones refused") {
  const EntryFunction product = [](const IndexBatch& entries, Eigen::MatrixXd& values) {
    values = (0.5 * entries.cast<double>().array()).exp().matrix().colwise().prod();
  };
  const CrossResult result = interpolate(product, 1, std::vector<int>(62, 2), {.tolerance = 1e-4});
  CHECK(result.status == samara::Termination::converged);
  CHECK(result.grid_size == 0x1.0p62);
  CHECK(result.evaluations < 10000);
  CHECK_THROWS_WITH(interpolate(product, 1, std::vector<int>(63, 2), {}), Contains("2^63"));
  CHECK_THROWS_WITH(interpolate(product, 1, std::vector<int>(8, 256), {}), Contains("2^63"));
}
