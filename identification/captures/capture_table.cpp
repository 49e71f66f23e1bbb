#include "samara/identification/captures/capture_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "samara/base/limits.h"
#include "samara/base/names.h"
#include "samara/identification/captures/capture_axes.h"
#include "samara/identification/captures/table_columns.h"

namespace samara::identification {

namespace {

using Rows = std::vector<std::size_t>;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// The rows of one capture, in the order of the file.
struct Group {
  std::vector<std::string> cells;  ///< of the columns of group_by
  Rows rows;
  Rows left_out;  ///< by `where`, after the first of its rows
};

std::string file_stem(const io::DelimitedTable& table) {
  return std::filesystem::path(table.file()).stem().string();
}

/// The cells of a column that the sidecar names in `key`.
std::vector<std::string> named_cells(const io::DelimitedTable& table, const Sidecar& sidecar,
                                     const std::string& section, const std::string& key,
                                     const std::string& column) {
  if (!table.has(column)) {
    throw sidecar.error(section, key,
                        fmt::format("\"{}\" has no column \"{}\"{}", table.file(), column,
                                    suggestion(column, table.header())));
  }
  return table.texts(column);
}

/// Rows whose cells are among those that `where` allows.
Rows selected_rows(const io::DelimitedTable& table, const Sidecar& sidecar) {
  Rows rows(table.rows());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  for (auto [column, allowed] : sidecar.where) {
    // Labels of captures are looked at when they are known.
    if (!table.has(column) && sidecar.has_label(column)) continue;
    std::vector<std::string> cells = named_cells(table, sidecar, "where", column, column);
    for (std::string& cell : cells) cell = with_decimal_point(cell, table.decimal());
    for (std::string& value : allowed) {
      value = with_decimal_point(value, table.decimal());
      if (std::ranges::any_of(cells, [&](const std::string& cell) { return is_allowed(cell, {value}); }))
        continue;
      throw sidecar.error("where", column,
                          fmt::format("no row of \"{}\" has \"{}\" there", table.file(), value));
    }
    std::erase_if(rows,
                  [&cells, &allowed = allowed](std::size_t row) { return !is_allowed(cells[row], allowed); });
  }
  return rows;
}

/// One group per combination of cells, in the order in which they first appear.
std::vector<Group> group_rows(const io::DelimitedTable& table, const Sidecar& sidecar) {
  std::vector<std::vector<std::string>> columns;
  for (const std::string& column : sidecar.group_by) {
    columns.push_back(named_cells(table, sidecar, "", "group_by", column));
  }
  std::vector<Group> groups;
  std::map<std::vector<std::string>, std::size_t> place;
  const Rows selected = selected_rows(table, sidecar);
  auto next = selected.begin();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    std::vector<std::string> cells;
    for (const auto& column : columns) cells.push_back(column[row]);
    if (next == selected.end() || *next != row) {
      if (const auto group = place.find(cells); group != place.end())
        groups[group->second].left_out.push_back(row);
      continue;
    }
    ++next;
    const auto [found, is_new] = place.try_emplace(cells, groups.size());
    if (is_new) groups.push_back({cells, {}, {}});
    groups[found->second].rows.push_back(row);
  }
  if (groups.empty())
    throw InputError(table.file(), table.line_of_header(), "there are no rows below the header");
  return groups;
}

Eigen::VectorXd picked(const Eigen::VectorXd& column, const Rows& rows) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    values[static_cast<Eigen::Index>(k)] = column[static_cast<Eigen::Index>(rows[k])];
  }
  return values;
}

/// Times in s; frame numbers over the rate where there is no column for them.
Eigen::VectorXd times_of(const Columns& columns, const Sidecar& sidecar, const Rows& rows) {
  if (columns.time) return picked(columns.time->values, rows);
  const auto count = static_cast<Eigen::Index>(rows.size());
  return Eigen::ArrayXd::LinSpaced(count, 0.0, static_cast<double>(count - 1)) / *sidecar.frame_rate;
}

/// Without a column of times rows that are not there take no time. Whether they were frames of the motion, or those
/// of another camera between its own, only the reader knows.
void note_frames_left_out(Capture& capture, const Group& group) {
  const auto between =
      std::ranges::count_if(group.left_out, [&](std::size_t row) { return row < group.rows.back(); });
  if (between == 0) return;
  capture.notes.push_back(
      fmt::format("{} rows that `where` leaves out lie between its frames, which are numbered without them; "
                  "if those were frames of this motion, a column of times is needed",
                  between));
}

