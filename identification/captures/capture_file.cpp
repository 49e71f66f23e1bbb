#include "samara/identification/captures/capture_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <numbers>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <sys/stat.h>

#include "samara/base/errors.h"
#include "samara/base/text.h"
#include "samara/identification/captures/capture_cleaning.h"
#include "samara/identification/captures/capture_table.h"
#include "samara/identification/captures/exports/export_formats.h"
#include "samara/identification/captures/frame_grid.h"
#include "samara/identification/captures/impact.h"
#include "samara/identification/captures/number_cells.h"
#include "samara/identification/captures/sidecar.h"
#include "samara/io/checksum.h"
#include "samara/io/text_file.h"

namespace samara::identification {

namespace {

constexpr const char* kTable = "a table";  // what a capture is, in messages

/// Before a plan that lies beside its codebook is read as the sidecar of a table.
void check_is_text(const std::filesystem::path& path) {
  std::array<char, 16> head = {};
  std::ifstream stream(path, std::ios::binary);
  stream.read(head.data(), head.size());
  const std::string kind =
      io::binary_kind({head.data(), static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0))});
  if (!kind.empty()) throw InputError(path.string(), fmt::format("is {}, expected {}", kind, kTable));
}

/// @param shared the sidecar of all tables; empty: there is none
Sidecar find_sidecar(const std::filesystem::path& path, const std::filesystem::path& shared = {}) {
  if (!is_table(path)) return read_sidecar(path);
  if (!shared.empty()) {
    Sidecar sidecar = read_sidecar(shared, path);
    sidecar.is_shared = true;
    return sidecar;
  }
  const std::filesystem::path beside = std::filesystem::path(path).replace_extension(".toml");
  std::error_code ignored;
  if (std::filesystem::is_regular_file(beside, ignored)) {
    if (std::filesystem::is_regular_file(path, ignored)) check_is_text(path);
    return read_sidecar(beside, path);
  }
  return {.table = path};
}

/// A file that a section of the sidecar names ("" for the root) and that is not there is the sidecar's fault.
void require_file(const Sidecar& sidecar, const std::string& section, const std::filesystem::path& path) {
  std::error_code unreadable;
  if (std::filesystem::exists(std::filesystem::status(path, unreadable))) return;
  throw sidecar.error(section, "file", fmt::format("there is no file \"{}\"", path.string()));
}

std::vector<Capture> read_exported(const Export& exported, const Sidecar& sidecar) {
  std::vector<Capture> captures;
  for (const ExportedBody& body : exported.bodies) {
    // A sidecar that names columns says itself what they are, and how the world lies.
    const bool is_own = sidecar.columns.empty();
    const bool takes_up = is_own && sidecar.up.empty() && !exported.up.empty();
    Sidecar of_body = sidecar;
    if (is_own) of_body.columns = body.columns;
    if (is_own && !body.name_column.empty()) of_body.where[body.name_column] = {body.name};
    if (takes_up) of_body.up = exported.up;
    for (Capture& capture : captures_from_table(exported.table, of_body)) {
      if (is_own) capture.labels["body"] = body.name;
      if (is_own && exported.bodies.size() > 1) capture.id += "/" + body.name;
      if (takes_up) {
        capture.notes.push_back(
            fmt::format("{}'s axis {} was taken to point up, and became z", exported.program, exported.up));
      }
      if (exported.short_rows > 0) {
        capture.notes.push_back(fmt::format(
            "{} of {} rows of the export are shorter than its header; what they lack counts as not seen",
            exported.short_rows, exported.rows));
      }
      captures.push_back(std::move(capture));
    }
    if (!is_own) break;
  }
  return captures;
}

std::string read_table_text(const Sidecar& sidecar) {
  if (sidecar.document && sidecar.document->has("file")) require_file(sidecar, "", sidecar.table);
  return io::read_text_file(sidecar.table, {.expected = kTable});
}

/// Where columns say their units, nothing would come of those that a sidecar names for an export without any.
void refuse_units_of_export(const Sidecar& sidecar) {
  for (const auto& [key, unit] :
       {std::pair{"length_unit", &sidecar.length_unit}, std::pair{"time_unit", &sidecar.time_unit}}) {
    if (!*unit) continue;
    throw sidecar.error(
        "", key,
        fmt::format("\"{}\" is for an export that names no units, and \"{}\" is read by its columns; their "
                    "units in the header, as in x[mm], or in [columns], were expected",
                    **unit, sidecar.table.filename().string()));
  }
}

std::vector<Capture> read_table(const std::string& text, const Sidecar& sidecar) {
  std::optional<Export> exported;
  if (sidecar.header.empty()) {
    exported = read_export(text, {.file = sidecar.table.string(),
                                  .length_unit = sidecar.length_unit,
                                  .time_unit = sidecar.time_unit,
                                  .has_columns = !sidecar.columns.empty()});
  }
  const bool is_shared = sidecar.is_shared || sidecar.tables.size() > 1;  // others may be exports
  if (!is_shared && (!exported || !sidecar.columns.empty())) refuse_units_of_export(sidecar);
  if (exported) return read_exported(*exported, sidecar);
  return captures_from_table(io::DelimitedTable::parse(text, sidecar.table.string(),
                                                       {sidecar.delimiter, sidecar.header, sidecar.decimal}),
                             sidecar);
}

