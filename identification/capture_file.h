#pragma once

#include <filesystem>
#include <vector>

#include "samara/identification/capture.h"

/// Reading captures from column files.
///
/// The canonical text form is CSV or TSV whose header names quantity and unit; empty cells are missing
/// values, lines that begin with `#` are comments:
///
///     t[s],x[m],theta[deg]
///     0.00,0.000,1.5
///     0.01,,1.7
///
/// Any other column file needs a sidecar, a TOML file that says what its columns are:
///
///     file = "tracks.csv"                # relative to the sidecar
///     delimiter = ";"                    # optional: ",", ";", "tab"
///     group_by = ["drop", "cam"]         # several captures in one file: one per combination of their cells
///     where = { cam = ["1"] }            # only rows with one of these cells
///     frame_rate = "60 Hz"               # if time is a frame number, unit "frame"
///     start = "first visible"            # or "as given"
///
///     [columns]                          # optional where the header is canonical
///     frame = { quantity = "t", unit = "frame" }
///     y_px = { quantity = "x", unit = "px" }
///
///     [scale]                            # of quantities in px, found for each capture
///     x = { length = "38 cm", over = "largest - first" }   # or "largest - smallest"
///     # x = { value = "0.7 mm/px" }      # negative where pixels count against the model's axis
///
/// With start = "first visible", the default, a capture begins at the first frame in which all its quantities
/// are visible, and times count from there: that frame is the model's t = 0. "as given" keeps all frames and
/// times.
///
/// In memory everything is in SI units (px stays px where no scale is given).
namespace samara::identification {

/// All captures of a file.
/// @param path a sidecar (*.toml), or a table. A table with a *.toml of the same stem beside it is read
///   through that sidecar; then `file` may be left out of it.
/// @throws InputError with file and line: columns that are missing, a header without units, times that are
///   missing or do not increase within a capture, cells that are not finite numbers, unknown keys, units of
///   the wrong dimension, fewer than 3 frames in a capture, a scale over no distance.
std::vector<Capture> read_captures(const std::filesystem::path& path);

}  // namespace samara::identification