/// The rows between `from` and `until`.
void keep_interval(Rows& rows, Eigen::VectorXd& times, const Sidecar& sidecar) {
  if (!sidecar.from && !sidecar.until) return;
  const double begin = sidecar.from.value_or(-std::numeric_limits<double>::infinity());
  const double end = sidecar.until.value_or(std::numeric_limits<double>::infinity());
  Rows kept;
  std::vector<double> kept_times;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double time = times[static_cast<Eigen::Index>(k)];
    if (time < begin || time > end) continue;
    kept.push_back(rows[k]);
    kept_times.push_back(time);
  }
  rows = std::move(kept);
  times = Eigen::Map<const Eigen::VectorXd>(kept_times.data(), static_cast<Eigen::Index>(kept_times.size()));
}

/// Drops rows whose time is that of the row before, if the sidecar says so. @returns how many
std::size_t drop_repeated(Rows& rows, Eigen::VectorXd& times, const Sidecar& sidecar) {
  if (!sidecar.keep_first_of_repeated_times) return 0;
  Rows kept;
  std::vector<double> kept_times;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double time = times[static_cast<Eigen::Index>(k)];
    if (!kept_times.empty() && time == kept_times.back()) continue;
    kept.push_back(rows[k]);
    kept_times.push_back(time);
  }
  const std::size_t dropped = rows.size() - kept.size();
  rows = std::move(kept);
  times = Eigen::Map<const Eigen::VectorXd>(kept_times.data(), static_cast<Eigen::Index>(kept_times.size()));
  return dropped;
}

/// Times must be there and increase.
void check_times(const io::DelimitedTable& table, const std::string& column, const Rows& rows,
                 const Eigen::VectorXd& times) {
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    if (std::isnan(times[at]))
      throw table.error(rows[k], fmt::format("column \"{}\": the time is missing", column));
    if (k > 0 && times[at] <= times[at - 1]) {
      throw table.error(
          rows[k], fmt::format("time {} s follows {} s; times that increase within a capture were expected",
                               times[at], times[at - 1]));
    }
  }
}

void check_sizes(const io::DelimitedTable& table, const Column& column, const Rows& rows) {
  for (const std::size_t row : rows) {
    const double value = column.values[static_cast<Eigen::Index>(row)];
    if (!(std::abs(value) > kLargestInput)) continue;
    throw table.error(row, fmt::format("column \"{}\" has {} {}; at most {} in size was expected",
                                       column.name, value, column.unit, kLargestInput));
  }
}

/// Number of frames before the first in which all channels are visible; all frames if there is none.
Eigen::Index frames_before_visible(const Capture& capture) {
  for (Eigen::Index frame = 0; frame < capture.times.size(); ++frame) {
    if (std::ranges::none_of(capture.channels,
                             [&](const Channel& c) { return std::isnan(c.values[frame]); })) {
      return frame;
    }
  }
  return capture.times.size();
}

void begin_at_first_visible(Capture& capture, Rows& rows) {
  const Eigen::Index skipped = frames_before_visible(capture);
  const Eigen::Index left = capture.times.size() - skipped;
  if (left > 0) {
    capture.start = capture.times[skipped];
    capture.times = (capture.times.tail(left).array() - capture.start).eval();
  }
  if (left == 0) capture.times.resize(0);
  for (Channel& channel : capture.channels) channel.values = channel.values.tail(left).eval();
  if (left > 0) rows.erase(rows.begin(), rows.begin() + skipped);
}

/// Cells of the rows that say in words that nothing was seen.
std::size_t missing_words(const io::DelimitedTable& table, const Column& column, const Rows& rows) {
  return static_cast<std::size_t>(std::ranges::count_if(rows, [&](std::size_t row) {
    return std::isnan(column.values[static_cast<Eigen::Index>(row)]) && !table.is_empty(row, column.name);
  }));
}

