#include "samara/codebooks/file/flat_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "../io/temporary_directory.h"
#include "flat_answers.h"
#include "sample_books.h"

using namespace samara::codebooks;

namespace {

/// Sums of terms of one size, each a product of a few factors, in another order than the library's; derivatives of a
/// polynomial of degree n lose n^2 eps.
constexpr double kRoundOff = 2e-12;

/// Borders of pieces on a coordinate and, where it is no list of values, the doubles beside them, as far as they are in
/// the box.
std::vector<double> piece_borders(const Codebook& book, std::size_t k) {
  const Coordinate& c = book.coordinates()[k];
  std::set<double> found;
  for (const Piece& piece : book.pieces()) {
    const bool is_list = !piece.groups().front().axes()[k].has_elements();
    for (const double border : {piece.lower()[k], piece.upper()[k]}) {
      found.insert(border);
      if (!is_list) found.insert({std::nextafter(border, -INFINITY), std::nextafter(border, INFINITY)});
    }
  }
  std::erase_if(found, [&](double x) { return x < c.lower || x > c.upper; });
  return {found.begin(), found.end()};
}

/// Random points of the box, all its corners, points that differ from them in one coordinate which lies on a border
/// of pieces or of elements, and in two coordinates on or beside borders of pieces, where up to four of these meet.
Eigen::MatrixXd telling_points(const Codebook& book) {
  const Eigen::MatrixXd random = random_points(book, 200, 5);
  std::vector<Eigen::VectorXd> points;
  for (Eigen::Index j = 0; j < random.cols(); ++j) points.emplace_back(random.col(j));
  const auto d = static_cast<std::size_t>(book.coordinate_count());
  for (std::size_t corner = 0; corner < std::size_t{1} << d; ++corner) {
    Eigen::VectorXd x(static_cast<Eigen::Index>(d));
    for (std::size_t k = 0; k < d; ++k)
      x[static_cast<Eigen::Index>(k)] =
          (corner >> k) % 2 == 0 ? book.coordinates()[k].lower : book.coordinates()[k].upper;
    points.push_back(x);
  }
  Eigen::Index next = 0;
  for (const Piece& piece : book.pieces()) {
    for (const samara::pgd::Axis& axis : piece.groups().front().axes()) {
      const auto k = static_cast<Eigen::Index>(book.coordinate_index(axis.name()));
      const Eigen::VectorXd& places = axis.has_elements() ? axis.borders() : axis.nodes();
      for (const double place : places) {
        points.emplace_back(random.col(next++ % random.cols()));
        points.back()[k] = place;
      }
    }
  }
  for (std::size_t k = 0; k < d; ++k) {
    for (std::size_t l = 0; l < k; ++l) {
      for (const double at_k : piece_borders(book, k)) {
        for (const double at_l : piece_borders(book, l)) {
          points.emplace_back(random.col(next++ % random.cols()));
          points.back()[static_cast<Eigen::Index>(k)] = at_k;
          points.back()[static_cast<Eigen::Index>(l)] = at_l;
        }
      }
    }
  }
  Eigen::MatrixXd all(static_cast<Eigen::Index>(d), std::ssize(points));
  for (std::size_t j = 0; j < points.size(); ++j) all.col(static_cast<Eigen::Index>(j)) = points[j];
  return all;
}

/// The largest of samara_eval.h however it is compiled.
double difference_of(const Codebook& book) {
  const Eigen::MatrixXd points = telling_points(book);
  Query query(book);
  double largest = 0.0;
  for (const FlatEval* const eval : {&FlatAnswers::kLinked, &kFlatEvalPlain, &kFlatEvalOneMachine}) {
    FlatAnswers flat(book, *eval);
    largest = std::max(largest, flat.largest_difference(query, points));
  }
  return largest;
}

/// Why bytes are refused; empty where they are not.
std::string complaint_of(const std::string& bytes) {
  samara_eval* book = nullptr;
  const char* why = "";
  const samara_eval_status status = samara_eval_open_memory(bytes.data(), bytes.size(), &book, &why);
  if (status == SAMARA_EVAL_DONE) {
    samara_eval_close(book);
    return "";
  }
  CHECK(status == SAMARA_EVAL_BAD_FILE);
  CHECK(book == nullptr);
  return why;
}

}  // namespace

TEST_CASE("a flat file answers as the library, in pieces, on their borders and in corners") {
  CHECK(difference_of(four_pieces()) < kRoundOff);
  CHECK(difference_of(four_pieces_of_trains()) < kRoundOff);
  CHECK(difference_of(golden_book()) < kRoundOff);
  CHECK(difference_of(golden_trains()) < kRoundOff);
}

