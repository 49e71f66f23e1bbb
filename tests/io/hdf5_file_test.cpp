#include <cmath>
#include <csignal>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <thread>

#include <catch2/catch.hpp>
#include <sys/resource.h>

#include "../error_text.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/hdf5_writer.h"
#include "temporary_directory.h"

using Catch::Matchers::Contains;
using samara::ArgumentError;
using samara::InputError;
using samara::io::Hdf5Reader;
using samara::io::Hdf5Writer;

namespace {

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

/// Writes a file with `fill` and opens it.
template <typename Fill>
Hdf5Reader written(const TemporaryDirectory& directory, const Fill& fill) {
  Hdf5Writer writer(directory / "f.h5");
  fill(writer);
  writer.commit();
  return Hdf5Reader(directory / "f.h5");
}

template <typename Call>
std::string input_error(const Call& call) {
  return error_text<InputError>(call);
}

template <typename Call>
std::string argument_error(const Call& call) {
  return error_text<ArgumentError>(call);
}

}  // namespace

TEST_CASE("a file is known by the bytes of its mark, also where it is cut") {
  const TemporaryDirectory directory;
  Hdf5Writer writer(directory / "f.h5");
  writer.write_text_attribute("/", "format", "samara-marked");
  writer.write_matrix("/m", random_matrix(100, 100));
  writer.commit();
  CHECK(samara::io::is_hdf5_with(directory / "f.h5", "samara-marked"));
  CHECK_FALSE(samara::io::is_hdf5_with(directory / "f.h5", "samara-other"));
  std::filesystem::resize_file(directory / "f.h5", 3000);
  CHECK(samara::io::is_hdf5_with(directory / "f.h5", "samara-marked"));
  // Wherever it stands; a text is no HDF5 file, whatever it says.
  const std::string begin = content(directory / "f.h5").substr(0, 8);
  const std::size_t part = std::size_t{1} << 20;
  for (const std::size_t place : {part - 15, part - 8, part - 1, part, 2 * part - 5}) {
    const std::string padding(place, '.');
    CHECK(samara::io::is_hdf5_with(directory.put("far.h5", begin + padding + "samara-marked"),
                                   "samara-marked"));
    CHECK_FALSE(
        samara::io::is_hdf5_with(directory.put("far.h5", padding + "samara-marked"), "samara-marked"));
  }
  CHECK_FALSE(samara::io::is_hdf5_with(directory.put("empty", ""), "samara-marked"));
  CHECK_FALSE(samara::io::is_hdf5_with(directory / "missing", "samara-marked"));
}

TEST_CASE("numbers written to HDF5 read back with the same bits, whatever the size") {
  const TemporaryDirectory directory;
  for (const auto& [rows, columns] :
       {std::pair{1, 1}, {3, 5}, {300, 700}, {2, 70000}, {70000, 2}, {0, 3}, {3, 0}}) {
    INFO(rows << " x " << columns);
    const Eigen::MatrixXd matrix = random_matrix(rows, columns);
    const Eigen::VectorXd vector = random_matrix(rows, 1);
    const Hdf5Reader file = written(directory, [&](Hdf5Writer& writer) {
      writer.write_matrix("/deep/er/m", matrix);
      writer.write_vector("v", vector);
    });
    CHECK(file.matrix("/deep/er/m", {.rows = rows, .columns = columns}) == matrix);
    CHECK(file.vector("/v", {.rows = rows}) == vector);
    CHECK(file.shape("deep/er/m") == std::vector<Eigen::Index>{rows, columns});
  }
}

TEST_CASE("a matrix that packs as well as any is not taken for one too large for its file") {
  const TemporaryDirectory directory;
  const Eigen::MatrixXd zeros = Eigen::MatrixXd::Zero(2000, 2000);
  const Hdf5Reader file = written(directory, [&](Hdf5Writer& writer) { writer.write_matrix("/m", zeros); });
  CHECK(file.matrix("/m") == zeros);
}

