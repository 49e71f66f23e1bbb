#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "samara/base/errors.h"

/// Reading of HDF5 files that may be damaged, truncated, of another program, or malicious.
///
/// What is asked for must exist with the kind and shape asked for, complete and with right checksums:
/// anything else is an InputError of one sentence that names file and object. Sizes are checked against the
/// size of the file before memory is taken. Files must have a superblock of version 2 or later (Hdf5Writer;
/// h5py with `libver="latest"`), because older ones carry no checksums in their metadata. Only hard links are
/// followed, so that a file cannot name others. Strings must have a fixed size: those of variable length lie
/// in a heap without checksums. Nothing is read before it is asked for.
namespace samara::io {

/// What a dataset must look like. The default: any size, all values finite.
struct DatasetExpectation {
  std::optional<Eigen::Index> rows = {};     ///< size of the first dimension
  std::optional<Eigen::Index> columns = {};  ///< size of the second dimension, where there is one
  bool finite = true;                        ///< refuse NaN and infinities
};

/// Numbers in three dimensions, the last index running fastest.
struct Hdf5Block {
  std::array<Eigen::Index, 3> size = {};
  std::vector<double> values;
};

/// An open file. It may be shared between threads; all access to HDF5 goes through one lock.
///
/// Paths begin at the root, with or without a slash.
/// @throws InputError, from all functions but has() and has_attribute(), as the head of this file says;
/// ArgumentError for a path with empty names, "." or "..".
class Hdf5Reader {
 public:
  /// @param expected what the file should be, in the message of one that is not HDF5: "a codebook"
  /// @throws InputError if the file is missing, a directory, not HDF5, truncated, or without checksums.
  explicit Hdf5Reader(const std::filesystem::path& path, const std::string& expected = "");
  ~Hdf5Reader();
  Hdf5Reader(Hdf5Reader&&) noexcept;
  Hdf5Reader& operator=(Hdf5Reader&&) noexcept;

  /// The file, as it was given.
  const std::string& file() const;

  bool has(const std::string& path) const;
  bool has_attribute(const std::string& object, const std::string& name) const;
  /// Names of the members of a group, sorted by their bytes.
  std::vector<std::string> children(const std::string& group) const;

  /// A string of a fixed size.
  std::string text_attribute(const std::string& object, const std::string& name) const;
  std::int64_t integer_attribute(const std::string& object, const std::string& name) const;
  /// Integers are taken as well, and values that are not finite pass, here and in numbers_attribute().
  double number_attribute(const std::string& object, const std::string& name) const;
  /// The same, refusing NaN and infinities.
  double finite_attribute(const std::string& object, const std::string& name) const;
  /// A scalar counts as one number.
  std::vector<double> numbers_attribute(const std::string& object, const std::string& name) const;

  /// Sizes of the dimensions of a dataset.
  std::vector<Eigen::Index> shape(const std::string& dataset) const;
  /// A dataset of one dimension, of doubles or single floats.
  Eigen::VectorXd vector(const std::string& dataset, const DatasetExpectation& expectation = {}) const;
  /// A dataset of two dimensions, of doubles or single floats.
  Eigen::MatrixXd matrix(const std::string& dataset, const DatasetExpectation& expectation = {}) const;
  /// A dataset of three dimensions, of doubles or single floats.
  Hdf5Block block(const std::string& dataset, const DatasetExpectation& expectation = {}) const;
  /// A dataset of one dimension of strings of a fixed size.
  std::vector<std::string> texts(const std::string& dataset) const;

  /// An error that names file and object, for the caller to throw.
  InputError error(const std::string& object, const std::string& sentence) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Whether a file begins as HDF5 and holds these bytes, such as its format: true of a damaged one, too, which cannot
/// be opened.
bool is_hdf5_with(const std::filesystem::path& path, std::string_view mark);

}  // namespace samara::io
