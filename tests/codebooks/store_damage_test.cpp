#include <functional>
#include <limits>

#include <catch2/catch.hpp>
#include <hdf5.h>

#include "../io/error_text.h"
#include "../io/temporary_directory.h"
#include "samara/codebooks/store.h"
#include "samara/io/hdf5_writer.h"
#include "same_codebook.h"
#include "sample_books.h"

// Files that are not, or no longer, codebooks. They are changed with the HDF5 library itself.

#ifdef __SANITIZE_ADDRESS__
// HDF5 1.10 loses memory when it meets damaged metadata.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libhdf5";
}
#endif

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using samara::InputError;

namespace {

namespace fs = std::filesystem;

std::string load_error(const fs::path& path) {
  return error_text<InputError>([&] { load(path); });
}

/// An open file that is to be damaged.
class Patient {
 public:
  explicit Patient(const fs::path& path) {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
    file_ = H5Fopen(path.c_str(), H5F_ACC_RDWR, access);
    H5Pclose(access);
    REQUIRE(file_ >= 0);
  }
  Patient(const Patient&) = delete;
  Patient& operator=(const Patient&) = delete;
  ~Patient() { H5Fclose(file_); }

  void remove(const std::string& path) { REQUIRE(H5Ldelete(file_, path.c_str(), H5P_DEFAULT) >= 0); }
  void rename(const std::string& from, const std::string& to) {
    REQUIRE(H5Lmove(file_, from.c_str(), file_, to.c_str(), H5P_DEFAULT, H5P_DEFAULT) >= 0);
  }
  void create_group(const std::string& path) {
    H5Gclose(H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  }
  void remove_attribute(const std::string& object, const std::string& name) {
    REQUIRE(H5Adelete_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT) >= 0);
  }
  void set_text(const std::string& object, const std::string& name, const std::string& text) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, text.size() + 1);
    set_attribute(object, name, type, {}, text.c_str());
    H5Tclose(type);
  }
  void set_integer(const std::string& object, const std::string& name, long long value) {
    set_attribute(object, name, H5T_NATIVE_LLONG, {}, &value);
  }
  void set_number(const std::string& object, const std::string& name, double value) {
    set_attribute(object, name, H5T_NATIVE_DOUBLE, {}, &value);
  }
  void copy(const std::string& from, const std::string& to) {
    REQUIRE(H5Ocopy(file_, from.c_str(), file_, to.c_str(), H5P_DEFAULT, H5P_DEFAULT) >= 0);
  }
  void set_numbers(const std::string& object, const std::string& name, const std::vector<double>& values) {
    const double none = 0.0;  // the library wants a pointer also where there is nothing
    set_attribute(object, name, H5T_NATIVE_DOUBLE, {values.size()}, values.empty() ? &none : values.data());
  }
  /// Puts other numbers into a dataset; sizes may differ. Attributes are kept.
  void set_dataset(const std::string& path, const std::vector<hsize_t>& size,
                   const std::vector<double>& values) {
    const hid_t old = H5Dopen2(file_, path.c_str(), H5P_DEFAULT);
    const hid_t space = H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr);
    const std::string other = path + ".new";
    const hid_t dataset =
        H5Dcreate2(file_, other.c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    if (!values.empty()) H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    const auto copy = [](hid_t from, const char* name, const H5A_info_t*, void* to) -> herr_t {
      const hid_t source = H5Aopen(from, name, H5P_DEFAULT);
      const hid_t type = H5Aget_type(source);
      const hid_t extent = H5Aget_space(source);
      if (H5Tget_class(type) != H5T_VLEN && H5Tget_class(type) != H5T_COMPOUND) {
        std::vector<char> bytes(static_cast<std::size_t>(H5Sget_simple_extent_npoints(extent)) *
                                H5Tget_size(type));
        H5Aread(source, type, bytes.data());
        const hid_t target =
            H5Acreate2(*static_cast<hid_t*>(to), name, type, extent, H5P_DEFAULT, H5P_DEFAULT);
        H5Awrite(target, type, bytes.data());
        H5Aclose(target);
      }
      H5Sclose(extent);
      H5Tclose(type);
      H5Aclose(source);
      return 0;
    };
    hid_t target = dataset;
    H5Aiterate2(old, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, copy, &target);
    H5Sclose(space);
    H5Dclose(old);
    H5Dclose(dataset);
    remove(path);
    rename(other, path);
  }

 private:
  void set_attribute(const std::string& object, const std::string& name, hid_t type,
                     const std::vector<hsize_t>& size, const void* value) {
    if (H5Aexists_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0)
      remove_attribute(object, name);
    const hid_t space = size.empty() ? H5Screate(H5S_SCALAR)
                                     : H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr);
    const hid_t attribute = H5Acreate_by_name(file_, object.c_str(), name.c_str(), type, space, H5P_DEFAULT,
                                              H5P_DEFAULT, H5P_DEFAULT);
    REQUIRE(attribute >= 0);
    REQUIRE(H5Awrite(attribute, type, value) >= 0);
    H5Aclose(attribute);
    H5Sclose(space);
  }

  hid_t file_;
};

