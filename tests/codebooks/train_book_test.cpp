#include <limits>

#include "damaged_codebook.h"
#include "samara/codebooks/query/query.h"

// Codebooks whose groups are trains: the same answers, kept to the last bit, and damage that is named.

using namespace damaged_codebook;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string kCores = "/pieces/0/groups/0/cores";

std::string train_error_after(const std::function<void(Patient&)>& damage) {
  return error_after(damage, four_pieces_of_trains());
}

std::string error_of_core(const std::string& core, const std::vector<hsize_t>& size) {
  hsize_t count = 1;
  for (const hsize_t n : size) count *= n;
  return train_error_after(
      [&](Patient& file) { file.set_dataset(kCores + core, size, numbers(static_cast<int>(count))); });
}

}  // namespace

TEST_CASE("a train answers as the sum of products that it was made from, with its derivatives") {
  const Codebook sums = four_pieces();
  const Codebook trains = four_pieces_of_trains();
  Query sum(sums), train(trains);
  Eigen::VectorXd expected(3), values(3), alone(3);
  Eigen::MatrixXd expected_gradient(3, 3), gradient(3, 3);
  const Eigen::MatrixXd points = random_points(sums, 300, 5);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    sum.values(point(points, j), expected, expected_gradient);
    train.values(point(points, j), values, gradient);
    train.values(point(points, j), alone);
    CHECK(values == alone);
    // Values up to 10 and derivatives up to 1000, by products of matrices made by QR: some 100 eps of them.
    CHECK((values - expected).cwiseAbs().maxCoeff() < 1e-13 * 10.0);
    CHECK((gradient - expected_gradient).cwiseAbs().maxCoeff() < 1e-13 * 1000.0);
  }
}

TEST_CASE("a train survives a file to the last bit, beside sums") {
  const TemporaryDirectory directory;
  const Codebook book = golden_trains();
  save(book, directory / "a.h5");
  const Codebook back = load(directory / "a.h5");
  check_same_codebook(back, book);
  save(back, directory / "b.h5");
  CHECK(content(directory / "a.h5") == content(directory / "b.h5"));
  save(four_pieces_of_trains(), directory / "c.h5");
  check_same_codebook(load(directory / "c.h5"), four_pieces_of_trains());
}

TEST_CASE("cores that do not fit each other, their axis or the outputs are named with their sizes") {
  CHECK(train_error_after([](Patient&) {}) == "no exception");
  // Outputs x and v, t with 9 nodes, C_D with 7, v(0) with 4; ranks 2, 5, 5.
  CHECK_THAT(error_of_core("/0", {1, 3, 2}),
             StartsWith(kCores + "/0: has the size 1 x 3 x 2, expected 1 x 2 x a rank"));
  CHECK_THAT(error_of_core("/0", {2, 2, 2}), StartsWith(kCores + "/0: has the size 2 x 2 x 2"));
  CHECK_THAT(error_of_core("/1", {3, 9, 5}),
             StartsWith(kCores + "/1: has the size 3 x 9 x 5, expected 2 x 9 x a rank"));
  CHECK_THAT(error_of_core("/1", {2, 8, 5}), StartsWith(kCores + "/1: has the size 2 x 8 x 5"));
  CHECK_THAT(error_of_core("/1", {2, 9, 0}), StartsWith(kCores + "/1"));
  CHECK_THAT(error_of_core("/1", {2, 45}), Contains(kCores + "/1") && Contains("3 dimensions"));
  CHECK_THAT(error_of_core("/3", {5, 4, 2}), StartsWith(kCores + "/3: ends with the rank 2, expected 1"));
}

TEST_CASE("a core that is missing, or one too many, is named") {
  CHECK_THAT(train_error_after([](Patient& file) { file.remove(kCores); }), Contains(kCores));
  CHECK_THAT(train_error_after([](Patient& file) { file.remove(kCores + "/1"); }),
             StartsWith(kCores + ": member 1 of 3 is missing"));
  CHECK_THAT(train_error_after([](Patient& file) { file.remove(kCores + "/3"); }),
             StartsWith(kCores + ": has 3 cores, expected 4"));
  CHECK_THAT(train_error_after([](Patient& file) { file.copy(kCores + "/3", kCores + "/4"); }),
             StartsWith(kCores + ": has 5 cores, expected 4"));
  CHECK_THAT(train_error_after(
                 [](Patient& file) { file.set_text("/pieces/0/groups/0", "kind", "sum_of_products"); }),
             Contains("/pieces/0/groups/0/weights"));
}

TEST_CASE("a core with numbers that are not finite is refused") {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    CHECK_THAT(train_error_after([&](Patient& file) {
                 std::vector<double> values = numbers(4);
                 values[2] = bad;
                 file.set_dataset(kCores + "/0", {1, 2, 2}, values);
               }),
               Contains(kCores + "/0") && Contains("expected finite numbers"));
  }
}
