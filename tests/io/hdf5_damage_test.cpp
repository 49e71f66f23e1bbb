#include <functional>
#include <random>

#include <catch2/catch.hpp>
#include <hdf5.h>

#include "../error_text.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/hdf5_writer.h"
#include "temporary_directory.h"

// Files that are not what they claim to be. Foreign ones are made with the library itself.

#ifdef __SANITIZE_ADDRESS__
// HDF5 1.10 loses memory when it meets damaged metadata. What we would lose ourselves, identifiers of the
// library, are counted below.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libhdf5";
}
#endif

using Catch::Matchers::Contains;
using samara::InputError;
using samara::io::Hdf5Reader;
using samara::io::Hdf5Writer;

namespace {

namespace fs = std::filesystem;

/// Numbers that deflate cannot shorten, so that the chunks are most of the file.
Eigen::MatrixXd noise(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(1.0, 2.0);
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(random); });
}

void write_sample(const fs::path& path) {
  Hdf5Writer writer(path);
  writer.write_text_attribute("/", "format", "samara-codebook");
  writer.write_vector("/axes/t", Eigen::VectorXd::LinSpaced(30, 0, 1));
  writer.write_matrix("/m", noise(40, 30));
  writer.write_texts("/names", {"x", "y"});
  writer.make_scale("/axes/t", "t");
  writer.attach_scale("/m", 1, "/axes/t");
  writer.commit();
}

/// Reads all that write_sample() wrote.
void read_sample(const fs::path& path) {
  const Hdf5Reader file(path);
  file.text_attribute("/", "format");
  for (const std::string& name : file.children("/")) file.has(name);
  file.vector("/axes/t");
  file.text_attribute("/axes/t", "NAME");
  file.matrix("/m", {.rows = 40, .columns = 30});
  file.texts("/names");
}

std::string reading_error(const fs::path& path) {
  return error_text<InputError>([&] { read_sample(path); });
}

/// A file made by the library, with `fill` called on its identifier.
void make_foreign(const fs::path& path, const std::function<void(hid_t)>& fill, bool latest = true) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  if (latest) H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  fill(file);
  H5Fclose(file);
  H5Pclose(access);
}

/// A dataset of doubles of the given size, not written.
hid_t make_dataset(hid_t file, const char* name, const std::vector<hsize_t>& size,
                   hid_t creation = H5P_DEFAULT) {
  const hid_t space = H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr);
  const hid_t dataset = H5Dcreate2(file, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, creation, H5P_DEFAULT);
  H5Sclose(space);
  return dataset;
}

}  // namespace

TEST_CASE("a file cut at any length is refused") {
  const TemporaryDirectory directory;
  write_sample(directory / "f.h5");
  REQUIRE(reading_error(directory / "f.h5") == "no exception");
  const std::string whole = content(directory / "f.h5");
  for (std::size_t length = 0; length < whole.size(); length += length < 200 ? 1 : 97) {
    put_content(directory / "cut.h5", whole.substr(0, length));
    INFO(length << " of " << whole.size());
    const std::string error = reading_error(directory / "cut.h5");
    CHECK_THAT(error, Contains("cut.h5: ") && (Contains("truncated") || Contains("not an HDF5 file")));
    CHECK(error.find('\n') == std::string::npos);
  }
  put_content(directory / "cut.h5", whole.substr(0, whole.size() - 1));
  CHECK_THAT(reading_error(directory / "cut.h5"), Contains("truncated"));
}

TEST_CASE("a byte changed in the data is found by its checksum") {
  const TemporaryDirectory directory;
  write_sample(directory / "f.h5");
  const std::string whole = content(directory / "f.h5");
  // The bytes of the noise are the longest stretch of the file: 40 x 30 doubles, about 8 kB after deflate.
  int data_errors = 0;
  for (std::size_t at = whole.size() / 4; at < whole.size() * 3 / 4; at += 101) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    put_content(directory / "bad.h5", damaged);
    const std::string error = reading_error(directory / "bad.h5");
    if (error.find("dataset /m: cannot be read: ") != std::string::npos &&
        error.find("Fletcher32") != std::string::npos) {
      ++data_errors;
    }
  }
  CHECK(data_errors >= 20);
}