Eigen::Index visible_frames(const Capture& capture) {
  Eigen::Index count = 0;
  for (Eigen::Index frame = 0; frame < capture.times.size(); ++frame) {
    if (std::ranges::any_of(capture.channels, [&](const Channel& c) { return !std::isnan(c.values[frame]); }))
      ++count;
  }
  return count;
}

/// Metres per pixel of one track.
double track_scale(const Eigen::VectorXd& pixels, const PixelScale& scale, const InputError& no_span) {
  if (!scale.span) return scale.value;
  double first = kMissing;
  double smallest = std::numeric_limits<double>::infinity();
  double largest = -smallest;
  for (const double value : pixels) {
    if (std::isnan(value)) continue;
    if (std::isnan(first)) first = value;
    smallest = std::min(smallest, value);
    largest = std::max(largest, value);
  }
  const double span = largest - (*scale.span == ScaleSpan::largest_minus_first ? first : smallest);
  if (!(span > 0.0)) throw no_span;
  return scale.length / span;
}

/// Takes the channels in px that have a scale to metres.
void apply_scales(Capture& capture, const Sidecar& sidecar) {
  const std::string metre = "m";
  for (Channel& channel : capture.channels) {
    const auto scale = sidecar.scales.find(channel.quantity);
    if (scale == sidecar.scales.end()) continue;
    const InputError no_span =
        sidecar.error("scale", channel.quantity,
                      fmt::format("capture \"{}\" spans no distance in \"{}\", so that it has no scale",
                                  capture.id, channel.quantity));
    channel.metres_per_pixel = track_scale(channel.values, scale->second, no_span);
    channel.values *= *channel.metres_per_pixel;
    channel.unit = metre;
  }
}

Capture read_group(const io::DelimitedTable& table, const Columns& columns, const Sidecar& sidecar,
                   const Group& group) {
  Capture capture;
  capture.id = group.cells.empty() ? file_stem(table) : fmt::format("{}", fmt::join(group.cells, "/"));
  capture.file = table.file();
  for (std::size_t k = 0; k < group.cells.size(); ++k)
    capture.labels[sidecar.group_by[k]] = with_decimal_point(group.cells[k], table.decimal());
  Rows rows = group.rows;
  capture.times = times_of(columns, sidecar, rows);
  if (!columns.time) note_frames_left_out(capture, group);
  keep_interval(rows, capture.times, sidecar);
  if (const std::size_t dropped = drop_repeated(rows, capture.times, sidecar); dropped > 0)
    capture.notes.push_back(fmt::format("{} frames dropped whose time is that of the frame before", dropped));
  if (columns.time) {
    check_sizes(table, *columns.time, rows);
    check_times(table, columns.time->name, rows, capture.times);
  }
  std::size_t words = 0;
  for (const auto* some : {&columns.measured, &columns.euler}) {
    for (const Column& column : *some) {
      check_sizes(table, column, rows);
      words += missing_words(table, column, rows);
      capture.channels.push_back({column.quantity, column.unit, picked(column.values, rows)});
    }
  }
  if (words > 0) capture.notes.push_back(fmt::format("{} cells with NaN or NA count as not seen", words));
  if (sidecar.start == CaptureStart::first_visible) begin_at_first_visible(capture, rows);
  if (const Eigen::Index frames = visible_frames(capture); frames < 3) {
    throw table.error(rows.empty() ? group.rows.front() : rows.front(),
                      fmt::format("capture \"{}\" has {} frames with something visible; at least 3 were "
                                  "expected",
                                  capture.id, frames));
  }
  apply_scales(capture, sidecar);
  std::string key;
  try {
    key = "attitude";
    if (sidecar.euler) angles_to_quaternion(capture, sidecar.euler->columns, sidecar.euler->order);
    key = "flip";
    flip_quantities(capture, sidecar.flip);
    key = "up";
    if (!sidecar.up.empty()) turn_upright(capture, sidecar.up);
  } catch (const ArgumentError& error) {
    throw sidecar.error("", key, error.what());
  }
  return capture;
}

}  // namespace

std::vector<Capture> captures_from_table(const io::DelimitedTable& table, const Sidecar& sidecar) {
  const Columns columns = read_columns(table, sidecar);
  std::vector<Capture> captures;
  for (const Group& group : group_rows(table, sidecar)) {
    captures.push_back(read_group(table, columns, sidecar, group));
  }
  return captures;
}

}  // namespace samara::identification