TEST_CASE("a part of a matrix is written as it looks, not as it lies in memory") {
  const TemporaryDirectory directory;
  const Eigen::MatrixXd matrix = random_matrix(6, 7);
  const Hdf5Reader file = written(directory, [&](Hdf5Writer& writer) {
    writer.write_matrix("block", matrix.block(1, 2, 3, 4));
    writer.write_matrix("transposed", matrix.transpose());
    writer.write_vector("row", matrix.row(2).transpose());
  });
  CHECK(file.matrix("block") == matrix.block(1, 2, 3, 4));
  CHECK(file.matrix("transposed") == matrix.transpose());
  CHECK(file.vector("row") == matrix.row(2).transpose());
}

TEST_CASE("a block of three dimensions reads back, and nothing else passes for one") {
  const TemporaryDirectory directory;
  const std::vector<double> values = {1.0, 2.0, 3.0, 4.0, 5.0, 1.0 / 3.0};
  const Hdf5Reader file = written(directory, [&](Hdf5Writer& writer) {
    writer.write_block("b", {1, 3, 2}, values);
    writer.write_vector("v", Eigen::Vector3d(1.0, 2.0, 3.0));
    CHECK_THROWS_AS(writer.write_block("c", {2, 3, 2}, values), samara::ArgumentError);
  });
  const samara::io::Hdf5Block block = file.block("b");
  CHECK(block.size == std::array<Eigen::Index, 3>{1, 3, 2});
  CHECK(block.values == values);
  CHECK_THROWS_AS(file.block("v"), samara::InputError);
}

TEST_CASE("attributes of every kind read back, on groups and datasets") {
  const TemporaryDirectory directory;
  const std::string long_text(200000, 'x');
  const Hdf5Reader file = written(directory, [&](Hdf5Writer& writer) {
    writer.write_vector("/a/v", Eigen::Vector2d(1, 2));
    for (const std::string object : {"/", "a", "/a/v"}) {
      writer.write_text_attribute(object, "text", "samara");
      writer.write_text_attribute(object, "unit", "\u00B5m");
      writer.write_text_attribute(object, "empty", "");
      writer.write_text_attribute(object, "long", long_text);
      writer.write_integer_attribute(object, "integer", std::numeric_limits<std::int64_t>::min());
      writer.write_number_attribute(object, "number", 0.1);
      writer.write_number_attribute(object, "infinite", std::numeric_limits<double>::infinity());
      writer.write_numbers_attribute(object, "numbers", std::vector{1.5, -0.1, 1e300});
      writer.write_numbers_attribute(object, "none", {});
    }
  });
  for (const std::string object : {"/", "a", "/a/v"}) {
    CHECK(file.text_attribute(object, "text") == "samara");
    CHECK(file.text_attribute(object, "unit") == "\u00B5m");
    CHECK(file.text_attribute(object, "empty").empty());
    CHECK(file.text_attribute(object, "long") == long_text);
    CHECK(file.integer_attribute(object, "integer") == std::numeric_limits<std::int64_t>::min());
    CHECK(file.number_attribute(object, "number") == 0.1);
    CHECK(file.finite_attribute(object, "number") == 0.1);
    CHECK(std::isinf(file.number_attribute(object, "infinite")));
    CHECK_THAT(input_error([&] { file.finite_attribute(object, "infinite"); }),
               Contains(object + ": infinite is inf, expected a finite number"));
    CHECK(file.numbers_attribute(object, "numbers") == std::vector{1.5, -0.1, 1e300});
    CHECK(file.numbers_attribute(object, "number") == std::vector{0.1});
    CHECK(file.numbers_attribute(object, "none").empty());
    CHECK(file.has_attribute(object, "text"));
    CHECK_FALSE(file.has_attribute(object, "none such"));
  }
  CHECK_FALSE(file.has_attribute("/nowhere", "text"));
}