Codebook certified() {
  const Codebook book(sample_model(), four_pieces().pieces(), sample_build(), sample_provenance());
  return book.with_certificate(sample_certificate(book));
}

/// What load() says to the four pieces after `damage`. The sentence must begin with the file and be one.
std::string error_after(const std::function<void(Patient&)>& damage) {
  const TemporaryDirectory directory;
  const fs::path path = directory / "book.h5";
  save(certified(), path);
  {
    Patient patient(path);
    damage(patient);
  }
  const std::string error = load_error(path);
  if (error == "no exception") return error;
  INFO(error);
  CHECK(error.find(path.string() + ": ") == 0);
  CHECK(error.find('\n') == std::string::npos);
  return error.substr(path.string().size() + 2);
}

// Nodes of the axes of piece 0, see sample_books.cpp.
constexpr int kTimeNodes = 9, kParameterNodes = 7, kInitialNodes = 4, kRank = 5;

std::vector<double> numbers(int count, double value = 1.0) {
  return std::vector<double>(static_cast<std::size_t>(count), value);
}

}  // namespace

TEST_CASE("a file that was only touched is still the same codebook") {
  CHECK(error_after([](Patient&) {}) == "no exception");
  // And the ways of this test to change a file do not damage it by themselves.
  CHECK(error_after([](Patient& file) {
          file.set_dataset("/pieces/0/groups/0/weights", {2, kRank}, numbers(2 * kRank));
          file.set_dataset("/pieces/0/axes/v(0)", {kInitialNodes}, {-0.3, -0.1, 0.05, 0.6});
          file.set_text("/", "format_version", "0.1");
          file.set_integer("/pieces/0/axes/t", "index", 0);
          file.set_numbers("/pieces/0/axes/C_D", "borders", {0.5, 1.0});
        }) == "no exception");
}

TEST_CASE("what is not a file, or not HDF5, is no codebook") {
  const TemporaryDirectory directory;
  CHECK_THAT(load_error(directory / "none.h5"), Contains("none.h5: the file does not exist"));
  CHECK_THAT(load_error(directory.path()), Contains("is not a regular file"));
  put_content(directory / "text.h5", "t[s],x[m]\n0,1\n");
  CHECK_THAT(load_error(directory / "text.h5"), Contains("text.h5: is not an HDF5 file"));
}

TEST_CASE("an HDF5 file of something else is no codebook") {
  const TemporaryDirectory directory;
  samara::io::Hdf5Writer writer(directory / "other.h5");
  writer.write_vector("/x", Eigen::Vector3d(1, 2, 3));
  writer.commit();
  CHECK_THAT(load_error(directory / "other.h5"),
             Contains("other.h5: /: attribute format is not \"samara-codebook\": this is not a codebook"));
  CHECK_THAT(error_after([](Patient& file) { file.set_text("/", "format", "samara-checkpoint"); }),
             Contains("this is not a codebook"));
  CHECK_THAT(error_after([](Patient& file) { file.set_integer("/", "format", 3); }), Contains("format"));
}