TEST_CASE("a byte changed anywhere gives an input error or the right values, never a crash") {
  const TemporaryDirectory directory;
  write_sample(directory / "f.h5");
  const std::string whole = content(directory / "f.h5");
  const Eigen::MatrixXd right = noise(40, 30);
  for (std::size_t at = 0; at < whole.size(); at += at < 3000 || at > 10000 ? 7 : 61) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x41);
    put_content(directory / "bad.h5", damaged);
    INFO("byte " << at);
    const std::string error = reading_error(directory / "bad.h5");
    CHECK_THAT(error, Contains("no exception") || Contains("bad.h5: "));
    if (error == "no exception") CHECK(Hdf5Reader(directory / "bad.h5").matrix("/m") == right);
  }
}

TEST_CASE("nothing is left open in the library, whatever happened") {
  const TemporaryDirectory directory;
  write_sample(directory / "f.h5");
  const std::string whole = content(directory / "f.h5");
  read_sample(directory / "f.h5");
  for (std::size_t at = 0; at < whole.size(); at += 53) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x08);
    put_content(directory / "bad.h5", damaged);
    reading_error(directory / "bad.h5");
  }
  { const Hdf5Writer uncommitted(directory / "f.h5"); }
  CHECK(H5Fget_obj_count(static_cast<hid_t>(H5F_OBJ_ALL), H5F_OBJ_ALL) == 0);
}

TEST_CASE("what is not an HDF5 file is refused in one sentence") {
  const TemporaryDirectory directory;
  const auto error = [](const fs::path& path) {
    return error_text<InputError>([&] { Hdf5Reader reader(path); });
  };
  put_content(directory / "text", "t[s],x[m]\n0,1\n");
  put_content(directory / "empty", "");
  put_content(directory / "signature", "\x89HDF\r\n\x1a\n");
  put_content(directory / "zeros", "\x89HDF\r\n\x1a\n\x03" + std::string(1000, '\0'));
  CHECK(error(directory / "text") == (directory / "text").string() + ": is not an HDF5 file but a text");
  put_content(directory / "picture", "\x89PNG\r\n\x1a\n");
  CHECK_THAT(error(directory / "picture"), Contains("is not an HDF5 file but a PNG picture"));
  CHECK_THAT(error(directory / "empty"), Contains("is not an HDF5 file"));
  CHECK_THAT(error(directory / "signature"), Contains("is truncated: 8 bytes"));
  CHECK_THAT(error(directory / "zeros"), Contains("cannot be opened as HDF5: "));
  CHECK_THAT(error(directory / "none"), Contains("the file does not exist"));
  CHECK_THAT(error(directory.path()), Contains("is not a regular file"));
}

TEST_CASE("a file without checksums in its metadata is refused") {
  const TemporaryDirectory directory;
  make_foreign(
      directory / "old.h5", [](hid_t) {}, false);
  CHECK_THAT(reading_error(directory / "old.h5"),
             Contains("old.h5: is not a file that Samara can read: ") &&
                 Contains("superblock of version 0, expected 2 or later"));
}

TEST_CASE("a size beyond what the file can hold is refused before memory is taken") {
  const TemporaryDirectory directory;
  make_foreign(directory / "f.h5", [](hid_t file) {
    const hid_t chunked = H5Pcreate(H5P_DATASET_CREATE);
    const hsize_t chunk[2] = {10, 10};
    H5Pset_chunk(chunked, 2, chunk);
    H5Dclose(make_dataset(file, "wide", {hsize_t{1} << 40, 1000}, chunked));
    H5Dclose(make_dataset(file, "overflow", {hsize_t{1} << 32, hsize_t{1} << 32}, chunked));
    H5Dclose(make_dataset(file, "large", {30000, 30000}, chunked));
    H5Pclose(chunked);
  });
  const Hdf5Reader file(directory / "f.h5");
  for (const char* name : {"wide", "overflow", "large"}) {
    CHECK_THAT(error_text<InputError>([&] { file.matrix(name); }), Contains("beyond what the file can hold"));
  }
}

