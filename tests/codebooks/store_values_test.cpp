#include <limits>

#include "damaged_codebook.h"

// Files whose parts are all there, but hold what cannot be.

using namespace damaged_codebook;
using Catch::Matchers::Contains;

TEST_CASE("a dataset of the wrong size is named with both sizes") {
  const std::string group = "/pieces/0/groups/0";
  const auto resized = [](const std::string& path, const std::vector<hsize_t>& size) {
    hsize_t count = 1;
    for (const hsize_t n : size) count *= n;
    return error_after(
        [&](Patient& file) { file.set_dataset(path, size, numbers(static_cast<int>(count))); });
  };
  CHECK_THAT(resized(group + "/weights", {3, kRank}),
             Contains(group + "/weights") && Contains("expected 2 rows, found the size 3 x 5"));
  CHECK_THAT(resized(group + "/weights", {2, kRank - 1}),
             Contains(group + "/factors/t") && Contains("expected 4 columns, found the size 9 x 5"));
  CHECK_THAT(resized(group + "/weights", {2 * kRank}),
             Contains(group + "/weights") && Contains("2 dimensions"));
  CHECK_THAT(resized(group + "/factors/C_D", {kParameterNodes + 1, kRank}),
             Contains(group + "/factors/C_D") && Contains("expected 7 rows, found the size 8 x 5"));
  CHECK_THAT(resized(group + "/factors/C_D", {kParameterNodes, kRank, 1}), Contains(group + "/factors/C_D"));
  CHECK_THAT(resized("/pieces/0/axes/v(0)", {2, 2}),
             Contains("/pieces/0/axes/v(0)") && Contains("1 dimension"));
  CHECK_THAT(resized("/pieces/0/axes/v(0)", {3}),
             Contains("/pieces/0/axes/v(0): 3 nodes do not fit 4 borders and degree 1"));
  CHECK_THAT(resized("/model/fixed/g", {2}), Contains("/model/fixed/g") && Contains("expected 1 rows"));
  CHECK_THAT(error_after([&](Patient& file) { file.set_numbers("/pieces/0/axes/t", "borders", {}); }),
             Contains("/pieces/0/axes/t: 9 nodes do not fit 0 borders"));
}

TEST_CASE("an axis that does not ascend is refused") {
  CHECK_THAT(
      error_after([](Patient& file) {
        file.set_dataset("/pieces/0/axes/v(0)", {kInitialNodes}, {0.6, 0.05, -0.1, -0.3});
        file.set_numbers("/pieces/0/axes/v(0)", "borders", {0.6, 0.05, -0.1, -0.3});
      }),
      Contains("/pieces/0/axes/v(0): axis \"v(0)\" goes from 0.6 to 0.05, expected increasing values"));
  CHECK_THAT(error_after([](Patient& file) {
               file.set_numbers("/pieces/0/axes/C_D", "borders", {1.0, 0.5});
             }),
             Contains("/pieces/0/axes/C_D: ") && Contains("expected increasing values"));
}

TEST_CASE("nodes that do not belong to the basis are refused") {
  // Borders moved, nodes left; nodes moved, borders left; another basis for the same nodes.
  CHECK_THAT(error_after([](Patient& file) {
               file.set_numbers("/pieces/0/axes/C_D", "borders", {0.5, 1.01});
             }),
             Contains("/pieces/0/axes/C_D: the nodes are not those of a chebyshev axis"));
  CHECK_THAT(error_after([](Patient& file) {
               file.set_dataset("/pieces/0/axes/v(0)", {kInitialNodes}, {-0.3, -0.1, 0.06, 0.6});
             }),
             Contains("/pieces/0/axes/v(0): the nodes are not those of a p1 axis"));
  CHECK_THAT(error_after([](Patient& file) { file.set_text("/pieces/0/axes/C_D", "basis", "radau"); }),
             Contains("/pieces/0/axes/C_D: the nodes are not those of a radau axis"));
  CHECK_THAT(error_after([](Patient& file) { file.set_text("/pieces/0/axes/t", "basis", "chebyshev"); }),
             Contains("/pieces/0/axes/t: the nodes are not those of a chebyshev axis"));
  CHECK_THAT(error_after([](Patient& file) { file.set_text("/pieces/0/axes/t", "basis", "p1"); }),
             Contains("/pieces/0/axes/t: the nodes are not those of a p1 axis"));
}

TEST_CASE("a degree that cannot be is refused before memory is taken for it") {
  for (const long long degree : {0LL, -1LL, 3LL, 4097LL, 1LL << 31, std::numeric_limits<long long>::max(),
                                 std::numeric_limits<long long>::min()}) {
    CHECK_THAT(error_after([&](Patient& file) { file.set_integer("/pieces/0/axes/t", "degree", degree); }),
               Contains("/pieces/0/axes/t: ") && Contains("degree"));
  }
  // A polynomial through a hundred thousand nodes.
  constexpr int kMany = 100001;
  CHECK_THAT(error_after([&](Patient& file) {
               file.set_dataset("/pieces/0/axes/C_D", {kMany}, numbers(kMany));
               file.set_integer("/pieces/0/axes/C_D", "degree", kMany - 1);
             }),
             Contains("/pieces/0/axes/C_D: degree is 100000, expected at most"));
}

