#include "samara/codebooks/file/load.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/codebooks/file/certificate_format.h"
#include "samara/codebooks/file/description_format.h"
#include "samara/codebooks/file/file_format.h"
#include "samara/codebooks/file/mesh_format.h"
#include "samara/codebooks/file/piece_format.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/memory_file.h"
#include "samara/models/fields/field_model.h"
#include "samara/models/interface/model.h"

namespace samara::codebooks {

namespace {

using io::Hdf5Reader;

void check_version(const Hdf5Reader& file) {
  const std::string kind = file.has_attribute("/", "format") ? file.text_attribute("/", "format") : "";
  if (kind != format::kFormat) {
    throw file.error("/", fmt::format("attribute format is {}not \"{}\": this is not a codebook",
                                      kind.empty() ? "" : fmt::format("\"{}\", ", kind), format::kFormat));
  }
  const std::string version = file.text_attribute("/", "format_version");
  int major = -1;
  int minor = -1;
  const char* end = version.data() + version.size();
  const auto first = std::from_chars(version.data(), end, major);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == '.') {
    const auto second = std::from_chars(first.ptr + 1, end, minor);
    if (second.ptr != end) minor = -1;
  }
  if (major != format::kMajor || minor < 0 || minor > format::kMinor) {
    throw file.error("/", fmt::format("format_version is \"{}\", this program reads {}.0 to {}.{}", version,
                                      format::kMajor, format::kMajor, format::kMinor));
  }
}

/// Outputs of the certificate in the order of the codebook; the file sorts them by name.
/// @throws InputError if they are not those of the codebook, or err most at no point of it
void order_outputs(const Hdf5Reader& file, Certificate& certificate, const Codebook& book) {
  const auto place = [&](const OutputError& o) {
    const auto& outputs = book.outputs();
    return std::find_if(outputs.begin(), outputs.end(),
                        [&](const auto& label) { return label.name == o.name; }) -
           outputs.begin();
  };
  std::stable_sort(certificate.outputs.begin(), certificate.outputs.end(),
                   [&](const OutputError& a, const OutputError& b) { return place(a) < place(b); });
  for (const OutputError& o : certificate.outputs) {
    if (!o.worst.empty() && o.worst.size() != book.coordinates().size()) {
      throw file.error("/certificate/" + o.name,
                       fmt::format("worst has {} numbers, expected {}, one per coordinate, or none",
                                   o.worst.size(), book.coordinates().size()));
    }
  }
  if (std::ranges::equal(certificate.outputs, book.outputs(), {}, &OutputError::name,
                         &pgd::OutputLabel::name))
    return;
  const auto names = [](const auto& outputs) {
    std::vector<std::string> list;
    for (const auto& output : outputs) list.push_back(output.name);
    return fmt::format("{}", fmt::join(list, ", "));
  };
  throw file.error("/certificate", fmt::format("is of the outputs {}, those of the codebook are {}",
                                               names(certificate.outputs), names(book.outputs())));
}

/// A unit in the file against that of the model.
void check_unit(const Hdf5Reader& file, const std::string& object, const std::string& unit,
                const std::string& expected) {
  if (unit == expected) return;
  throw file.error(object, fmt::format("units are \"{}\", those of the model \"{}\"", unit, expected));
}

/// Units of axes, outputs and fixed values, where this library knows the model.
void check_units(const Hdf5Reader& file, const Codebook& book) {
  const auto model = known_model(book.model());
  const models::FieldModel* field = models::find_field_model(book.model().name);
  if (!model && field == nullptr) return;
  const models::ModelInfo& info = model ? model->info() : field->info;
  std::map<std::string, std::string> units = {{book.coordinates().front().name, models::time_unit(info)}};
  if (field != nullptr) units[field->place] = "m";
  std::map<std::string, std::string> output_units;
  for (const auto& parameter : info.parameters) units[parameter.name] = parameter.unit;
  for (const auto& state : info.states) {
    units[state.name + "(0)"] = state.unit;
    output_units[state.name] = state.unit;
  }
  for (const Coordinate& c : book.coordinates()) {
    if (units.contains(c.name)) check_unit(file, "/pieces/0/axes/" + c.name, c.unit, units.at(c.name));
  }
  for (const pgd::OutputLabel& output : book.outputs()) {
    if (output_units.contains(output.name))
      check_unit(file, "/pieces/0/groups: " + output.name, output.unit, output_units.at(output.name));
  }
  for (const auto& [name, unit] : book.model().fixed_units) {
    if (units.contains(name)) check_unit(file, "/model/fixed/" + name, unit, units.at(name));
  }
}

/// Files up to this size are read at once, so that damage is found at the door, and so are those of one
/// piece; pieces of others when they are asked for.
constexpr std::uintmax_t kReadAtOnce = 1 << 20;

/// A piece that has nothing but its outline.
Piece outlined_piece(const PieceOutline& outline) {
  std::vector<double> lower, upper;
  for (const pgd::Axis& axis : outline.axes) {
    lower.push_back(axis.lower());
    upper.push_back(axis.upper());
  }
  return Piece(std::move(lower), std::move(upper), {}, [outline] { return outline; });
}

/// A piece that is read when it is asked for.
/// @param like a codebook of the outline of the first piece: others must be like it
/// @param known its outline, where it has been read
Piece deferred_piece(const std::shared_ptr<const Hdf5Reader>& file, const std::string& path,
                     const std::shared_ptr<const Codebook>& like,
                     const std::shared_ptr<const PieceOutline>& known) {
  std::vector<double> lower = file->numbers_attribute(path, "lower");
  std::vector<double> upper = file->numbers_attribute(path, "upper");
  bool is_box = lower.size() == upper.size() && lower.size() == like->coordinates().size();
  for (std::size_t k = 0; is_box && k < lower.size(); ++k)
    is_box = std::isfinite(lower[k]) && std::isfinite(upper[k]) && lower[k] <= upper[k];
  if (!is_box) throw file->error(path, "lower and upper are not the ends of a box of the coordinates");
  const auto read = [file, path, like] {
    Piece piece = read_piece(*file, path);
    if (piece.front() != nullptr)
      throw file->error(path, "counts a coordinate from a front, expected of codebooks of one piece alone");
    try {
      like->check_piece(piece);
    } catch (const ArgumentError& error) {
      throw file->error(path, error.what());
    }
    return piece.groups();
  };
  const auto outline = [file, path, like, known] {
    if (known) return *known;
    PieceOutline piece = read_outline(*file, path);
    if (piece.axes.size() == like->coordinates().size()) return piece;
    throw file->error(
        path, fmt::format("has {} axes, the first piece {}", piece.axes.size(), like->coordinates().size()));
  };
  return Piece(std::move(lower), std::move(upper), read, outline);
}

std::vector<Piece> read_pieces(const std::shared_ptr<const Hdf5Reader>& file, const ModelDescription& model,
                               bool at_once) {
  std::vector<Piece> pieces;
  const int count = numbered_children(*file, "/pieces");
  std::shared_ptr<const PieceOutline> outline;
  std::shared_ptr<const Codebook> first;
  if (!at_once && count > 1) {
    outline = std::make_shared<const PieceOutline>(read_outline(*file, "/pieces/0"));
    first = std::make_shared<const Codebook>(model, std::vector{outlined_piece(*outline)});
  }
  for (int k = 0; k < count; ++k) {
    const std::string path = fmt::format("/pieces/{}", k);
    pieces.push_back(first ? deferred_piece(file, path, first, k == 0 ? outline : nullptr)
                           : read_piece(*file, path));
    for (int other = 0; other < k; ++other) {
      const Piece& before = pieces[static_cast<std::size_t>(other)];
      if (before.lower() == pieces.back().lower() && before.upper() == pieces.back().upper())
        throw file->error(path, fmt::format("has the same box as /pieces/{}", other));
    }
  }
  return pieces;
}

ModelDescription read_checked_model(const Hdf5Reader& file) {
  ModelDescription model = read_model(file);
  const std::string name = file.text_attribute("/", "model");
  if (name == model.name) return model;
  throw file.error("/", fmt::format("model is \"{}\", but /model has the name \"{}\"", name, model.name));
}

Codebook read_book(const std::filesystem::path& path, bool at_once) {
  const auto shared =
      std::make_shared<const Hdf5Reader>(path, "a codebook, which samara build makes of a plan");
  const Hdf5Reader& file = *shared;
  check_version(file);
  try {
    const ModelDescription model = read_checked_model(file);
    Codebook book(model, read_pieces(shared, model, at_once), read_build(file), read_provenance(file), {},
                  file.text_attribute("/", "title"));
    check_units(file, book);
    if (file.has("/mesh")) book = book.with_mesh(read_mesh(file));
    if (!file.has("/certificate")) return book;
    Certificate certificate = read_certificate(file);
    order_outputs(file, certificate, book);
    return book.with_certificate(std::move(certificate));
  } catch (const ArgumentError& error) {
    throw file.error("/", error.what());
  }
}

}  // namespace

Codebook load(const std::filesystem::path& path) {
  std::error_code unknown;
  return read_book(path, std::filesystem::file_size(path, unknown) <= kReadAtOnce);
}

Codebook load_bytes(std::string_view bytes) {
  const io::MemoryFile file(bytes);
  try {
    return read_book(file.path(), true);
  } catch (const InputError& error) {
    const std::string sentence = error.what(), prefix = file.path().string() + ": ";
    throw InputError("bytes in memory",
                     sentence.starts_with(prefix) ? sentence.substr(prefix.size()) : sentence);
  }
}

bool is_codebook(const std::filesystem::path& path) {
  try {
    const Hdf5Reader file(path);
    return file.has_attribute("/", "format") && file.text_attribute("/", "format") == format::kFormat;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace samara::codebooks
