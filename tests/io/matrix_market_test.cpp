#include "samara/io/matrix_market.h"

#include <string>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "temporary_directory.h"

using samara::InputError;
using samara::io::parse_matrix_market;
using samara::io::read_matrix_market;

namespace {

constexpr const char* kGeneral = "%%MatrixMarket matrix coordinate real general\n";

std::string refusal(const std::string& text) {
  return error_text<InputError>([&] { parse_matrix_market(text, "m.mtx"); });
}

Eigen::MatrixXd dense(const std::string& text) {
  return parse_matrix_market(text, "m.mtx");
}

}  // namespace

TEST_CASE("a general matrix is read with comments, blank lines and any spacing") {
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(2, 3);
  expected(0, 0) = 1.5;
  expected(1, 2) = -2e-3;
  expected(0, 1) = 4.0;
  CHECK(dense(std::string(kGeneral) + "% a comment\n\n 2 3\t3\n1 1 1.5\n%another\n 2  3 -2e-3 \n1 2 +4") ==
        expected);
  CHECK(
      dense("%%matrixmarket MATRIX Coordinate Real General\r\n2 3 3\r\n1 1 1.5\r\n2 3 -2e-3\r\n1 2 4\r\n") ==
      expected);
}

TEST_CASE("a symmetric matrix is read with both triangles, whichever stands in the file") {
  Eigen::Matrix3d expected;
  expected << 2, 1, 0, 1, 2, -3, 0, -3, 4;
  CHECK(dense("%%MatrixMarket matrix coordinate integer symmetric\n3 3 5\n1 1 2\n2 1 1\n2 2 2\n3 2 -3\n3 3 "
              "4\n") == expected);
  CHECK(
      dense("%%MatrixMarket matrix coordinate real symmetric\n3 3 5\n1 1 2\n1 2 1\n2 2 2\n2 3 -3\n3 3 4\n") ==
      expected);
}

TEST_CASE("a matrix without entries, and one without rows, are matrices") {
  CHECK(dense(std::string(kGeneral) + "2 2 0\n") == Eigen::MatrixXd::Zero(2, 2));
  CHECK(dense(std::string(kGeneral) + "0 0 0\n").size() == 0);
}

TEST_CASE("the result is compressed and entries of zero are kept") {
  const Eigen::SparseMatrix<double> matrix =
      parse_matrix_market(std::string(kGeneral) + "2 2 2\n2 2 0\n1 1 3\n", "m.mtx");
  CHECK(matrix.isCompressed());
  CHECK(matrix.nonZeros() == 2);
}

TEST_CASE("a matrix is read from a file, and a missing one is named") {
  const TemporaryDirectory directory;
  put_content(directory / "mass.mtx", std::string(kGeneral) + "1 1 1\n1 1 0.25\n");
  CHECK(read_matrix_market(directory / "mass.mtx").coeff(0, 0) == 0.25);
  const std::string missing = (directory / "none.mtx").string();
  CHECK(error_text<InputError>([&] { read_matrix_market(missing); }) ==
        missing + ": the file does not exist");
}

TEST_CASE("a header that is missing or of another kind is refused at the first line") {
  CHECK(refusal("") ==
        "m.mtx: begins with \"\", expected \"%%MatrixMarket matrix coordinate FIELD SYMMETRY\"");
  CHECK(refusal("3 3 1\n1 1 1\n") ==
        "m.mtx:1: begins with \"3 3 1\", expected \"%%MatrixMarket matrix coordinate FIELD SYMMETRY\"");
  CHECK(refusal("%%MatrixMarket matrix array real general\n1 1\n2\n") ==
        "m.mtx:1: the format of the matrix is \"array\", expected coordinate");
  CHECK(refusal("%%MatrixMarket matrix coordinate complex general\n1 1 1\n1 1 2 3\n") ==
        "m.mtx:1: the field of the matrix is \"complex\", expected real or integer");
  CHECK(refusal("%%MatrixMarket matrix coordinate real hermitian\n1 1 1\n1 1 2\n") ==
        "m.mtx:1: the symmetry of the matrix is \"hermitian\", expected general or symmetric");
}

