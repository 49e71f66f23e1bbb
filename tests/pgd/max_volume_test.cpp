#include "samara/pgd/cross/max_volume.h"

#include <cmath>
#include <set>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/pgd/tensors/random.h"

using namespace samara::pgd;

namespace {

/// Waves between random points in three dimensions: of full rank, with singular values that fall fast.
Eigen::MatrixXd waves(int rows, int columns, std::uint64_t seed) {
  Random random(seed);
  const auto points = [&](int count) {
    return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(3, count, [&] { return random.uniform(); }));
  };
  const Eigen::MatrixXd x = points(rows), y = points(columns);
  return (6.0 * x.transpose() * y).array().cos().matrix();
}

double error_of(const MaxVolume& volume, const Eigen::MatrixXd& matrix) {
  return (matrix - volume.coefficients * matrix(volume.rows, Eigen::all)).cwiseAbs().maxCoeff();
}

std::size_t groups_in(const MaxVolume& volume, const std::vector<int>& groups) {
  std::set<int> found;
  for (const int row : volume.rows) found.insert(groups[static_cast<std::size_t>(row)]);
  return found.size();
}

}  // namespace

TEST_CASE("rows of nearly the largest volume interpolate all others, by coefficients within the bound") {
  for (const auto& [rows, columns] : {std::pair{400, 150}, {37, 90}, {900, 16}, {5, 1}}) {
    const Eigen::MatrixXd matrix = waves(rows, columns, 3);
    for (const double negligible : {1e-3, 1e-8}) {
      const MaxVolume volume = max_volume(matrix, 1000, negligible);
      CAPTURE(rows, columns, negligible, volume.rows.size());
      CHECK(volume.rows.size() <= static_cast<std::size_t>(std::min(rows, columns)));
      CHECK(volume.coefficients.cwiseAbs().maxCoeff() <= 1.05);
      // What is left out is below `negligible` after elimination; interpolation adds it up over the rows.
      CHECK(error_of(volume, matrix) <= 1.05 * static_cast<double>(volume.rows.size() + 1) * negligible);
      const Eigen::MatrixXd own = volume.coefficients(volume.rows, Eigen::all);
      CHECK((own - Eigen::MatrixXd::Identity(own.rows(), own.cols())).cwiseAbs().maxCoeff() < 1e-9);
    }
  }
}

TEST_CASE("a matrix of low rank takes as many rows as its rank, and a zero one takes one") {
  const Eigen::MatrixXd low = waves(300, 23, 1) * waves(23, 200, 2);
  const MaxVolume volume = max_volume(low, 1000, 1e-9);
  CHECK(volume.rows.size() <= 23);
  CHECK(error_of(volume, low) < 1e-6);
  CHECK(max_volume(low, 7, 1e-9).rows.size() == 7);
  CHECK(max_volume(Eigen::MatrixXd::Zero(20, 10), 5, 1e-9).rows.size() == 1);
}

TEST_CASE("rows come from few groups where these span the others, and the error stays within the bound") {
  const int count = 40, each = 25;
  const Eigen::MatrixXd matrix = waves(count * each, 120, 5);
  std::vector<int> groups(static_cast<std::size_t>(count) * each);
  for (std::size_t i = 0; i < groups.size(); ++i) groups[i] = static_cast<int>(i) / each;
  const double negligible = 1e-6;
  const MaxVolume all = max_volume(matrix, 1000, negligible),
                  few = max_volume(matrix, 1000, negligible, groups);
  CAPTURE(all.rows.size(), few.rows.size());
  CHECK(2 * groups_in(few, groups) < groups_in(all, groups));
  CHECK(few.coefficients.cwiseAbs().maxCoeff() <= 4.0 * 1.05);
  CHECK(error_of(few, matrix) <= 4.0 * 1.05 * static_cast<double>(few.rows.size() + 1) * negligible);
}
