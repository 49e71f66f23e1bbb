#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "samara/identification/captures/exports/column_meaning.h"
#include "samara/io/delimited_table.h"

// clang-format off
/// Exports of tracking programs, recognised by their content; internal to identification/.
///
/// An export is a table under a preamble. It is read as that table, with its own lines, and with the meaning
/// of its columns for each body in it.
///  - Tracker (Open Source Physics): the name of a point mass, then a header such as `t x y`; or `#multi:`,
///    the names of several masses above their columns, then the header. Delimited by tabs, semicolons or
///    commas; decimal commas are taken for points where the comma does not delimit. It names no units.
///  - Kinovea: the table `"Time","ball/0/X","ball/0/Y", ..` of all tracked points, delimited by commas or semicolons,
///    with decimal points or commas; or `#Kinovea Trajectory data export`, its text for gnuplot, where times may be
///    numbers or h:mm:ss:cc. It names no units, of time neither where that is a number.
///  - Motive (OptiTrack), format versions 1.1 to 1.25: `Format Version` and further keys with values, rows
///    for kind, name, (ID, parent) and component of each column, then `Frame, Time (Seconds), X, Y, Z, W, ...`.
// clang-format on
namespace samara::identification {

/// One body of an export.
struct ExportedBody {
  std::string name;
  std::vector<ColumnMeaning> columns;
  /// A column of names and this body's, where rows are of one body each; empty: rows are of all.
  std::string name_column = {};
};

struct Export {
  io::DelimitedTable table;
  std::vector<ExportedBody> bodies;
  std::string program;  ///< "Tracker", "Kinovea", "Motive"
  std::string up;       ///< the axis that is up by the program's convention; empty: not known
  int rows = 0;         ///< with something in them
  int short_rows = 0;   ///< of those, with fewer cells than the header: what they lack is missing
};

/// What a sidecar says of an export.
struct ExportHints {
  std::string file = {};                        ///< of the export, for located errors
  std::optional<std::string> length_unit = {};  ///< of exports that name none
  std::optional<std::string> time_unit = {};    ///< likewise
  bool has_columns = false;                     ///< it names columns with their units itself
};

/// @returns nothing if the text is no export
/// @throws InputError if it looks like one and is not, or if units are missing
std::optional<Export> read_export(std::string_view text, const ExportHints& hints);

}  // namespace samara::identification
