#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"

// clang-format off
/// Reading captures from column files.
///
/// The canonical text form is CSV or TSV whose header names quantity and unit; empty cells, NaN and NA
/// are missing values, lines that begin with `#` are comments:
///
///     t[s],x[m],theta[deg]
///     0.00,0.000,1.5
///     0.01,,1.7
///
/// Any other column file needs a sidecar, a TOML file that says what its columns are (all keys but `columns`
/// may be left out):
///
///     file = "tracks.csv"                # relative to the sidecar; "flight_*.csv": every file that matches
///     decimal = ","                      # or "."; found where it is not named
///     delimiter = ";"                    # ",", ";", "tab"
///     header = ["time", "x"]             # names of the columns, where the file has none
///     group_by = ["drop", "cam"]         # several captures in one file: one per combination of their cells
///     where = { cam = ["1"] }            # only rows with one of these cells, or captures with such labels;
///                                        # "< 2" and "> 2" stand for numbers
///     least_frames = 12                  # captures with fewer, once cleaned, are left out
///     frame_rate = "60 Hz"               # if time is a frame number, unit "frame", or if there is no time
///     from = "0.5 s"                     # only frames from this time of the table
///     until = "2 s"
///     start = "first visible"            # or "as given"
///     repeated_times = "keep first"      # or "refuse", the default
///     flip = ["z"]                       # quantities that count the other way
///     up = "-z"                          # the axis that points up: the world is turned such that z does
///     length_unit = "cm"                 # of a program's export that names none
///     time_unit = "ms"                   # likewise
///
///     [columns]                          # not needed where the header is canonical, or for an export
///     frame = { quantity = "t", unit = "frame" }
///     y_px = { quantity = "x", unit = "px" }
///
///     [attitude]                         # angles that become qw, qx, qy, qz:
///     euler = ["yaw", "pitch", "roll"]   # R_WB = Rz(yaw) Ry(pitch) Rx(roll)
///     order = "zyx"
///     unit = "deg"
///
///     [scale]                            # of quantities in px, found for each capture
///     x = { length = "38 cm", over = "largest - first" }   # or "largest - smallest"
///     # x = { value = "0.7 mm/px" }      # negative where pixels count against the model's axis
///
///     [labels]                           # of captures, from a table with a row for each
///     file = "index.csv"
///     column = "drop"                    # the capture's cell of this name in group_by, or its file's stem
///
///     [clean]                            # see capture_cleaning.h; in this order
///     frame_grid = true                  # or the camera's frame period, "16.67 ms", if it is known
///     before_impact = "1.2 m/s"
///     inside = { z = ["3 cm", "3 m"] }   # ends before the first frame outside
///     outliers = 5
///     bandwidth = "0.1 s"                # of outliers
///     periods = { theta = "180 deg" }    # of outliers; angles have a turn
///     longest_gap = "35 ms"              # where place or attitude is not seen for longer, a part ends
///
/// With start = "first visible", the default, a capture begins at the first frame in which all its quantities
/// are visible, and times count from there: that frame is the model's t = 0, and Capture::start its time in the
/// table. "as given" keeps all frames and times.
///
/// Exports of Tracker (text: the name of a point mass, a header like "t x y", rows; or "#multi:" with
/// several) and of Motive (CSV, quaternions) are recognised by their content: a capture for each point mass
/// or rigid body, with the channels x, y, (z) and, for a rigid body, qw, qx, qy, qz, the names of a model's
/// states; so are Kinovea's (CSV of tracked points, text for gnuplot), with x and y of each point. Tracker and Kinovea
/// name no units: a sidecar with `length_unit`, and of Kinovea `time_unit`, does. Motive's y points up, which `up` can
/// override. With `columns` in its sidecar, an export is read as a table of the columns named there
/// ("card.Position.X" for Motive).
///
/// In memory everything is in SI units (px stays px where no scale is given).
// clang-format on
namespace samara::identification {

/// All captures of a file that `where` and `least_frames` leave; there may be none.
/// @param path a sidecar (*.toml), or a table. A table with a *.toml of the same stem beside it is read
///   through that sidecar; then `file` may be left out of it.
/// @throws InputError with file and line: columns that are missing, a header without units, times that are
///   missing or do not increase within a capture, cells that are not finite numbers, unknown keys, units of
///   the wrong dimension, fewer than 3 frames in a capture, a scale over no distance.
std::vector<Capture> read_captures(const std::filesystem::path& path);

/// The files that read_captures() would read there: tables, sidecar, labels. Also those that do not exist.
/// @throws InputError for a sidecar that cannot be read
std::vector<std::filesystem::path> capture_files(const std::filesystem::path& path);
/// The same of read_captures() with a sidecar for many tables.
std::vector<std::filesystem::path> capture_files(const std::filesystem::path& path,
                                                 const std::filesystem::path& sidecar);

/// Whether a capture file is a table, and no sidecar itself.
bool is_table(const std::filesystem::path& path);

/// The sidecar of many tables would do nothing where no capture is a table.
/// @param in_memory whether captures are given that are no files  @throws ArgumentError
void check_sidecar(const std::filesystem::path& sidecar, std::span<const std::filesystem::path> captures,
                   bool in_memory);

/// Captures of a table through a sidecar that does not name it: one for many tables.
/// @param path a table; a pattern ("[0-9]*.csv") stands for every file that matches. Labels are looked for beside it.
///   What is no table goes through itself
/// @param sidecar empty: as without
/// @throws InputError as above, and if the sidecar names another table
std::vector<Capture> read_captures(const std::filesystem::path& path, const std::filesystem::path& sidecar);

/// Captures that stand there twice would count twice: those of one id in one file, however it is spelled and whatever
/// links lead to it, and those of two names of one file with the same frames. Captures of no file may be any.
/// @param how they stand there: "given", "left out"
/// @throws InputError naming the file of the second one
void refuse_repeated(std::span<const Capture> captures, const std::string& how);

/// Whether two names, as captures have them of their files, are those of one file.
bool is_same_file(const std::string& a, const std::string& b);

}  // namespace samara::identification
