#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "samara/base/units.h"
#include "samara/identification/captures/exports/column_meaning.h"
#include "samara/io/toml_document.h"

/// What the columns of a table mean; internal to identification/.
namespace samara::identification {

enum class ScaleSpan { largest_minus_first, largest_minus_smallest };

/// How pixels become metres: by a value, or by a length over a span of the track.
struct PixelScale {
  double value = 0.0;   ///< m/px, if there is no span
  double length = 0.0;  ///< m, over the span
  std::optional<ScaleSpan> span = {};
};

enum class CaptureStart { first_visible, as_given };

/// Three angles whose rotations, one after the other about axes that turn along, take world axes to the
/// body's: with the order "zyx", R_WB = R_z(first) R_y(second) R_x(third).
struct EulerColumns {
  std::vector<std::string> columns;
  std::string order;  ///< of "x", "y", "z"; no axis twice in a row
  Unit unit;
};

/// Steps of capture_cleaning.h, in this order.
struct CleaningSteps {
  bool frame_grid = false;
  std::optional<double> frame_period = {};                       ///< s, of that grid; empty: fitted
  std::optional<double> impact = {};                             ///< m/s
  std::map<std::string, std::pair<double, double>> inside = {};  ///< m, lower and upper
  std::optional<double> outliers = {};                           ///< standard deviations
  std::optional<double> bandwidth = {};                          ///< s, for outliers
  std::optional<double> longest_gap = {};                        ///< s, where a capture is cut into parts
  /// Of quantities that go around a circle, SI. Angles have a turn unless another is given.
  std::map<std::string, double> periods = {};

  bool any() const { return frame_grid || impact || outliers || longest_gap || !inside.empty(); }
};

/// A table with a row for each capture, whose cells become labels.
struct LabelTable {
  std::filesystem::path file;
  std::string column;  ///< holds the capture's label of this name, or the stem of its file
};

struct Sidecar {
  std::filesystem::path table = {};
  std::vector<std::filesystem::path> tables = {};  ///< those that `table` stands for, if it is a pattern
  bool is_shared = false;                          ///< whether it is the sidecar of other tables, too
  std::vector<std::string> header = {};            ///< names of the columns of a file without a header
  char delimiter = 0;                              ///< 0: found from the header
  char decimal = 0;                                ///< '.' or ','; 0: found from the cells
  std::vector<ColumnMeaning> columns = {};         ///< empty: the header is canonical
  std::vector<std::string> group_by = {};
  std::map<std::string, std::vector<std::string>> where = {};  ///< see is_allowed()
  std::optional<double> frame_rate = {};                       ///< frames per second
  int least_frames = 0;                                        ///< captures with fewer are left out
  std::map<std::string, PixelScale> scales = {};
  CaptureStart start = CaptureStart::first_visible;
  std::optional<double> from = {};   ///< s, in the times of the table
  std::optional<double> until = {};  ///< s
  bool keep_first_of_repeated_times = false;
  std::vector<std::string> flip = {};           ///< quantities that count the other way
  std::string up = {};                          ///< "y", "-z"; empty: z
  std::optional<std::string> length_unit = {};  ///< of exports that name none
  std::optional<std::string> time_unit = {};    ///< likewise
  std::optional<EulerColumns> euler = {};
  CleaningSteps clean = {};
  std::optional<LabelTable> labels = {};
  /// The file itself, for located errors; none for a bare table.
  std::optional<io::TomlTable> document = {};

  /// Whether the table of labels has such a column.
  bool has_label(const std::string& column) const;

  /// An error about a key of a section ("" for the root), for the caller to throw.
  InputError error(const std::string& section, const std::string& key, const std::string& sentence) const;
};

/// Of a cell "1,5", where the decimal sign is a comma, "1.5"; all else as it is.
std::string with_decimal_point(const std::string& cell, char decimal);

/// Whether a cell is among texts, of which "< 2" and "> 0.5" stand for all numbers below or above.
bool is_allowed(const std::string& cell, const std::vector<std::string>& allowed);

/// @param table the table that it describes; empty if the sidecar itself names one. May have a `*` in its
/// name.
/// @throws InputError as read_captures()
Sidecar read_sidecar(const std::filesystem::path& path, const std::filesystem::path& table = {});

}  // namespace samara::identification
