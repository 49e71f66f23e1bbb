#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// A file of records, to which records are added at its end: adding one costs its own size, whatever is there.
///
/// A record counts once it is whole: with its length and checksum in front of it. What a kill or a power cut leaves
/// of one is not read, and overwritten by the next. Numbers are in the byte order of the machine.
namespace samara::codebooks {

/// Whether a file begins as one; false where it cannot be read.
bool is_journal(const std::filesystem::path& path);

class Journal {
 public:
  /// Replaces or creates the file, at once (see io::PendingFile). @throws ArgumentError if it cannot be written
  Journal(const std::filesystem::path& path, const std::vector<std::string>& records);

  /// Opens a file, to go on after its last whole record.
  /// @param records those that are whole, in their order: what follows one that is not is left out
  /// @throws InputError if the file cannot be read, or is no journal
  Journal(const std::filesystem::path& path, std::vector<std::string>* records);

  /// Adds a record, which has reached the disk then.
  /// @throws ArgumentError if it cannot be written; then the file is as it was
  void append(std::string_view record);

  /// Whether the file is what this object has left; else another has written there, or removed it.
  bool is_as_left() const;

  /// Of the file, in bytes.
  std::uint64_t size() const { return size_; }

 private:
  void remember_file();

  std::filesystem::path path_;
  std::uint64_t size_ = 0;        ///< up to the end of the last whole record
  std::uint64_t found_size_ = 0;  ///< of the file, what is not whole included
  std::uint64_t inode_ = 0;
};

}  // namespace samara::codebooks