TEST_CASE("a flat file answers as the library on all bases and under all transforms") {
  CHECK(difference_of(all_kinds()) < kRoundOff);
  CHECK(difference_of(Codebook(all_kinds().model(), {as_trains(all_kinds().pieces().front())})) < kRoundOff);
}

TEST_CASE("a flat file answers as the library without time, over the nodes of a mesh, and at any rank") {
  CHECK(difference_of(golden_command()) < kRoundOff);
  CHECK(difference_of(golden_mesh()) < kRoundOff);
  for (const int rank : {1, 7, 33}) {
    CAPTURE(rank);
    CHECK(difference_of(Codebook(sample_model(), {random_piece({0.0, 1.0, 0.5, 1.0}, 1, rank)})) < kRoundOff);
    CHECK(difference_of(Codebook(sample_model(), {random_train_piece({0.0, 1.0, 0.5, 1.0}, 1, rank)})) <
          kRoundOff);
  }
}

TEST_CASE(
    "elements of more nodes than products of differences allow are interpolated by the library's other "
    "formula") {
  using samara::pgd::Axis;
  const std::vector<Axis> axes = {Axis::legendre({"t", "s", samara::pgd::AxisRole::time}, 0.0, 2.0, 90),
                                  Axis::chebyshev({"k"}, 0.5, 4.0, 120)};
  std::vector<Eigen::MatrixXd> factors;
  for (const Axis& axis : axes) factors.emplace_back((3.0 * axis.nodes().array()).sin().matrix());
  const samara::pgd::SeparatedField field(axes, {{"u", "m"}}, factors, Eigen::MatrixXd::Ones(1, 1));
  // Derivatives of polynomials of degree 120 lose their squared degree.
  CHECK(difference_of(Codebook(sample_model(), {Piece{{field}}})) < 1e-10);
}

TEST_CASE("a sum without terms is zero in a flat file") {
  using samara::pgd::Axis;
  const std::vector<Axis> axes = {Axis::p1({"t", "s", samara::pgd::AxisRole::time}, 0.0, 1.0, 3)};
  const samara::pgd::SeparatedField none(axes, {{"u", "m"}}, {Eigen::MatrixXd(3, 0)}, Eigen::MatrixXd(1, 0));
  FlatAnswers flat(Codebook(sample_model(), {Piece{{none}}}));
  const double x = 0.4;
  double value = 1.0, slope = 1.0;
  REQUIRE(flat.at(&x, &value, &slope) == SAMARA_EVAL_DONE);
  CHECK(value == 0.0);
  CHECK(slope == 0.0);
}

TEST_CASE("a flat file tells what it holds, and how far that is from the truth") {
  const Codebook book = golden_book();
  const FlatAnswers flat(book);
  REQUIRE(samara_eval_coordinate_count(flat.book()) == book.coordinate_count());
  REQUIRE(samara_eval_output_count(flat.book()) == book.output_count());
  for (int k = 0; k < book.coordinate_count(); ++k) {
    const Coordinate& c = book.coordinates()[static_cast<std::size_t>(k)];
    double lower = 0.0, upper = 0.0;
    CHECK(samara_eval_coordinate_name(flat.book(), k) == c.name);
    CHECK(samara_eval_coordinate_unit(flat.book(), k) == c.unit);
    REQUIRE(samara_eval_bounds(flat.book(), k, &lower, &upper) == SAMARA_EVAL_DONE);
    CHECK(lower == c.lower);
    CHECK(upper == c.upper);
  }
  const samara_eval_certificate certificate = samara_eval_certificate_of(flat.book());
  REQUIRE(certificate.exists == 1);
  CHECK(certificate.met == (book.certificate()->met ? 1 : 0));
  CHECK(certificate.tolerance == book.certificate()->tolerance);
  CHECK(certificate.max_error == book.certificate()->max_error);
  CHECK(certificate.points == book.certificate()->points);
  for (int o = 0; o < book.output_count(); ++o) {
    double relative = 0.0, si = 0.0;
    CHECK(samara_eval_output_name(flat.book(), o) == book.outputs()[static_cast<std::size_t>(o)].name);
    CHECK(samara_eval_output_unit(flat.book(), o) == book.outputs()[static_cast<std::size_t>(o)].unit);
    REQUIRE(samara_eval_output_error(flat.book(), o, &relative, &si) == SAMARA_EVAL_DONE);
    CHECK(relative == book.certificate()->outputs[static_cast<std::size_t>(o)].max);
    CHECK(si == book.certificate()->outputs[static_cast<std::size_t>(o)].max_si);
  }
  CHECK(samara_eval_model(flat.book()) == book.model().name);
  CHECK(samara_eval_title(flat.book()) == book.title());
  REQUIRE(samara_eval_fixed_count(flat.book()) == std::ssize(book.model().fixed));
  int place = 0;
  for (const auto& [name, value] : book.model().fixed) {
    CHECK(samara_eval_fixed_name(flat.book(), place) == name);
    CHECK(samara_eval_fixed_unit(flat.book(), place) == book.model().fixed_units.at(name));
    CHECK(samara_eval_fixed_value(flat.book(), place++) == value);
  }
  CHECK(samara_eval_coordinate_name(flat.book(), book.coordinate_count()) == std::string());
  CHECK(samara_eval_output_unit(flat.book(), -1) == std::string());
  CHECK(samara_eval_model(nullptr) == std::string());
  CHECK(std::isnan(samara_eval_fixed_value(flat.book(), place)));
  const samara_eval_certificate none = samara_eval_certificate_of(FlatAnswers(four_pieces()).book());
  CHECK(none.exists == 0);
  CHECK(std::isnan(none.max_error));
}