TEST_CASE("a certificate that contradicts itself, or has no numbers, is refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const auto with = [](const std::string& object, const std::string& name, double value) {
    return error_after([&](Patient& file) { file.set_number(object, name, value); });
  };
  CHECK_THAT(with("/certificate", "tolerance", nan), StartsWith("/certificate: tolerance is nan"));
  CHECK_THAT(with("/certificate", "tolerance", infinity), StartsWith("/certificate: tolerance is inf"));
  CHECK_THAT(with("/certificate", "max_error", nan), StartsWith("/certificate: max_error is nan"));
  CHECK_THAT(with("/certificate", "residual", infinity), StartsWith("/certificate: residual is inf"));
  CHECK_THAT(with("/certificate/x", "p95", nan), StartsWith("/certificate/x: p95 is nan"));
  CHECK_THAT(with("/certificate", "max_error", 0.5),
             StartsWith("/certificate: met is 1, but max_error 0.5 is more than the tolerance"));
  CHECK_THAT(error_after([](Patient& file) { file.set_integer("/certificate", "met", 7); }),
             StartsWith("/certificate: met is 7, expected 0 or 1"));
  CHECK_THAT(error_after([](Patient& file) { file.set_text("/certificate", "seed", "x"); }),
             StartsWith("/certificate: seed is \"x\""));
  // What was missed may be missed by infinity.
  CHECK(error_after([&](Patient& file) {
          file.set_integer("/certificate", "met", 0);
          file.set_number("/certificate", "max_error", infinity);
        }) == "no exception");
}

TEST_CASE("a file whose parts say different things is refused") {
  CHECK_THAT(error_after([](Patient& file) { file.set_text("/", "model", "other"); }),
             StartsWith("/: model is \"other\", but /model has the name \"vertical_fall\""));
  CHECK_THAT(error_after([](Patient& file) {
               for (const char* piece : {"0", "1", "2", "3"})
                 file.set_text(std::string("/pieces/") + piece + "/axes/v(0)", "units", "kg");
             }),
             StartsWith("/pieces/0/axes/v(0): units are \"kg\", those of the model \"m/s\""));
  CHECK_THAT(error_after([](Patient& file) { file.copy("/pieces/0", "/pieces/4"); }),
             StartsWith("/pieces/4: has the same box as /pieces/0"));
}

TEST_CASE("a file cut at any length is refused") {
  const TemporaryDirectory directory;
  save(certified(), directory / "book.h5");
  const std::string whole = content(directory / "book.h5");
  for (const double part : {0.0, 0.0005, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.9999}) {
    put_content(directory / "cut.h5",
                whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size()))));
    INFO(part);
    CHECK_THAT(load_error(directory / "cut.h5"),
               Contains("cut.h5: ") && (Contains("truncated") || Contains("not an HDF5 file")));
  }
}

TEST_CASE("a byte changed anywhere gives an input error or the same codebook, never a crash") {
  const TemporaryDirectory directory;
  const Codebook book = certified();
  save(book, directory / "book.h5");
  const std::string whole = content(directory / "book.h5");
  int refused = 0;
  for (std::size_t at = 0; at < whole.size(); at += 211) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x41);
    put_content(directory / "bad.h5", damaged);
    INFO("byte " << at << " of " << whole.size());
    const std::string error = load_error(directory / "bad.h5");
    CHECK_THAT(error, StartsWith("no exception") || Contains("bad.h5: "));
    if (error == "no exception") {
      check_same_codebook(load(directory / "bad.h5"), book);
    } else {
      ++refused;
    }
  }
  CHECK(refused > 50);
}