TEST_CASE("data that were never stored are refused, not read as zeros") {
  const TemporaryDirectory directory;
  make_foreign(directory / "f.h5", [](hid_t file) {
    const hid_t chunked = H5Pcreate(H5P_DATASET_CREATE);
    const hsize_t chunk = 10;
    H5Pset_chunk(chunked, 1, &chunk);
    const hid_t partial = make_dataset(file, "partial", {25}, chunked);
    const hsize_t start = 0;
    const hid_t part = H5Dget_space(partial);
    H5Sselect_hyperslab(part, H5S_SELECT_SET, &start, nullptr, &chunk, nullptr);
    const hid_t memory = H5Screate_simple(1, &chunk, nullptr);
    const std::vector<double> values(chunk, 1.0);
    H5Dwrite(partial, H5T_NATIVE_DOUBLE, memory, part, H5P_DEFAULT, values.data());
    H5Sclose(memory);
    H5Sclose(part);
    H5Dclose(partial);
    H5Pclose(chunked);
    H5Dclose(make_dataset(file, "contiguous", {25}));
  });
  const Hdf5Reader file(directory / "f.h5");
  CHECK_THAT(error_text<InputError>([&] { file.vector("partial"); }), Contains("1 of 3 chunks are stored"));
  CHECK_THAT(error_text<InputError>([&] { file.vector("contiguous"); }), Contains("is incomplete"));
}

TEST_CASE("links and storage that lead out of the file are not followed") {
  const TemporaryDirectory directory;
  write_sample(directory / "other.h5");
  put_content(directory / "raw", std::string(80, 'x'));
  make_foreign(directory / "f.h5", [&](hid_t file) {
    H5Lcreate_external((directory / "other.h5").c_str(), "/m", file, "external", H5P_DEFAULT, H5P_DEFAULT);
    H5Lcreate_soft("/data", file, "soft", H5P_DEFAULT, H5P_DEFAULT);
    const hid_t outside = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_external(outside, (directory / "raw").c_str(), 0, 80);
    H5Dclose(make_dataset(file, "outside", {10}, outside));
    H5Pclose(outside);
  });
  const Hdf5Reader file(directory / "f.h5");
  CHECK_THAT(error_text<InputError>([&] { file.matrix("external"); }), Contains("is missing"));
  CHECK_THAT(error_text<InputError>([&] { file.matrix("soft"); }), Contains("is missing"));
  CHECK_THAT(error_text<InputError>([&] { file.vector("outside"); }), Contains("outside the file"));
}

TEST_CASE(
    "single floats, integers in attributes and strings of variable length are read from foreign files") {
  const TemporaryDirectory directory;
  make_foreign(directory / "f.h5", [](hid_t file) {
    const hsize_t size = 2;
    const hid_t space = H5Screate_simple(1, &size, nullptr);
    const hid_t floats =
        H5Dcreate2(file, "floats", H5T_IEEE_F32BE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const double numbers[2] = {0.5, -2.0};
    H5Dwrite(floats, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers);
    const hid_t variable = H5Tcopy(H5T_C_S1);
    H5Tset_size(variable, H5T_VARIABLE);
    const char* words[2] = {"drag", "lift"};
    const hid_t strings = H5Dcreate2(file, "strings", variable, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(strings, variable, H5S_ALL, H5S_ALL, H5P_DEFAULT, words);
    const hid_t whole =
        H5Dcreate2(file, "whole", H5T_STD_I32LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t scalar = H5Screate(H5S_SCALAR);
    const hid_t title = H5Acreate2(file, "title", variable, scalar, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(title, variable, &words[0]);
    H5Aclose(title);
    H5Sclose(scalar);
    H5Dclose(whole);
    H5Dclose(strings);
    H5Tclose(variable);
    H5Dclose(floats);
    H5Sclose(space);
  });
  const Hdf5Reader file(directory / "f.h5");
  CHECK(file.vector("floats") == Eigen::Vector2d(0.5, -2.0));
  CHECK_THAT(error_text<InputError>([&] { file.texts("strings"); }), Contains("text of a fixed size"));
  CHECK_THAT(error_text<InputError>([&] { file.text_attribute("/", "title"); }),
             Contains("text of a fixed size"));
  CHECK_THAT(error_text<InputError>([&] { file.vector("whole"); }), Contains("expected doubles"));
}