/// Whether a cell names the same as a label: as a text, or as a number ("7" and "007").
bool is_same_name(const std::string& cell, const std::string& label) {
  const std::optional<double> a = number_in(cell), b = number_in(label);
  return a && b ? *a == *b : cell == label;
}

void add_labels(std::vector<Capture>& captures, const Sidecar& sidecar) {
  require_file(sidecar, "labels", sidecar.labels->file);
  const io::DelimitedTable table = io::DelimitedTable::read(sidecar.labels->file);
  const std::string& column = sidecar.labels->column;
  std::vector<std::string> names = table.texts(column);
  for (std::string& name : names) name = with_decimal_point(name, table.decimal());
  for (Capture& capture : captures) {
    const auto label = capture.labels.find(column);
    const std::string name =
        label == capture.labels.end() ? std::filesystem::path(capture.file).stem().string() : label->second;
    const auto is_its = [&](const std::string& n) { return is_same_name(n, name); };
    const auto row = std::ranges::find_if(names, is_its);
    if (row == names.end()) {
      capture.notes.push_back(fmt::format("\"{}\" has no row for it", table.file()));
      continue;
    }
    if (std::ranges::count_if(names, is_its) > 1) {
      throw sidecar.error(
          "labels", "file",
          fmt::format("\"{}\" has several rows for {} \"{}\"; one was expected", table.file(), column, name));
    }
    for (const std::string& other : table.header()) {
      if (other != column)
        capture.labels[other] = with_decimal_point(
            table.texts(other)[static_cast<std::size_t>(row - names.begin())], table.decimal());
    }
  }
}

/// Captures whose labels are among those that `where` allows.
void select_by_labels(std::vector<Capture>& captures, const Sidecar& sidecar) {
  for (auto [label, allowed] : sidecar.where) {
    if (!sidecar.has_label(label)) continue;
    const char decimal = io::DelimitedTable::read(sidecar.labels->file).decimal();
    for (std::string& value : allowed) value = with_decimal_point(value, decimal);
    std::erase_if(captures, [&label = label, &allowed = allowed](const Capture& capture) {
      const auto found = capture.labels.find(label);
      return found == capture.labels.end() || !is_allowed(found->second, allowed);
    });
  }
}

/// What goes around a circle jumps where it is complete, and no such frame is wrong.
std::map<std::string, double> periods_of(const Capture& capture, const CleaningSteps& steps) {
  std::map<std::string, double> periods = steps.periods;
  for (const Channel& channel : capture.channels) {
    if (is_angle(channel)) periods.try_emplace(channel.quantity, 2.0 * std::numbers::pi);
  }
  return periods;
}

Capture cleaned(Capture capture, const Sidecar& sidecar) {
  const CleaningSteps& steps = sidecar.clean;
  std::string step;
  try {
    step = "frame_grid";
    if (steps.frame_grid) capture = on_frame_grid(capture, steps.frame_period).capture;
    step = "before_impact";
    if (steps.impact) capture = before_impact(capture, {.jump = *steps.impact}).capture;
    step = "inside";
    for (const auto& [quantity, ends] : steps.inside)
      capture = while_inside(capture, quantity, ends.first, ends.second);
    step = "outliers";
    if (steps.outliers) {
      capture =
          without_outliers(capture, {.bandwidth = steps.bandwidth, .outlier_threshold = *steps.outliers},
                           periods_of(capture, steps))
              .capture;
    }
  } catch (const ArgumentError& error) {
    throw sidecar.error("clean", step, error.what());
  }
  return capture;
}

/// Captures without long gaps of the place and the attitude; all of one motion belong together.
std::vector<Capture> pieces_of(const std::vector<Capture>& captures, const Sidecar& sidecar) {
  std::vector<Capture> parts;
  for (const Capture& capture : captures) {
    std::vector<std::string> pose;
    for (const std::string name : {"x", "y", "z", "qw"}) {
      if (capture.has(name)) pose.push_back(name);
    }
    for (Capture& part : continuous_parts(capture, {.quantities = pose,
                                                   .longest_gap = *sidecar.clean.longest_gap,
                                                   .least_frames = std::max(3, sidecar.least_frames)})) {
      part.motion = capture.id;
      parts.push_back(std::move(part));
    }
  }
  return parts;
}

