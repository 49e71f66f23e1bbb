#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

/// Writing of HDF5 files for readers other than ourselves: plain groups, attributes and datasets, dimension
/// scales, little-endian doubles and integers of 64 bits, fixed-size null-terminated strings (ASCII where
/// possible, else UTF-8), no compound types. Metadata carry checksums, and datasets that are not empty are
/// chunked, shuffled, deflated and given fletcher32 checksums. No times are stored: the same calls give the
/// same bytes.
///
///     Hdf5Writer file("book.h5");
///     file.write_text_attribute("/", "format", "samara-codebook");
///     file.write_vector("/axes/t", times);
///     file.make_scale("/axes/t", "t");
///     file.write_matrix("/x", values);
///     file.attach_scale("/x", 0, "/axes/t");
///     file.commit();
namespace samara::io {

/// One new file. It is put together in memory and appears under its name, replacing an older one, on
/// commit(); without, nothing is left.
///
/// Paths begin at the root, with or without a slash. Groups on the way to a dataset are made as needed.
/// Every function throws ArgumentError, naming file and object, if the name is taken, the object does not
/// exist or the file cannot be written, and after commit(). Objects of this class may be used from one thread
/// at a time.
class Hdf5Writer {
 public:
  /// @throws ArgumentError if a file cannot be written there.
  explicit Hdf5Writer(const std::filesystem::path& path);
  ~Hdf5Writer();
  Hdf5Writer(Hdf5Writer&&) noexcept;
  Hdf5Writer& operator=(Hdf5Writer&&) noexcept;

  /// Does nothing if the group exists.
  void create_group(const std::string& path);

  void write_text_attribute(const std::string& object, const std::string& name, std::string_view value);
  void write_integer_attribute(const std::string& object, const std::string& name, std::int64_t value);
  void write_number_attribute(const std::string& object, const std::string& name, double value);
  void write_numbers_attribute(const std::string& object, const std::string& name,
                               std::span<const double> values);

  /// One dimension.
  void write_vector(const std::string& path, const Eigen::Ref<const Eigen::VectorXd>& values);
  /// Two dimensions, rows first, row-major in the file.
  void write_matrix(const std::string& path, const Eigen::Ref<const Eigen::MatrixXd>& values);
  /// Three dimensions. @param values size[0] x size[1] x size[2] of them, the last index running fastest
  void write_block(const std::string& path, const std::array<Eigen::Index, 3>& size,
                   std::span<const double> values);
  /// One dimension of strings. @throws ArgumentError also for a text with a zero byte.
  void write_texts(const std::string& path, const std::vector<std::string>& texts);

  /// Declares a dataset of one dimension to be a dimension scale of this name.
  void make_scale(const std::string& dataset, const std::string& name);
  /// Says that the scale holds the coordinates along `dimension` (from 0) of the dataset.
  void attach_scale(const std::string& dataset, unsigned dimension, const std::string& scale);

  /// Closes, writes and renames.
  void commit();

 private:
  struct Impl;
  Impl& open_file() const;

  std::unique_ptr<Impl> impl_;
};

}  // namespace samara::io
