#include "samara/io/hdf5_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <string_view>
#include <system_error>

#include "samara/base/number_text.h"
#include "samara/base/text.h"
#include "samara/io/hdf5_dataset.h"
#include "samara/io/hdf5_driver.h"
#include "samara/io/hdf5_library.h"
#include "samara/io/text_file.h"

namespace samara::io {

using hdf5::Handle;
using hdf5::Session;
using hdf5::Source;

namespace {

constexpr std::string_view kSignature("\x89HDF\r\n\x1a\n", 8);

/// What begins so, as far as it shows: " but a text".
std::string what_it_is(std::string_view beginning) {
  std::string kind = binary_kind(beginning);
  const auto is_printed = [](char c) {
    return (c >= ' ' && c != 127) || c == '\n' || c == '\t' || c == '\r' || c < 0;
  };
  if (kind.empty() && !beginning.empty() && std::ranges::all_of(beginning, is_printed)) kind = "a text";
  return kind.empty() ? "" : " but " + kind;
}

/// Looks at the first bytes before the library does, and returns the size of the file.
std::uint64_t check_beginning(const std::filesystem::path& path, const std::string& expected) {
  const std::string name = path.string();
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw InputError(name, "the file does not exist");
  if (!std::filesystem::is_regular_file(status)) throw InputError(name, "is not a regular file");
  const std::uint64_t bytes = std::filesystem::file_size(path, error);
  std::ifstream stream(path, std::ios::binary);
  if (error || !stream) throw InputError(name, "cannot be opened for reading");
  constexpr std::size_t kShortest = 48;  // a superblock of version 2 or 3
  std::array<char, kShortest> head = {};
  stream.read(head.data(), kShortest);
  const std::string_view beginning(head.data(), static_cast<std::size_t>(stream.gcount()));
  if (!beginning.starts_with(kSignature)) {
    throw InputError(name, "is not an HDF5 file" + what_it_is(beginning) +
                               (expected.empty() ? "" : ", expected " + expected));
  }
  if (!stream) {
    throw InputError(name,
                     "is truncated: " + std::to_string(bytes) + " bytes are too short for an HDF5 file");
  }
  const int version = static_cast<unsigned char>(head[kSignature.size()]);
  if (version < 2) {
    throw InputError(name, "is not a file that Samara can read: it has an HDF5 superblock of version " +
                               std::to_string(version) +
                               ", expected 2 or later, which carry checksums (h5py: libver=\"latest\")");
  }
  return bytes;
}

/// "3 x 4"
std::string size_text(std::span<const hsize_t> dimensions) {
  std::string text;
  for (const hsize_t size : dimensions) text += (text.empty() ? "" : " x ") + std::to_string(size);
  return text.empty() ? "scalar" : text;
}

void check_rank(const hdf5::File& file, const Source& source, std::size_t rank) {
  if (source.dimensions.size() == rank) return;
  file.fail(source.what, "expected " + std::to_string(rank) + (rank == 1 ? " dimension" : " dimensions") +
                             ", found the size " + size_text(source.dimensions));
}

void check_extent(const hdf5::File& file, const Source& source, std::size_t dimension,
                  std::optional<Eigen::Index> expected) {
  if (!expected || static_cast<Eigen::Index>(source.dimensions[dimension]) == *expected) return;
  file.fail(source.what, std::string("expected ") + std::to_string(*expected) +
                             (dimension == 0 ? " rows" : " columns") + ", found the size " +
                             size_text(source.dimensions));
}

void check_finite(const hdf5::File& file, const Source& source, std::span<const double> values) {
  const auto bad =
      std::find_if_not(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  if (bad == values.end()) return;
  file.fail(source.what, "expected finite numbers, found " + number_text(*bad) + " as element " +
                             std::to_string(bad - values.begin()));
}

void check_scalar(const hdf5::File& file, const Source& source) {
  if (source.elements() != 1)
    file.fail(source.what, "expected one value, found the size " + size_text(source.dimensions));
}

}  // namespace

struct Hdf5Reader::Impl {
  hdf5::File file;