TEST_CASE("texts read back") {
  const TemporaryDirectory directory;
  const std::vector<std::string> texts = {"x", "", "angle of attack \u03B1", std::string(5000, 'y'), " z "};
  const Hdf5Reader file = written(directory, [&](Hdf5Writer& writer) {
    writer.write_texts("/names", texts);
    writer.write_texts("/none", {});
    writer.write_texts("/blank", {""});
  });
  CHECK(file.texts("/names") == texts);
  CHECK(file.texts("/none").empty());
  CHECK(file.texts("/blank") == std::vector<std::string>{""});
}

TEST_CASE("groups list their members sorted") {
  const TemporaryDirectory directory;
  const Hdf5Reader file = written(directory, [](Hdf5Writer& writer) {
    writer.create_group("/g/b");
    writer.create_group("/g/b");
    writer.write_vector("/g/c", Eigen::Vector2d(1, 2));
    writer.write_vector("/g/theta(0)", Eigen::Vector2d(1, 2));
    writer.create_group("/g/a");
  });
  CHECK(file.children("/g") == std::vector<std::string>{"a", "b", "c", "theta(0)"});
  CHECK(file.children("/") == std::vector<std::string>{"g"});
  CHECK(file.children("/g/a").empty());
  CHECK((file.has("/") && file.has("g/c") && file.has("/g/theta(0)")));
  CHECK_FALSE((file.has("/h") || file.has("/g/c/d") || file.has("/h/i")));
}

TEST_CASE("a dimension scale names the axis of a dataset") {
  const TemporaryDirectory directory;
  const Hdf5Reader file = written(directory, [](Hdf5Writer& writer) {
    writer.write_vector("/axes/t", Eigen::Vector3d(0, 1, 2));
    writer.write_vector("/axes/p", Eigen::Vector2d(0, 1));
    writer.write_matrix("/x", Eigen::MatrixXd::Ones(3, 2));
    writer.make_scale("/axes/t", "time");
    writer.make_scale("/axes/p", "p");
    writer.attach_scale("/x", 0, "/axes/t");
    writer.attach_scale("/x", 1, "/axes/p");
  });
  CHECK(file.text_attribute("/axes/t", "CLASS") == "DIMENSION_SCALE");
  CHECK(file.text_attribute("/axes/t", "NAME") == "time");
  CHECK(file.has_attribute("/axes/t", "REFERENCE_LIST"));
  CHECK(file.has_attribute("/x", "DIMENSION_LIST"));
}

TEST_CASE("the same calls give the same bytes") {
  const TemporaryDirectory directory;
  const auto write = [&](const std::string& name) {
    Hdf5Writer writer(directory / name);
    writer.write_vector("/axes/t", Eigen::VectorXd::LinSpaced(50, 0, 1));
    writer.write_matrix("/x", random_matrix(50, 2));
    writer.write_text_attribute("/", "format", "samara-codebook");
    writer.write_texts("/names", {"x", "y"});
    writer.make_scale("/axes/t", "t");
    writer.attach_scale("/x", 0, "/axes/t");
    writer.commit();
  };
  write("a.h5");
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // the clock of HDF5 counts whole seconds
  write("b.h5");
  CHECK(content(directory / "a.h5") == content(directory / "b.h5"));
}

TEST_CASE("a file appears on commit and not before, and without commit nothing is left") {
  const TemporaryDirectory directory;
  put_content(directory / "f.h5", "old");
  {
    Hdf5Writer writer(directory / "f.h5");
    writer.write_vector("/v", Eigen::Vector2d(1, 2));
    CHECK(content(directory / "f.h5") == "old");
  }
  CHECK(content(directory / "f.h5") == "old");
  CHECK(directory.file_count() == 1);
  Hdf5Writer writer(directory / "f.h5");
  writer.commit();
  CHECK(directory.file_count() == 1);
  CHECK(Hdf5Reader(directory / "f.h5").children("/").empty());
  CHECK_THAT(argument_error([&] { writer.create_group("/g"); }), Contains("after commit()"));
  CHECK_THAT(argument_error([&] { writer.commit(); }), Contains("after commit()"));
}