std::vector<Capture> read_all(Sidecar sidecar) {
  if (sidecar.tables.empty()) sidecar.tables = {sidecar.table};
  std::vector<Capture> captures;
  for (const std::filesystem::path& table : sidecar.tables) {
    sidecar.table = table;
    const std::string text = read_table_text(sidecar);
    const std::string checksum = fmt::format("{:016x}", io::fnv1a(text));
    for (Capture& capture : read_table(text, sidecar)) {
      capture.checksum = checksum;
      captures.push_back(std::move(capture));
    }
  }
  if (sidecar.labels) {
    add_labels(captures, sidecar);
    select_by_labels(captures, sidecar);
  }
  if (sidecar.clean.any()) {
    const auto clean = [sidecar](Capture capture) { return cleaned(std::move(capture), sidecar); };
    for (Capture& capture : captures) {
      Capture before = capture;
      capture = clean(std::move(capture));
      capture.before_cleaning =
          std::make_shared<const BeforeCleaning>(BeforeCleaning{std::move(before), clean, capture.times});
    }
  }
  if (sidecar.clean.longest_gap) captures = pieces_of(captures, sidecar);
  std::erase_if(captures,
                [&](const Capture& capture) { return capture.frame_count() < sidecar.least_frames; });
  return captures;
}

}  // namespace

std::vector<Capture> read_captures(const std::filesystem::path& path) {
  return read_all(find_sidecar(path));
}

namespace {

std::vector<std::filesystem::path> files_of(const Sidecar& sidecar, const std::filesystem::path& path) {
  std::vector<std::filesystem::path> files = sidecar.tables;
  if (files.empty()) files = {sidecar.table};
  files.push_back(path);
  if (sidecar.document) files.push_back(sidecar.document->file());
  if (sidecar.labels) files.push_back(sidecar.labels->file);
  return files;
}

}  // namespace

std::vector<std::filesystem::path> capture_files(const std::filesystem::path& path) {
  return files_of(find_sidecar(path), path);
}

std::vector<std::filesystem::path> capture_files(const std::filesystem::path& path,
                                                 const std::filesystem::path& sidecar) {
  return files_of(find_sidecar(path, sidecar), path);
}

bool is_table(const std::filesystem::path& path) {
  return ending_of(path) != ".toml";
}

void check_sidecar(const std::filesystem::path& sidecar, std::span<const std::filesystem::path> captures,
                   bool in_memory) {
  if (sidecar.empty() || std::ranges::any_of(captures, is_table)) return;
  if (captures.empty() && !in_memory) return;  // that there is no capture is said in its place
  throw ArgumentError(fmt::format(
      "--sidecar \"{}\" says what the columns of table files are, and every capture given is {}; a table "
      "file was expected",
      sidecar.string(),
      captures.empty() ? "in memory, where columns say it themselves" : "a sidecar itself"));
}

std::vector<Capture> read_captures(const std::filesystem::path& path, const std::filesystem::path& sidecar) {
  return read_all(find_sidecar(path, sidecar));
}

namespace {

/// What all names of a file have in common; of one that is not there, its name.
std::string place_of(const std::string& file) {
  struct stat there = {};
  if (::stat(file.c_str(), &there) != 0) return file;
  return fmt::format("{}:{}", there.st_dev, there.st_ino);
}

bool are_equal(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return a.size() == b.size() && (a.array() == b.array() || (a.array().isNaN() && b.array().isNaN())).all();
}

bool have_same_frames(const Capture& a, const Capture& b) {
  return are_equal(a.times, b.times) &&
         std::ranges::equal(a.channels, b.channels, [](const Channel& one, const Channel& other) {
           return one.quantity == other.quantity && are_equal(one.values, other.values);
         });
}

/// Captures of one file, by its names.
using CapturesByName = std::map<std::string, std::vector<const Capture*>>;

/// One with the same frames by another name of its file; null if there is none.
const Capture* by_another_name(const CapturesByName& known, const Capture& capture) {
  for (const auto& [file, captures] : known) {
    if (file == capture.file) continue;
    const auto found =
        std::ranges::find_if(captures, [&](const Capture* one) { return have_same_frames(*one, capture); });
    if (found != captures.end()) return *found;
  }
  return nullptr;
}

}  // namespace

void refuse_repeated(std::span<const Capture> captures, const std::string& how) {
  std::map<std::string, std::string> places;
  std::map<std::pair<std::string, std::string>, const Capture*> by_id;
  std::map<std::string, CapturesByName> by_place;
  for (const Capture& capture : captures) {
    if (capture.file.empty()) continue;
    const auto [at, is_new] = places.try_emplace(capture.file);
    if (is_new) at->second = place_of(capture.file);
    CapturesByName& known = by_place[at->second];
    const auto [named, is_first] = by_id.try_emplace({at->second, capture.id}, &capture);
    const Capture* before = is_first ? by_another_name(known, capture) : named->second;
    if (before != nullptr) {
      throw InputError(
          capture.file,
          fmt::format("capture \"{}\" is {} twice{}; each once was expected", capture.id, how,
                      before->file == capture.file ? ""
                                                   : fmt::format(", before as \"{}\" of {}, the same file",
                                                                 before->id, before->file)));
    }
    known[capture.file].push_back(&capture);
  }
}

bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code missing;
  return a == b || std::filesystem::equivalent(a, b, missing);
}

}  // namespace samara::identification