TEST_CASE(
    "a flat file refuses points outside its box, between the values of a list, and those that are none") {
  const Codebook book = all_kinds();
  FlatAnswers flat(book);
  const Eigen::MatrixXd points = random_points(book, 1, 3);
  std::vector<double> values(static_cast<std::size_t>(book.output_count()), 7.0);
  Eigen::VectorXd x = points.col(0);
  const auto plies = book.coordinate_index("plies");
  CHECK(flat.at(x.data(), values.data(), nullptr) == SAMARA_EVAL_DONE);
  CHECK(samara_eval_outside(flat.book(), x.data()) == -1);
  values.assign(values.size(), 7.0);
  x[plies] = 3.0;  // of 1, 2, 4
  CHECK(flat.at(x.data(), values.data(), nullptr) == SAMARA_EVAL_OUTSIDE);
  CHECK(samara_eval_outside(flat.book(), x.data()) == -1);
  x[plies] = std::numeric_limits<double>::quiet_NaN();
  CHECK(flat.at(x.data(), values.data(), nullptr) == SAMARA_EVAL_WRONG_CALL);
  x[plies] = 5.0;
  CHECK(flat.at(x.data(), values.data(), nullptr) == SAMARA_EVAL_OUTSIDE);
  CHECK(samara_eval_outside(flat.book(), x.data()) == plies);
  CHECK(values == std::vector<double>(values.size(), 7.0));
  CHECK(flat.at(nullptr, values.data(), nullptr) == SAMARA_EVAL_WRONG_CALL);
  CHECK(flat.at(x.data(), nullptr, nullptr) == SAMARA_EVAL_WRONG_CALL);
}

TEST_CASE("a flat file that is cut off, or has one byte that is another, is refused") {
  const std::string bytes = format_flat(golden_command());
  REQUIRE(complaint_of(bytes).empty());
  for (std::size_t size = 0; size < bytes.size(); size += size < 400 ? 1 : 64)
    CHECK_FALSE(complaint_of(bytes.substr(0, size)).empty());
  CHECK_FALSE(complaint_of(bytes + std::string(8, '\0')).empty());
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string other = bytes;
    other[at] = static_cast<char>(other[at] ^ (1 << at % 8));
    if (complaint_of(other).empty()) FAIL("byte " << at << " may be another");
  }
}

TEST_CASE("a flat file says which version, byte order or kind of file it is not") {
  const std::string bytes = format_flat(golden_command());
  const auto with = [&](std::size_t at, char byte) {
    std::string other = bytes;
    other[at] = byte;
    return complaint_of(other);
  };
  CHECK_THAT(with(0, 'X'), Catch::Contains("not a flat codebook"));
  CHECK_THAT(with(8, 1), Catch::Contains("byte order"));
  CHECK_THAT(with(12, 2), Catch::Contains("version"));
  CHECK_THAT(with(bytes.size() - 9, 'X'), Catch::Contains("checksum"));
  CHECK_THAT(complaint_of("samara"), Catch::Contains("flat codebook"));
}

TEST_CASE("a flat file is read from disk as from memory, and one that is missing is refused") {
  const TemporaryDirectory directory;
  const std::string path = (directory / "book.flat").string();
  save_flat(four_pieces(), path);
  samara_eval* book = nullptr;
  const char* why = "?";
  REQUIRE(samara_eval_open(path.c_str(), &book, &why) == SAMARA_EVAL_DONE);
  CHECK(std::strlen(why) == 0);
  CHECK(samara_eval_output_count(book) == 3);
  samara_eval_close(book);
  CHECK(samara_eval_open((path + "s").c_str(), &book, &why) == SAMARA_EVAL_BAD_FILE);
  CHECK(book == nullptr);
  CHECK_THAT(why, Catch::Contains("cannot be opened"));
  CHECK(samara_eval_open(nullptr, &book, nullptr) == SAMARA_EVAL_WRONG_CALL);
  samara_eval_close(nullptr);
}