TEST_CASE("a file may be replaced while its older version is read") {
  const TemporaryDirectory directory;
  const Hdf5Reader older =
      written(directory, [](Hdf5Writer& w) { w.write_vector("/v", Eigen::Vector2d(1, 2)); });
  const Hdf5Reader newer =
      written(directory, [](Hdf5Writer& w) { w.write_vector("/v", Eigen::Vector2d(3, 4)); });
  CHECK(older.vector("/v") == Eigen::Vector2d(1, 2));
  CHECK(newer.vector("/v") == Eigen::Vector2d(3, 4));
}

TEST_CASE("a disk that is full gives one sentence with the system's reason, and leaves nothing") {
  const TemporaryDirectory directory;
  const auto write = [&] {
    Hdf5Writer writer(directory / "f.h5");
    writer.write_matrix("/m", random_matrix(500, 100));
    writer.commit();
  };
  // Files of more than 64 KiB cannot be written for a while.
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
  rlimit small = before;
  small.rlim_cur = 65536;
  REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0);
  const std::string refusal = error_text<ArgumentError>(write);
  REQUIRE(setrlimit(RLIMIT_FSIZE, &before) == 0);
  std::signal(SIGXFSZ, handler);
  CHECK_THAT(refusal, Contains("cannot write \"" + (directory / "f.h5").string() + "\": File too large"));
  CHECK(directory.file_count() == 0);
  write();
  CHECK(Hdf5Reader(directory / "f.h5").matrix("/m") == random_matrix(500, 100));
}

