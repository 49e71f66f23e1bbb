#include <algorithm>
#include <charconv>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/codebooks/store.h"
#include "samara/codebooks/store_format.h"
#include "samara/codebooks/store_piece.h"
#include "samara/io/hdf5_reader.h"

namespace samara::codebooks {

namespace {

using io::Hdf5Reader;

void check_version(const Hdf5Reader& file) {
  if (!file.has_attribute("/", "format") || file.text_attribute("/", "format") != format::kFormat) {
    throw file.error("/",
                     fmt::format("attribute format is not \"{}\": this is not a codebook", format::kFormat));
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

Certificate read_certificate(const Hdf5Reader& file) {
  const std::string path = "/certificate";
  Certificate c;
  c.tolerance = file.number_attribute(path, "tolerance");
  c.met = file.integer_attribute(path, "met") != 0;
  c.max_error = file.number_attribute(path, "max_error");
  c.points = static_cast<int>(file.integer_attribute(path, "points"));
  c.times = static_cast<int>(file.integer_attribute(path, "times"));
  c.failed_points = static_cast<int>(file.integer_attribute(path, "failed_points"));
  const std::string seed = file.text_attribute(path, "seed");
  std::from_chars(seed.data(), seed.data() + seed.size(), c.seed);
  c.integrator = file.text_attribute(path, "integrator");
  c.integrator_tolerance = file.number_attribute(path, "integrator_tolerance");
  c.residual = file.number_attribute(path, "residual");
  c.spent.discretisation = file.number_attribute(path, "spent_discretisation");
  c.spent.compression = file.number_attribute(path, "spent_compression");
  c.spent.nonlinearity = file.number_attribute(path, "spent_nonlinearity");
  for (const std::string& name : file.children(path)) {
    const std::string output = path + "/" + name;
    OutputError o;
    o.name = name;
    o.unit = file.text_attribute(output, "units");
    o.range = file.number_attribute(output, "range");
    o.max = file.number_attribute(output, "max");
    o.p95 = file.number_attribute(output, "p95");
    o.mean = file.number_attribute(output, "mean");
    o.rms = file.number_attribute(output, "rms");
    o.max_si = file.number_attribute(output, "max_si");
    o.worst = file.numbers_attribute(output, "worst");
    c.outputs.push_back(std::move(o));
  }
  return c;
}

/// Outputs of the certificate in the order of the codebook; the file sorts them by name.
void order_outputs(Certificate& certificate, const Codebook& book) {
  const auto place = [&](const OutputError& o) {
    const auto& outputs = book.outputs();
    return std::find_if(outputs.begin(), outputs.end(),
                        [&](const auto& label) { return label.name == o.name; }) -
           outputs.begin();
  };
  std::stable_sort(certificate.outputs.begin(), certificate.outputs.end(),
                   [&](const OutputError& a, const OutputError& b) { return place(a) < place(b); });
}

ModelDescription read_model(const Hdf5Reader& file) {
  const std::string path = "/model";
  ModelDescription model;
  model.name = file.text_attribute(path, "name");
  model.title = file.text_attribute(path, "title");
  model.equations = file.text_attribute(path, "equations");
  model.frames = file.text_attribute(path, "frames");
  model.source = file.text_attribute(path, "source");
  for (const std::string& name : file.children(path + "/fixed")) {
    model.fixed[name] = file.vector(path + "/fixed/" + name, {.rows = 1})[0];
    model.fixed_units[name] = file.text_attribute(path + "/fixed/" + name, "units");
  }
  return model;
}

BuildRecord read_build(const Hdf5Reader& file) {
  const std::string path = "/build";
  BuildRecord build;
  build.builder = file.text_attribute(path, "builder");
  build.strategy = file.text_attribute(path, "strategy");
  build.status = file.text_attribute(path, "status");
  build.message = file.text_attribute(path, "message");
  build.evaluations = file.number_attribute(path, "evaluations");
  build.grid_size = file.number_attribute(path, "grid_size");
  build.iterations = static_cast<int>(file.integer_attribute(path, "iterations"));
  build.rounds = static_cast<int>(file.integer_attribute(path, "rounds"));
  return build;
}

Provenance read_provenance(const Hdf5Reader& file) {
  const std::string path = "/provenance";
  return {file.text_attribute(path, "generator"), file.text_attribute(path, "plan"),
          file.text_attribute(path, "created"), file.text_attribute(path, "host"),
          file.number_attribute(path, "build_seconds")};
}

}  // namespace

Codebook load(const std::filesystem::path& path) {
  const Hdf5Reader file(path);
  check_version(file);
  try {
    std::vector<Piece> pieces;
    const int count = numbered_children(file, "/pieces");
    for (int k = 0; k < count; ++k) pieces.push_back(read_piece(file, fmt::format("/pieces/{}", k)));
    Codebook book(read_model(file), std::move(pieces), read_build(file), read_provenance(file), {},
                  file.text_attribute("/", "title"));
    if (!file.has("/certificate")) return book;
    Certificate certificate = read_certificate(file);
    order_outputs(certificate, book);
    return book.with_certificate(std::move(certificate));
  } catch (const ArgumentError& error) {
    throw file.error("/", error.what());
  }
}

}  // namespace samara::codebooks