TEST_CASE("older minor versions of the format are read, newer and other major ones refused") {
  const auto version = [](const std::string& text) {
    return error_after([&](Patient& file) { file.set_text("/", "format_version", text); });
  };
  CHECK(version("0.2") == "no exception");
  CHECK(version("0.1") == "no exception");
  CHECK(version("0.0") == "no exception");
  for (const std::string other : {"0.3", "0.10", "1.0", "1.1", "10.0", "-1.0", "0.-1", "0", "0.", ".1",
                                  "0.1 ", "0.1x", "0.1.0", "0,1", "x", "", "0.99999999999999999999"}) {
    CHECK(version(other) == "/: format_version is \"" + other + "\", this program reads 0.0 to 0.2");
  }
  CHECK_THAT(error_after([](Patient& file) { file.remove_attribute("/", "format_version"); }),
             Contains("format_version"));
}

TEST_CASE("a part that is missing is named") {
  for (const std::string path :
       {"/pieces", "/pieces/0/axes", "/pieces/0/axes/C_D", "/pieces/0/groups", "/pieces/0/groups/1",
        "/pieces/1/groups/0/outputs", "/pieces/1/groups/0/units", "/pieces/1/groups/0/weights",
        "/pieces/3/groups/1/factors/t", "/pieces/2/groups/0/factors", "/model", "/model/fixed", "/build",
        "/provenance"}) {
    INFO(path);
    const std::string error = error_after([&](Patient& file) { file.remove(path); });
    CHECK(error != "no exception");
    // A factor matrix whose axis is gone stays unread, but then pieces differ; a group that is gone leaves a
    // piece with other outputs.
    if (path == "/pieces/0/axes/C_D" || path == "/pieces/0/groups/1") {
      CHECK_THAT(error, Contains("/pieces/0/axes") || Contains("/: pieces of a codebook"));
    } else {
      CHECK_THAT(error, Contains(path));
    }
  }
  CHECK_THAT(error_after([](Patient& file) { file.remove("/pieces/1"); }),
             Contains("/pieces: member 1 of 3 is missing"));
  CHECK_THAT(error_after([](Patient& file) {
               file.remove("/pieces");
               file.create_group("/pieces");
             }),
             Contains("/pieces: is empty"));
  // A codebook may be without certificate.
  CHECK(error_after([](Patient& file) { file.remove("/certificate"); }) == "no exception");
}

TEST_CASE("an attribute that is missing is named with its object") {
  struct Attribute {
    std::string object, name;
  };
  for (const auto& [object, name] : std::vector<Attribute>{{"/", "title"},
                                                           {"/pieces/0/axes/t", "index"},
                                                           {"/pieces/0/axes/t", "units"},
                                                           {"/pieces/0/axes/t", "role"},
                                                           {"/pieces/0/axes/t", "basis"},
                                                           {"/pieces/0/axes/t", "transform"},
                                                           {"/pieces/0/axes/t", "degree"},
                                                           {"/pieces/0/axes/t", "borders"},
                                                           {"/pieces/0/groups/0", "kind"},
                                                           {"/model", "equations"},
                                                           {"/model/fixed/g", "units"},
                                                           {"/build", "status"},
                                                           {"/build", "evaluations"},
                                                           {"/provenance", "plan"},
                                                           {"/certificate", "met"},
                                                           {"/certificate", "seed"},
                                                           {"/certificate/x", "range"},
                                                           {"/certificate/x", "worst"}}) {
    INFO(object << " " << name);
    const std::string error = error_after([&](Patient& file) { file.remove_attribute(object, name); });
    CHECK_THAT(error, Contains(object) && Contains(name) && Contains("missing"));
  }
}

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
  CHECK_THAT(with("basis", "imported"), Contains("\"imported\", which a codebook file cannot hold"));
  CHECK_THAT(with("role", "tine"), Contains("/pieces/0/axes/t: role is \"tine\"; did you mean \"time\"?"));
  CHECK_THAT(with("transform", "lock"),
             Contains("/pieces/0/axes/t: transform is \"lock\"; did you mean \"log\"?"));
  CHECK_THAT(with("transform", "log"),
             Contains("/pieces/0/axes/t: axis \"t\" begins at 0 with the transform"));
  CHECK_THAT(error_after([](Patient& file) { file.set_text("/pieces/0/groups/0", "kind", "train"); }),
             Contains("/pieces/0/groups/0: kind is \"train\", expected \"sum_of_products\""));
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