TEST_CASE("sizes that are missing, malformed or impossible are refused") {
  CHECK(refusal(kGeneral) == "m.mtx:1: ends before its sizes");
  CHECK(refusal(std::string(kGeneral) + "2 2\n") == "m.mtx:2: \"2 2\" is not ROWS COLUMNS ENTRIES");
  CHECK(refusal(std::string(kGeneral) + "2 x 1\n") ==
        "m.mtx:2: \"x\" stands where a whole number is expected");
  CHECK(refusal(std::string(kGeneral) + "-1 2 0\n") ==
        "m.mtx:2: \"-1 2 0\" are sizes of no matrix that can be held");
  CHECK(refusal(std::string(kGeneral) + "3000000000 2 0\n") ==
        "m.mtx:2: \"3000000000 2 0\" are sizes of no matrix that can be held");
  CHECK(refusal(std::string(kGeneral) + "99999999999999999999 2 0\n") ==
        "m.mtx:2: \"99999999999999999999\" stands where a whole number is expected");
  CHECK(refusal("%%MatrixMarket matrix coordinate real symmetric\n2 3 0\n") ==
        "m.mtx:2: the matrix is symmetric with 2 rows and 3 columns, expected a square one");
}

TEST_CASE("an entry that is malformed, outside or not finite is refused at its line") {
  const auto entry = [](const std::string& line) {
    return refusal(std::string(kGeneral) + "% comment\n2 3 1\n" + line + "\n");
  };
  CHECK(entry("3 1 1") == "m.mtx:4: the row is 3, expected 1 to 2");
  CHECK(entry("0 1 1") == "m.mtx:4: the row is 0, expected 1 to 2");
  CHECK(entry("1 4 1") == "m.mtx:4: the column is 4, expected 1 to 3");
  CHECK(entry("1 1") == "m.mtx:4: \"1 1\" is not ROW COLUMN VALUE");
  CHECK(entry("1 1 1 1") == "m.mtx:4: \"1 1 1 1\" is not ROW COLUMN VALUE");
  CHECK(entry("1 1.5 1") == "m.mtx:4: \"1.5\" stands where a whole number is expected");
  CHECK(entry("1 1 1,5") == "m.mtx:4: \"1,5\" stands where a number is expected");
  CHECK(entry("1 1 nan") == "m.mtx:4: the value \"nan\" is not a finite number");
  CHECK(entry("1 1 -inf") == "m.mtx:4: the value \"-inf\" is not a finite number");
  CHECK(entry("1 1 1e999") == "m.mtx:4: the value \"1e999\" is not a finite number");
  CHECK(refusal("%%MatrixMarket matrix coordinate integer general\n1 1 1\n1 1 1.5\n") ==
        "m.mtx:3: \"1.5\" stands where a whole number is expected");
}

TEST_CASE("too few and too many entries are refused") {
  CHECK(refusal(std::string(kGeneral) + "2 2 3\n1 1 1\n2 2 1\n") == "m.mtx:4: ends after 2 of 3 entries");
  CHECK(refusal(std::string(kGeneral) + "2 2 1\n1 1 1\n2 2 1\n") ==
        "m.mtx:4: is one entry more than the 1 announced");
  CHECK(refusal(std::string(kGeneral) + "2 2 2000000000\n") ==
        "m.mtx:2: \"2 2 2000000000\" are sizes of no matrix that can be held");
}

TEST_CASE("an entry that stands twice is refused with both lines") {
  CHECK(refusal(std::string(kGeneral) + "2 2 3\n1 1 1\n2 2 1\n1 1 5\n") ==
        "m.mtx:5: the entry stands a second time; the first time on line 3");
  CHECK(refusal("%%MatrixMarket matrix coordinate real symmetric\n2 2 2\n2 1 1\n1 2 1\n") ==
        "m.mtx:4: the entry stands a second time; the first time on line 3");
}