TEST_CASE("one reader may be used from several threads") {
  const TemporaryDirectory directory;
  const Eigen::MatrixXd matrix = random_matrix(40, 30);
  const Hdf5Reader file = written(directory, [&](Hdf5Writer& writer) { writer.write_matrix("/m", matrix); });
  std::vector<int> right(4, 0);
  std::vector<std::thread> threads;
  for (int& count : right) {
    threads.emplace_back([&] {
      for (int i = 0; i < 50; ++i) count += file.matrix("/m") == matrix ? 1 : 0;
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(right == std::vector<int>(4, 50));
}

TEST_CASE("what cannot be written is refused with file and object") {
  const TemporaryDirectory directory;
  CHECK_THAT(argument_error([&] { Hdf5Writer writer(directory / "no/f.h5"); }), Contains("does not exist"));
  Hdf5Writer writer(directory / "f.h5");
  writer.write_vector("/g/v", Eigen::Vector2d(1, 2));
  writer.write_number_attribute("/g", "a", 1);
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);
  CHECK_THAT(argument_error([&] { writer.write_vector("/g/v", one); }),
             Contains("cannot write /g/v of") && Contains("f.h5") && Contains("exists already"));
  CHECK_THAT(argument_error([&] { writer.write_vector("/g/v/w", one); }), Contains("/g/v is not a group"));
  CHECK_THAT(argument_error([&] { writer.create_group("/g/v"); }), Contains("/g/v is not a group"));
  CHECK_THAT(argument_error([&] { writer.write_vector("/", one); }), Contains("root"));
  CHECK_THAT(argument_error([&] { writer.write_vector("/g//v", one); }), Contains("the name \"\""));
  CHECK_THAT(argument_error([&] { writer.create_group("/g/.."); }), Contains("the name \"..\""));
  CHECK_THAT(argument_error([&] { writer.write_number_attribute("/g", "a", 2); }),
             Contains("attribute \"a\" of /g") && Contains("exists already"));
  CHECK_THAT(argument_error([&] { writer.write_number_attribute("/h", "a", 2); }),
             Contains("no such object"));
  CHECK_THAT(argument_error([&] { writer.write_number_attribute("/g", "", 2); }), Contains("empty"));
  CHECK_THAT(argument_error([&] { writer.write_text_attribute("/g", "t", std::string("a\0b", 3)); }),
             Contains("zero byte"));
  CHECK_THAT(argument_error([&] { writer.write_texts("/t", {std::string("a\0b", 3)}); }),
             Contains("zero byte"));
  CHECK_THAT(argument_error([&] { writer.make_scale("/g", "g"); }), Contains("not a dataset"));
  CHECK_THAT(argument_error([&] { writer.attach_scale("/g/v", 0, "/g/v"); }),
             Contains("not a dimension scale"));
  writer.write_vector("/s", one);
  writer.make_scale("/s", "s");
  CHECK_THAT(argument_error([&] { writer.attach_scale("/g/v", 1, "/s"); }), Contains("no dimension 1"));
}

TEST_CASE("what is missing or of another kind or shape is refused with file and object") {
  const TemporaryDirectory directory;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Hdf5Reader file = written(directory, [&](Hdf5Writer& writer) {
    writer.write_vector("/g/v", Eigen::Vector3d(1, 2, 3));
    writer.write_matrix("/g/m", Eigen::MatrixXd::Ones(3, 4));
    writer.write_vector("/g/nan", Eigen::Vector3d(1, nan, 3));
    writer.write_texts("/g/t", {"a"});
    writer.write_text_attribute("/g", "text", "a");
    writer.write_number_attribute("/g", "number", 1.5);
    writer.write_numbers_attribute("/g", "numbers", std::vector{1.0, 2.0});
    writer.write_integer_attribute("/g", "integer", 3);
  });
  const std::string name = (directory / "f.h5").string();
  CHECK(file.file() == name);
  CHECK(input_error([&] { file.vector("/g/w"); }) == name + ": dataset /g/w: is missing");
  CHECK(input_error([&] { file.vector("/g"); }) == name + ": dataset /g: expected a dataset, found a group");
  CHECK(input_error([&] { file.vector("/g/m"); }) ==
        name + ": dataset /g/m: expected 1 dimension, found the size 3 x 4");
  CHECK_THAT(input_error([&] { file.matrix("/g/v"); }), Contains("expected 2 dimensions, found the size 3"));
  CHECK_THAT(input_error([&] { file.vector("/g/v", {.rows = 4}); }),
             Contains("expected 4 rows, found the size 3"));
  CHECK_THAT(input_error([&] { file.matrix("/g/m", {.columns = 5}); }),
             Contains("expected 5 columns, found the size 3 x 4"));
  CHECK_THAT(input_error([&] { file.vector("/g/t"); }), Contains("dataset /g/t: expected doubles"));
  CHECK_THAT(input_error([&] { file.texts("/g/v"); }), Contains("dataset /g/v: expected text"));
  CHECK_THAT(input_error([&] { file.vector("/g/nan"); }),
             Contains("expected finite numbers, found nan as element 1"));
  CHECK(std::isnan(file.vector("/g/nan", {.finite = false})[1]));
  CHECK(input_error([&] { file.text_attribute("/g", "x"); }) == name + ": attribute \"x\" of /g: is missing");
  CHECK(input_error([&] { file.text_attribute("/h", "x"); }) == name + ": /h: is missing");
  CHECK_THAT(input_error([&] { file.text_attribute("/g", "number"); }),
             Contains("\"number\" of /g: expected text"));
  CHECK_THAT(input_error([&] { file.number_attribute("/g", "text"); }), Contains("expected doubles"));
  CHECK_THAT(input_error([&] { file.integer_attribute("/g", "number"); }), Contains("expected an integer"));
  CHECK_THAT(input_error([&] { file.number_attribute("/g", "numbers"); }),
             Contains("expected one value, found the size 2"));
  CHECK(file.number_attribute("/g", "integer") == 3.0);
  CHECK_THAT(input_error([&] { file.children("/g/v"); }), Contains("expected a group, found a dataset"));
  CHECK_THAT(input_error([&] { file.children("/h"); }), Contains("group /h: is missing"));
  CHECK(std::string(file.error("/g", "has no axes").what()) == name + ": /g: has no axes");
}