  Impl(const std::filesystem::path& path, const std::string& expected) {
    file.name = path.string();
    file.bytes = check_beginning(path, expected);
    const Session session;
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
    if (!hdf5::use_guarded_driver(access.get()))
      throw InputError(file.name, "cannot be opened as HDF5: " + hdf5::last_reason());
    Handle handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose);
    if (!handle.valid()) throw InputError(file.name, "cannot be opened as HDF5: " + hdf5::last_reason());
    file.handle = std::move(handle);
  }
  ~Impl() {
    const Session session;
    file.owner.close();
    file.handle.close();
  }
};

Hdf5Reader::Hdf5Reader(const std::filesystem::path& path, const std::string& expected)
    : impl_(std::make_unique<Impl>(path, expected)) {}
Hdf5Reader::~Hdf5Reader() = default;
Hdf5Reader::Hdf5Reader(Hdf5Reader&&) noexcept = default;
Hdf5Reader& Hdf5Reader::operator=(Hdf5Reader&&) noexcept = default;

const std::string& Hdf5Reader::file() const {
  return impl_->file.name;
}

bool Hdf5Reader::has(const std::string& path) const {
  const Session session;
  return hdf5::presence(impl_->file, hdf5::absolute(path)) == hdf5::Presence::there;
}

bool Hdf5Reader::has_attribute(const std::string& object, const std::string& name) const {
  const Session session;
  const std::string path = hdf5::absolute(object);
  if (hdf5::presence(impl_->file, path) != hdf5::Presence::there) return false;
  return H5Aexists_by_name(impl_->file.handle.get(), path.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Hdf5Reader::children(const std::string& group) const {
  const Session session;
  const std::string path = hdf5::absolute(group);
  const Handle object = hdf5::open_object(impl_->file, path, "group " + path);
  if (H5Iget_type(object.get()) != H5I_GROUP)
    impl_->file.fail("group " + path, "expected a group, found a dataset");
  // A name that is not there makes the library decode all links, and say so where it cannot. The table of
  // links that it iterates over, given up half-filled, would crash it.
  if (H5Lexists(object.get(), "no such member", H5P_DEFAULT) < 0)
    impl_->file.fail("group " + path, "cannot be read: " + hdf5::last_reason());
  std::vector<std::string> names;
  const auto keep_name = [](hid_t, const char* name, const H5L_info_t*, void* kept) -> herr_t {
    static_cast<std::vector<std::string>*>(kept)->emplace_back(name);
    return 0;
  };
  if (H5Literate(object.get(), H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, keep_name, &names) < 0) {
    impl_->file.fail("group " + path, "cannot be read: " + hdf5::last_reason());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string Hdf5Reader::text_attribute(const std::string& object, const std::string& name) const {
  const Session session;
  const Source source = hdf5::open_attribute(impl_->file, hdf5::absolute(object), name);
  check_scalar(impl_->file, source);
  return hdf5::read_strings(impl_->file, source).front();
}

std::int64_t Hdf5Reader::integer_attribute(const std::string& object, const std::string& name) const {
  const Session session;
  const Source source = hdf5::open_attribute(impl_->file, hdf5::absolute(object), name);
  if (H5Tget_class(source.type.get()) != H5T_INTEGER) impl_->file.fail(source.what, "expected an integer");
  check_scalar(impl_->file, source);
  std::int64_t value = 0;
  if (H5Aread(source.object.get(), H5T_NATIVE_INT64, &value) < 0) {
    impl_->file.fail(source.what, "cannot be read: " + hdf5::last_reason());
  }
  return value;
}

double Hdf5Reader::number_attribute(const std::string& object, const std::string& name) const {
  const Session session;
  const Source source = hdf5::open_attribute(impl_->file, hdf5::absolute(object), name);
  check_scalar(impl_->file, source);
  hdf5::check_doubles(impl_->file, source);
  double value = 0.0;
  hdf5::read_doubles(impl_->file, source, {&value, 1});
  return value;
}

double Hdf5Reader::finite_attribute(const std::string& object, const std::string& name) const {
  const double value = number_attribute(object, name);
  if (std::isfinite(value)) return value;
  throw error(object, name + " is " + number_text(value) + ", expected a finite number");
}

std::vector<double> Hdf5Reader::numbers_attribute(const std::string& object, const std::string& name) const {
  const Session session;
  const Source source = hdf5::open_attribute(impl_->file, hdf5::absolute(object), name);
  if (!source.dimensions.empty()) check_rank(impl_->file, source, 1);
  hdf5::check_doubles(impl_->file, source);
  std::vector<double> values(source.elements());
  hdf5::read_doubles(impl_->file, source, values);
  return values;
}

std::vector<Eigen::Index> Hdf5Reader::shape(const std::string& dataset) const {
  const Session session;
  const Source source = hdf5::open_dataset(impl_->file, hdf5::absolute(dataset));
  std::vector<Eigen::Index> sizes;
  for (const hsize_t size : source.dimensions) sizes.push_back(static_cast<Eigen::Index>(size));
  return sizes;
}

Eigen::VectorXd Hdf5Reader::vector(const std::string& dataset, const DatasetExpectation& expectation) const {
  const Session session;
  const hdf5::File& file = impl_->file;
  const Source source = hdf5::open_dataset(file, hdf5::absolute(dataset));
  check_rank(file, source, 1);
  check_extent(file, source, 0, expectation.rows);
  hdf5::check_doubles(file, source);
  Eigen::VectorXd values(static_cast<Eigen::Index>(source.elements()));
  const std::span<double> elements(values.data(), source.elements());
  hdf5::read_doubles(file, source, elements);
  if (expectation.finite) check_finite(file, source, elements);
  return values;
}

Eigen::MatrixXd Hdf5Reader::matrix(const std::string& dataset, const DatasetExpectation& expectation) const {
  const Session session;
  const hdf5::File& file = impl_->file;
  const Source source = hdf5::open_dataset(file, hdf5::absolute(dataset));
  check_rank(file, source, 2);
  check_extent(file, source, 0, expectation.rows);
  check_extent(file, source, 1, expectation.columns);
  hdf5::check_doubles(file, source);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows_first(
      static_cast<Eigen::Index>(source.dimensions[0]), static_cast<Eigen::Index>(source.dimensions[1]));
  const std::span<double> elements(rows_first.data(), source.elements());
  hdf5::read_doubles(file, source, elements);
  if (expectation.finite) check_finite(file, source, elements);
  return rows_first;
}

Hdf5Block Hdf5Reader::block(const std::string& dataset, const DatasetExpectation& expectation) const {
  const Session session;
  const hdf5::File& file = impl_->file;
  const Source source = hdf5::open_dataset(file, hdf5::absolute(dataset));
  check_rank(file, source, 3);
  check_extent(file, source, 0, expectation.rows);
  check_extent(file, source, 1, expectation.columns);
  hdf5::check_doubles(file, source);
  Hdf5Block block;
  for (std::size_t k = 0; k < 3; ++k) block.size[k] = static_cast<Eigen::Index>(source.dimensions[k]);
  block.values.resize(source.elements());
  hdf5::read_doubles(file, source, block.values);
  if (expectation.finite) check_finite(file, source, block.values);
  return block;
}

std::vector<std::string> Hdf5Reader::texts(const std::string& dataset) const {
  const Session session;
  const Source source = hdf5::open_dataset(impl_->file, hdf5::absolute(dataset));
  check_rank(impl_->file, source, 1);
  return hdf5::read_strings(impl_->file, source);
}

InputError Hdf5Reader::error(const std::string& object, const std::string& sentence) const {
  return InputError(impl_->file.name, object + ": " + sentence);
}

bool is_hdf5_with(const std::filesystem::path& path, std::string_view mark) {
  constexpr std::size_t kPart = std::size_t{1} << 20;
  std::ifstream stream(path, std::ios::binary);
  std::string bytes;
  bool is_beginning = true;
  while (stream) {
    // The mark may begin in the part before.
    bytes.erase(0, bytes.size() - std::min(bytes.size(), mark.size()));
    const std::size_t kept = bytes.size();
    bytes.resize(kept + kPart);
    stream.read(bytes.data() + kept, static_cast<std::streamsize>(kPart));
    bytes.resize(kept + static_cast<std::size_t>(stream.gcount()));
    if (is_beginning && !bytes.starts_with(kSignature)) return false;
    is_beginning = false;
    if (bytes.find(mark) != std::string::npos) return true;
  }
  return false;
}

}  // namespace samara::io
