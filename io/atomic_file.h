#pragma once

#include <filesystem>
#include <string>
#include <string_view>

/// Writing files so that a reader sees the old content or the new, and never a part.
///
/// The content goes to a temporary file in the same directory (`.samara-...tmp`), is flushed to the disk and
/// then renamed. A path that cannot be written is a mistake of the call, so all failures here are
/// ArgumentErrors.
namespace samara::io {

/// A temporary file that becomes the final one on commit() and is removed otherwise.
class PendingFile {
 public:
  /// Creates the temporary file, empty. Symbolic links are followed: the file they lead to will be replaced,
  /// or created. One that is replaced keeps its permissions.
  /// @throws ArgumentError naming `final_path` if its directory does not exist or cannot be written, or if it
  /// is a directory or a device, or where stdout or stderr leads.
  explicit PendingFile(const std::filesystem::path& final_path);
  ~PendingFile();
  PendingFile(PendingFile&& other) noexcept;
  PendingFile& operator=(PendingFile&& other) noexcept;

  /// The temporary file, to be written by whoever holds this object.
  const std::filesystem::path& path() const { return temporary_; }
  /// The path as the caller gave it.
  const std::filesystem::path& final_path() const { return given_; }

  /// Replaces the content of the temporary file.
  /// @throws ArgumentError with the system's reason, such as a full disk, or after commit().
  void write(std::string_view content);

  /// Flushes the temporary file to the disk and renames it. Nothing may hold it open for writing any more.
  /// @throws ArgumentError if that fails (the temporary file is then removed on destruction), or after an
  /// earlier commit.
  void commit();

 private:
  void discard() noexcept;

  std::filesystem::path given_;
  std::filesystem::path target_;     // what given_ leads to
  std::filesystem::path temporary_;  // empty once committed or moved from
};

/// Whether write_text_atomically() could write there now, for callers with much to do before they have a
/// text.
/// @throws ArgumentError naming the path and the reason if not.
void require_writable(const std::filesystem::path& path);

/// Of a file that has one format whatever its name is: `fall.csv` must not hold a codebook. Capitals do not matter.
/// Names without an ending, or with one that is of no format here, are taken, and of all texts .txt.
/// @param ending of the format: .h5, .csv, .json, .toml, or .txt for text to read
/// @throws ArgumentError for a name with the ending of another format
void require_name_of_format(const std::filesystem::path& path, std::string_view ending);

/// Replaces or creates the file. Pipes and devices (/dev/stdout, /dev/null) are written directly; so is a file that
/// stdout, stderr or the descriptor named (/dev/fd/3) leads to: what stands in it already stays.
/// @throws ArgumentError naming the path and the reason if it cannot be written.
void write_text_atomically(const std::filesystem::path& path, std::string_view text);

}  // namespace samara::io