TEST_CASE("numbers that are not finite are refused") {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (const std::string path : {"/pieces/0/groups/0/weights", "/pieces/0/groups/0/factors/v(0)"}) {
      const int rows = path.ends_with("weights") ? 2 : kInitialNodes;
      std::vector<double> values = numbers(rows * kRank);
      values[6] = bad;
      CHECK_THAT(error_after([&](Patient& file) {
                   file.set_dataset(path, {static_cast<hsize_t>(rows), kRank}, values);
                 }),
                 Contains(path) && Contains("expected finite numbers") && Contains("as element 6"));
    }
    CHECK_THAT(error_after([&](Patient& file) {
                 file.set_dataset("/pieces/0/axes/v(0)", {kInitialNodes}, {-0.3, bad, 0.05, 0.6});
               }),
               Contains("/pieces/0/axes/v(0)") && Contains("expected finite numbers"));
    CHECK_THAT(error_after([&](Patient& file) {
                 file.set_numbers("/pieces/0/axes/v(0)", "borders", {-0.3, bad, 0.05, 0.6});
               }),
               Contains("/pieces/0/axes/v(0)"));
    CHECK_THAT(error_after([&](Patient& file) { file.set_dataset("/model/fixed/g", {1}, {bad}); }),
               Contains("/model/fixed/g") && Contains("expected finite numbers"));
  }
}

TEST_CASE("a basis, role, transform or kind that this version does not know is refused by name") {
  const auto with = [](const std::string& name, const std::string& value) {
    return error_after([&](Patient& file) { file.set_text("/pieces/0/axes/t", name, value); });
  };
  CHECK_THAT(with("basis", "spline"), Contains("/pieces/0/axes/t: basis is \"spline\"") && Contains("radau"));
  CHECK_THAT(with("basis", "imported"), Contains("/pieces/0/mass/t/values"));
  CHECK_THAT(with("role", "tine"), Contains("/pieces/0/axes/t: role is \"tine\"; did you mean \"time\"?"));
  CHECK_THAT(with("transform", "lock"),
             Contains("/pieces/0/axes/t: transform is \"lock\"; did you mean \"log\"?"));
  CHECK_THAT(with("transform", "log"),
             Contains("/pieces/0/axes/t: axis \"t\" begins at 0 with the transform"));
  CHECK_THAT(error_after([](Patient& file) { file.set_text("/pieces/0/groups/0", "kind", "tree"); }),
             Contains("/pieces/0/groups/0: kind is \"tree\", expected \"sum_of_products\" or \"train\""));
}

TEST_CASE("the stated ends of axes and pieces must be those of the borders") {
  for (const std::string name : {"lower", "upper"}) {
    CHECK_THAT(error_after([&](Patient& file) { file.set_numbers("/pieces/0/axes/C_D", name, {0.7}); }),
               Contains("/pieces/0/axes/C_D: attribute " + name + " is not where the axes"));
    CHECK_THAT(error_after([&](Patient& file) {
                 file.set_numbers("/pieces/0", name, {0.0, 0.5, -0.2});
               }),
               Contains("/pieces/0: attribute " + name + " is not where the axes"));
    CHECK_THAT(error_after([&](Patient& file) {
                 file.set_numbers("/pieces/0", name, {0.0, 0.5});
               }),
               Contains("/pieces/0: attribute " + name));
    CHECK_THAT(error_after([&](Patient& file) { file.remove_attribute("/pieces/0", name); }),
               Contains("/pieces/0") && Contains("missing"));
  }
}

TEST_CASE("attributes that are not known, and objects beside the known ones, are ignored") {
  CHECK(error_after([](Patient& file) {
          file.create_group("/notes");
          file.set_text("/notes", "author", "somebody");
          file.set_text("/", "doi", "10.1");
          file.set_text("/pieces/0/axes/t", "long_name", "time");
          file.set_integer("/certificate", "lucky", 7);
          file.create_group("/pieces/0/figures");
        }) == "no exception");
}

TEST_CASE("axes are numbered 0, 1, 2 without gap or repetition") {
  for (const long long index : {1LL, 3LL, -1LL, std::numeric_limits<long long>::min()}) {
    CHECK_THAT(error_after([&](Patient& file) { file.set_integer("/pieces/0/axes/t", "index", index); }),
               Contains("/pieces/0/axes/t: index is taken or not below 3") || Contains("index"));
  }
}

TEST_CASE("what makes no codebook as a whole is an input error of the file") {
  CHECK_THAT(error_after([](Patient& file) { file.set_text("/pieces/0/axes/t", "role", "parameter"); }),
             Contains("/: ") && Contains("expected time"));
  CHECK_THAT(error_after([](Patient& file) { file.set_text("/pieces/1/axes/t", "units", "min"); }),
             Contains("/: pieces of a codebook must have the same coordinates"));
  CHECK_THAT(error_after([](Patient& file) { file.remove("/pieces/2/groups/1"); }),
             Contains("/: pieces of a codebook must have the same outputs"));
  // Names that the reader would take for a way out of the group.
  CHECK_THAT(error_after([](Patient& file) { file.rename("/pieces/0/axes/t", "/pieces/0/axes/.."); }),
             !Contains("exception"));
}
