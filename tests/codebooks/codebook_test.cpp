#include "samara/codebooks/book/codebook.h"

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "sample_books.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using samara::ArgumentError;
using samara::pgd::Axis;
using samara::pgd::AxisRole;
using samara::pgd::OutputLabel;
using samara::pgd::SeparatedField;

namespace {

const Axis kTime = Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 2, 2);
const Axis kParameter = Axis::chebyshev({"p", "m", AxisRole::parameter}, 0.0, 1.0, 3);

/// All ones, of rank one.
SeparatedField field(const std::vector<Axis>& axes, const std::vector<OutputLabel>& outputs = {{"x", "m"}}) {
  std::vector<Eigen::MatrixXd> factors;
  for (const Axis& axis : axes) factors.push_back(Eigen::MatrixXd::Ones(axis.size(), 1));
  return SeparatedField(axes, outputs, factors,
                        Eigen::MatrixXd::Ones(static_cast<Eigen::Index>(outputs.size()), 1));
}

std::string refusal(std::vector<Piece> pieces) {
  return error_text<ArgumentError>([&] { Codebook(sample_model(), std::move(pieces)); });
}

}  // namespace

TEST_CASE("the box of a codebook is the smallest around its pieces") {
  const Codebook book = four_pieces();
  REQUIRE(book.coordinate_count() == 3);
  CHECK(book.coordinates()[0].name == "t");
  CHECK(book.coordinates()[0].unit == "s");
  CHECK(book.coordinates()[0].role == AxisRole::time);
  CHECK(book.coordinates()[0].lower == 0.0);
  CHECK(book.coordinates()[0].upper == 0.5);
  CHECK(book.coordinates()[1].lower == 0.5);
  CHECK(book.coordinates()[1].upper == 2.0);
  CHECK(book.coordinates()[2].role == AxisRole::initial);
}

TEST_CASE("the outputs of a codebook are those of its groups, one after the other") {
  const Codebook book = four_pieces();
  REQUIRE(book.output_count() == 3);
  CHECK(book.outputs()[0].name == "x");
  CHECK(book.outputs()[1].name == "v");
  CHECK(book.outputs()[2].name == "E");
  CHECK(book.outputs()[2].unit == "J");
}

TEST_CASE("names are found, and unknown ones refused with the nearest") {
  const Codebook book = four_pieces();
  CHECK(book.coordinate_index("v(0)") == 2);
  CHECK(book.output_index("E") == 2);
  CHECK_THAT(error_text<ArgumentError>([&] { book.coordinate_index("C_L"); }),
             Contains("no coordinate \"C_L\"; did you mean \"C_D\"?"));
  CHECK_THAT(error_text<ArgumentError>([&] { book.output_index("energy"); }), Contains("known: x, v, E"));
}

TEST_CASE("pieces are kept in the order of their lower corners, however they are given") {
  std::vector<Piece> pieces = four_pieces().pieces();
  std::swap(pieces[0], pieces[3]);
  std::swap(pieces[1], pieces[2]);
  const Codebook book(sample_model(), pieces);
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& axes = book.pieces()[k].groups().front().axes();
    CHECK(axes[0].lower() == (k < 2 ? 0.0 : kSlabBorder));
    CHECK(axes[1].lower() == (k % 2 == 0 ? 0.5 : kCellBorder));
  }
}

TEST_CASE("another certificate leaves everything else as it is") {
  const Codebook book = golden_book();
  Certificate certificate = *book.certificate();
  certificate.met = false;
  const Codebook other = book.with_certificate(certificate);
  CHECK(book.certificate()->met);
  CHECK_FALSE(other.certificate()->met);
  CHECK(other.title() == book.title());
  CHECK(other.pieces()[1].groups()[0].sum()->weights() == book.pieces()[1].groups()[0].sum()->weights());
}

TEST_CASE("a codebook has pieces, a piece has groups") {
  CHECK_THAT(refusal({}), Contains("at least one piece"));
  CHECK_THAT(refusal({Piece{}}), Contains("no field group"));
  CHECK_THAT(refusal({Piece{{field({kTime, kParameter})}}, Piece{}}), Contains("no field group"));
}

TEST_CASE("time comes first") {
  CHECK_THAT(refusal({Piece{{field({kParameter, kTime})}}}),
             Contains("the first axis of a codebook is \"p\" with role parameter, expected time"));
}

TEST_CASE("the time of a codebook is made of elements") {
  const Axis listed = Axis::discrete({"t", "s", AxisRole::time}, Eigen::Vector2d(0.0, 1.0));
  CHECK_THAT(refusal({Piece{{field({listed, kParameter})}}}),
             Contains("the time axis of a codebook is discrete, expected one made of elements"));
}

TEST_CASE("pieces have the same coordinates: names, units, roles and order") {
  const Piece piece{{field({kTime, kParameter})}};
  const auto with = [&](const Axis::Label& label) {
    return refusal({piece, Piece{{field({kTime, Axis::chebyshev(label, 1.0, 2.0, 3)})}}});
  };
  CHECK(with({"p", "m", AxisRole::parameter}) == "no exception");
  CHECK_THAT(with({"q", "m", AxisRole::parameter}), Contains("the same coordinates"));
  CHECK_THAT(with({"p", "km", AxisRole::parameter}), Contains("the same coordinates"));
  CHECK_THAT(with({"p", "m", AxisRole::initial}), Contains("the same coordinates"));
  CHECK_THAT(refusal({piece, Piece{{field({kTime})}}}), Contains("the same coordinates"));
}

TEST_CASE("pieces have the same outputs, each once") {
  const std::vector<Axis> axes = {kTime, kParameter};
  const auto pieces = [&](const std::vector<OutputLabel>& a, const std::vector<OutputLabel>& b) {
    return refusal({Piece{{field(axes, a)}}, Piece{{field(axes, b)}}});
  };
  CHECK(pieces({{"x", "m"}, {"v", "m/s"}}, {{"x", "m"}, {"v", "m/s"}}) == "no exception");
  CHECK_THAT(pieces({{"x", "m"}, {"v", "m/s"}}, {{"v", "m/s"}, {"x", "m"}}), Contains("the same outputs"));
  CHECK_THAT(pieces({{"x", "m"}}, {{"x", "m"}, {"v", "m/s"}}), Contains("the same outputs"));
  CHECK_THAT(pieces({{"x", "m"}}, {{"x", "km"}}), Contains("the same outputs"));
  CHECK_THAT(refusal({Piece{{field(axes, {{"x", "m"}}), field(axes, {{"x", "m"}})}}}),
             Contains("two outputs \"x\""));
}

TEST_CASE("the groups of a piece share their axes") {
  const Axis finer = Axis::chebyshev({"p", "m", AxisRole::parameter}, 0.0, 1.0, 4);
  const Axis wider = Axis::chebyshev({"p", "m", AxisRole::parameter}, 0.0, 2.0, 3);
  const Axis elements = Axis::p1({"p", "m", AxisRole::parameter}, 0.0, 1.0, 3);
  const Axis::Label rooted{"p", "m", AxisRole::parameter, samara::pgd::Transform::square_root};
  for (const Axis& other : {finer, wider, elements, Axis::chebyshev(rooted, 0.0, 1.0, 3)}) {
    CHECK_THAT(refusal({Piece{{field({kTime, kParameter}), field({kTime, other}, {{"v", "m/s"}})}}}),
               Contains("must have the same axes"));
  }
}
