#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <hdf5.h>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "same_codebook.h"
#include "sample_books.h"

/// Files that are not, or no longer, codebooks. They are changed with the HDF5 library itself.
namespace damaged_codebook {

namespace fs = std::filesystem;
using samara::InputError;
using namespace samara::codebooks;

inline std::string load_error(const fs::path& path) {
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

inline Codebook certified() {
  const Codebook book(sample_model(), four_pieces().pieces(), sample_build(), sample_provenance());
  return book.with_certificate(sample_certificate(book));
}

/// What load() says to the four pieces, or another codebook, after `damage`. The sentence must begin with the
/// file and be one.
inline std::string error_after(const std::function<void(Patient&)>& damage,
                               const Codebook& book = certified()) {
  const TemporaryDirectory directory;
  const fs::path path = directory / "book.h5";
  save(book, path);
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

inline std::vector<double> numbers(int count, double value = 1.0) {
  return std::vector<double>(static_cast<std::size_t>(count), value);
}

}  // namespace damaged_codebook
