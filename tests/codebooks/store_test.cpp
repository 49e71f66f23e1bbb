#include <limits>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "same_codebook.h"
#include "sample_books.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using samara::ArgumentError;
using samara::pgd::Axis;
using samara::pgd::AxisRole;
using samara::pgd::SeparatedField;

namespace {

/// Through a file and back.
Codebook stored(const Codebook& book) {
  const TemporaryDirectory directory;
  save(book, directory / "book.h5");
  CHECK(directory.file_count() == 1);
  return load(directory / "book.h5");
}

Codebook one_piece(SeparatedField field) {
  return Codebook(sample_model(), {Piece{{std::move(field)}}}, sample_build(), sample_provenance());
}

}  // namespace

TEST_CASE("pieces, groups, axes of every kind and all texts survive a file to the last bit") {
  const Codebook bare(sample_model(), four_pieces().pieces(), sample_build(), sample_provenance(), {},
                      "\xC3\xA9tude no. 1");
  check_same_codebook(stored(bare), bare);
  const Codebook certified = bare.with_certificate(sample_certificate(bare));
  check_same_codebook(stored(certified), certified);
}

TEST_CASE("axes of every kind, with their transforms, survive a file to the last bit") {
  check_same_codebook(stored(all_kinds()), all_kinds());
}

TEST_CASE("a codebook over the nodes of a mesh survives a file, with mass matrix and cells") {
  const Codebook book = golden_mesh();
  const Codebook back = stored(book);
  check_same_codebook(back, book);
  const Axis &was = book.pieces()[0].groups()[0].axes()[0], &is = back.pieces()[0].groups()[0].axes()[0];
  CHECK(is.basis() == samara::pgd::Basis::imported);
  CHECK(same_bits(Eigen::MatrixXd(is.mass()), Eigen::MatrixXd(was.mass())));
  REQUIRE(back.mesh() != nullptr);
  CHECK(back.mesh()->directions() == book.mesh()->directions());
  CHECK(back.mesh()->unit() == "m");
  CHECK(same_bits(back.mesh()->points(), book.mesh()->points()));
  CHECK(back.mesh()->cells() == book.mesh()->cells());
}

TEST_CASE("a codebook survives any number of files") {
  const Codebook& book = coin_build().book;
  check_same_codebook(stored(book), book);
  check_same_codebook(stored(stored(book)), book);
}

TEST_CASE("the same codebook gives the same bytes") {
  const TemporaryDirectory directory;
  save(four_pieces(), directory / "a.h5");
  save(four_pieces(), directory / "b.h5");
  CHECK(content(directory / "a.h5") == content(directory / "b.h5"));
}

TEST_CASE("more pieces than digits come back in their order") {
  std::vector<Piece> pieces;
  for (unsigned k = 0; k < 12; ++k) pieces.push_back(random_piece({1.0 * k, 1.0 + k, 0.5, 1.0}, k, 2));
  const Codebook book(sample_model(), pieces);
  check_same_codebook(stored(book), book);
}

TEST_CASE("a codebook of time alone survives a file") {
  const Axis time = Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 3, 2);
  const Codebook book = one_piece(
      SeparatedField({time}, {{"x", "m"}}, {Eigen::MatrixXd::Random(7, 2)}, Eigen::MatrixXd::Random(1, 2)));
  check_same_codebook(stored(book), book);
}

TEST_CASE("a field without terms survives a file, and is zero") {
  const Axis time = Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 3, 2);
  const Axis parameter = Axis::p1({"p", "1", AxisRole::parameter}, 0.0, 1.0, 3);
  const Codebook book =
      one_piece(SeparatedField({time, parameter}, {{"x", "m"}},
                               {Eigen::MatrixXd(7, 0), Eigen::MatrixXd(3, 0)}, Eigen::MatrixXd(1, 0)));
  const Codebook back = stored(book);
  check_same_codebook(back, book);
  Eigen::VectorXd values(1);
  Query(back).values(std::vector{0.3, 0.4}, values);
  CHECK(values[0] == 0.0);
}

TEST_CASE("numbers at the ends of the range of doubles survive a file") {
  const Axis time = Axis::p1({"t", "s", AxisRole::time}, Eigen::Vector3d(-1e300, 5e-324, 1e300));
  const Axis parameter = Axis::p1({"p", "1", AxisRole::parameter}, Eigen::Vector2d(1.0, 1.0 + 0x1p-52));
  Eigen::MatrixXd weights(2, 2);
  weights << 1e308, -0.0, 5e-324, -1e-308;
  const Codebook book =
      one_piece(SeparatedField({time, parameter}, {{"x", "m"}, {"v", "m/s"}},
                               {Eigen::MatrixXd::Ones(3, 2), Eigen::MatrixXd::Ones(2, 2)}, weights));
  check_same_codebook(stored(book), book);
}

TEST_CASE("large axes and long texts survive a file") {
  // Beyond the 64 KiB that an attribute may have in old HDF5 files: borders of p1 axes and the plan are
  // attributes.
  const Axis time = Axis::p1({"t", "s", AxisRole::time}, 0.0, 1.0, 20001);
  Provenance provenance = sample_provenance();
  provenance.plan = "# " + std::string(200000, 'x') + "\n";
  const Codebook book(sample_model(),
                      {Piece{{SeparatedField({time}, {{"x", "m"}}, {Eigen::MatrixXd::Random(20001, 3)},
                                             Eigen::MatrixXd::Random(1, 3))}}},
                      sample_build(), provenance);
  check_same_codebook(stored(book), book);
}

TEST_CASE("a certificate without a usable point survives a file") {
  const Codebook bare = four_pieces();
  Certificate certificate;
  certificate.points = certificate.failed_points = 5;
  for (const auto& output : bare.outputs()) {
    certificate.outputs.emplace_back();
    certificate.outputs.back().name = output.name;
  }
  certificate.outputs[1].max = std::numeric_limits<double>::infinity();
  const Codebook book = bare.with_certificate(certificate);
  check_same_codebook(stored(book), book);
}

TEST_CASE("saving replaces an older file, and leaves it whole if the new one cannot be written") {
  const TemporaryDirectory directory;
  save(coin_build().book, directory / "book.h5");
  save(four_pieces(), directory / "book.h5");
  check_same_codebook(load(directory / "book.h5"), four_pieces());
  const std::string before = content(directory / "book.h5");
  ModelDescription model = sample_model();
  model.title = std::string("a zero byte: \0", 14);
  const Codebook unwritable(model, four_pieces().pieces());
  CHECK_THROWS_AS(save(unwritable, directory / "book.h5"), ArgumentError);
  CHECK(content(directory / "book.h5") == before);
  CHECK(directory.file_count() == 1);
}

TEST_CASE("a place where no file can be written is refused by name") {
  const TemporaryDirectory directory;
  CHECK_THAT(error_text<ArgumentError>([&] { save(four_pieces(), directory / "none/book.h5"); }),
             Contains("none/book.h5"));
  CHECK_THAT(error_text<ArgumentError>([&] { save(four_pieces(), directory.path()); }),
             Contains(directory.path().string()));
}
