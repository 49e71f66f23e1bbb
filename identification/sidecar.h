#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "samara/io/toml_document.h"
#include "samara/io/units.h"

/// What the columns of a table mean; internal to identification/.
namespace samara::identification {

/// A column that holds a measured quantity, or time ("t").
struct ColumnMeaning {
  std::string column;
  std::string quantity;
  io::Unit unit;
};

enum class ScaleSpan { largest_minus_first, largest_minus_smallest };

/// How pixels become metres: by a value, or by a length over a span of the track.
struct PixelScale {
  double value = 0.0;   ///< m/px, if there is no span
  double length = 0.0;  ///< m, over the span
  std::optional<ScaleSpan> span = {};
};

enum class CaptureStart { first_visible, as_given };

/// The name of the time column's quantity.
inline constexpr const char* kTimeQuantity = "t";

struct Sidecar {
  std::filesystem::path table = {};
  char delimiter = 0;                       ///< 0: found from the header
  std::vector<ColumnMeaning> columns = {};  ///< empty: the header is canonical
  std::vector<std::string> group_by = {};
  std::map<std::string, std::vector<std::string>> where = {};
  std::optional<double> frame_rate = {};  ///< frames per second
  std::map<std::string, PixelScale> scales = {};
  CaptureStart start = CaptureStart::first_visible;
  /// The file itself, for located errors; none for a bare table.
  std::optional<io::TomlTable> document = {};

  /// An error about a key of a section ("" for the root), for the caller to throw.
  InputError error(const std::string& section, const std::string& key, const std::string& sentence) const;
};

/// @param table the table it was found beside; empty if the sidecar itself was named
/// @throws InputError as read_captures()
Sidecar read_sidecar(const std::filesystem::path& path, const std::filesystem::path& table = {});

}  // namespace samara::identification
