#include "samara/codebooks/store.h"

#include <filesystem>
#include <fstream>
#include <vector>

#include <catch2/catch.hpp>
#include <unistd.h>

#include "coin_book.h"
#include "samara/base/errors.h"
#include "samara/io/hdf5_writer.h"

using namespace samara;
using Catch::Matchers::Contains;

namespace {

/// A path of this test's own, removed at its end.
struct TemporaryFile {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("samara_store_" + std::to_string(getpid()) + ".h5");
  ~TemporaryFile() { std::filesystem::remove(path); }
};

codebooks::Piece piece(double begin) {
  const pgd::Axis t = pgd::Axis::radau({"t", "s", pgd::AxisRole::time}, begin, begin + 1.0, 2, 3);
  const pgd::Axis q = pgd::Axis::p1({"q", "kg"}, Eigen::Vector3d(0.0, 0.3, 1.0));
  const Eigen::MatrixXd ft = Eigen::MatrixXd::Random(t.size(), 2);
  const Eigen::MatrixXd fq = Eigen::MatrixXd::Random(q.size(), 2);
  return {{pgd::SeparatedField({t, q}, {{"u", "m"}, {"w", "m/s"}}, {ft, fq}, Eigen::MatrixXd::Random(2, 2)),
           pgd::SeparatedField({t, q}, {{"z", "1"}}, {ft, fq}, Eigen::MatrixXd::Random(1, 2))}};
}

}  // namespace

TEST_CASE("a codebook comes back from its file to the last bit") {
  const TemporaryFile file;
  const codebooks::Codebook& book = test::coin_build().book;
  codebooks::save(book, file.path);
  const codebooks::Codebook back = codebooks::load(file.path);
  const auto& a = book.pieces().front().groups.front();
  const auto& b = back.pieces().front().groups.front();
  CHECK(a.weights() == b.weights());
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(a.factors()[k] == b.factors()[k]);
    CHECK(a.axes()[k].nodes() == b.axes()[k].nodes());
  }
  CHECK(back.model().fixed == book.model().fixed);
  CHECK(back.model().equations == book.model().equations);
  CHECK(back.build().message == book.build().message);
  CHECK(back.provenance().plan == test::coin_plan());
  REQUIRE(back.certificate());
  CHECK(back.certificate()->met == book.certificate()->met);
  CHECK(back.certificate()->max_error == book.certificate()->max_error);
  CHECK(back.certificate()->outputs[1].worst == book.certificate()->outputs[1].worst);
  CHECK(back.certificate()->outputs[0].name == "v");
}

TEST_CASE("several pieces and groups, and a codebook without certificate, are kept") {
  const TemporaryFile file;
  const codebooks::Codebook book({}, {piece(0.0), piece(1.0)});
  codebooks::save(book, file.path);
  const codebooks::Codebook back = codebooks::load(file.path);
  REQUIRE(back.pieces().size() == 2);
  REQUIRE(back.pieces()[1].groups.size() == 2);
  CHECK_FALSE(back.certificate());
  CHECK(back.outputs()[2].name == "z");
  CHECK(back.pieces()[1].groups[0].factors()[0] == book.pieces()[1].groups[0].factors()[0]);
  CHECK(back.coordinates()[0].upper == 2.0);
}

TEST_CASE("truncated files are refused, whatever their length") {
  const TemporaryFile file;
  codebooks::save(test::coin_build().book, file.path);
  std::ifstream in(file.path, std::ios::binary);
  const std::vector<char> whole((std::istreambuf_iterator<char>(in)), {});
  for (const double part : {0.0, 0.001, 0.1, 0.5, 0.9, 0.999}) {
    std::ofstream(file.path, std::ios::binary | std::ios::trunc)
        .write(whole.data(), static_cast<std::streamsize>(part * static_cast<double>(whole.size())));
    CAPTURE(part);
    CHECK_THROWS_AS(codebooks::load(file.path), InputError);
  }
}

TEST_CASE("files of other formats or versions are refused with what was expected") {
  const TemporaryFile file;
  const auto write = [&](const char* format, const char* version) {
    io::Hdf5Writer writer(file.path);
    writer.write_text_attribute("/", "format", format);
    writer.write_text_attribute("/", "format_version", version);
    writer.commit();
  };
  write("something", "0.1");
  CHECK_THROWS_WITH(codebooks::load(file.path), Contains("not a codebook"));
  for (const char* version : {"1.0", "0.2", "x", "0"}) {
    write("samara-codebook", version);
    CHECK_THROWS_WITH(codebooks::load(file.path), Contains("format_version") && Contains(version));
  }
  write("samara-codebook", "0.1");
  CHECK_THROWS_WITH(codebooks::load(file.path), Contains("/pieces"));
  CHECK_THROWS_AS(codebooks::load("no/such/book.h5"), InputError);
}

TEST_CASE("an axis that cannot be is refused by name") {
  const TemporaryFile file;
  const auto check = [&](const char* basis, std::vector<double> borders, int degree,
                         const Eigen::VectorXd& nodes) {
    io::Hdf5Writer writer(file.path);
    writer.write_text_attribute("/", "format", "samara-codebook");
    writer.write_text_attribute("/", "format_version", "0.1");
    const std::string path = "/pieces/0/axes/t";
    writer.write_vector(path, nodes);
    writer.write_text_attribute(path, "transform", "none");
    writer.write_text_attribute(path, "units", "s");
    writer.write_text_attribute(path, "role", "time");
    writer.write_text_attribute(path, "basis", basis);
    writer.write_integer_attribute(path, "index", 0);
    writer.write_integer_attribute(path, "degree", degree);
    writer.write_numbers_attribute(path, "borders", borders);
    writer.commit();
    CHECK_THROWS_AS(codebooks::load(file.path), InputError);
    CHECK_THROWS_WITH(codebooks::load(file.path), Contains("/pieces/0/axes/t"));
  };
  check("p1", {1.0, 0.0}, 1, Eigen::Vector2d(1.0, 0.0));
  check("chebyshev", {0.0, 1.0}, 3, Eigen::Vector2d(0.0, 1.0));
  check("chebyshev", {0.0, 1.0}, 2, Eigen::Vector3d(0.0, 0.4, 1.0));
  check("spline", {0.0, 1.0}, 1, Eigen::Vector2d(0.0, 1.0));
}
