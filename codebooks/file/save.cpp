#include "samara/codebooks/file/save.h"

#include <string>
#include <vector>

#include <fmt/format.h>

#include "samara/base/version.h"
#include "samara/codebooks/file/format_version.h"
#include "samara/codebooks/file/mesh_format.h"
#include "samara/codebooks/file/piece_format.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/io/hdf5_writer.h"
#include "samara/models/equations/equation_model.h"

namespace samara::codebooks {

namespace {

using io::Hdf5Writer;

void write_certificate(Hdf5Writer& file, const Certificate& c) {
  const std::string path = "/certificate";
  file.create_group(path);
  file.write_text_attribute(
      path, "definition",
      "error = largest |codebook - integrator| over points and times, divided by max(range of the "
      "output, absolute tolerance)");
  file.write_number_attribute(path, "tolerance", c.tolerance);
  file.write_integer_attribute(path, "met", c.met ? 1 : 0);
  file.write_number_attribute(path, "max_error", c.max_error);
  file.write_integer_attribute(path, "points", c.points);
  file.write_integer_attribute(path, "times", c.times);
  if (c.places > 0) file.write_integer_attribute(path, "places", c.places);
  file.write_integer_attribute(path, "failed_points", c.failed_points);
  if (c.wrong_points) {
    file.write_integer_attribute(path, "wrong_points", *c.wrong_points);
    file.write_number_attribute(path, "share_above",
                                share_above(*c.wrong_points, c.points, c.refuted_before));
  }
  file.write_integer_attribute(path, "climbed_points", c.climbed_points);
  file.write_integer_attribute(path, "refuted_before", c.refuted_before);
  // Seeds use all 64 bits, integers of the file are signed: as text.
  file.write_text_attribute(path, "seed", std::to_string(c.seed));
  file.write_text_attribute(path, "integrator", c.integrator);
  file.write_number_attribute(path, "integrator_tolerance", c.integrator_tolerance);
  file.write_number_attribute(path, "residual", c.residual);
  file.write_number_attribute(path, "spent_discretisation", c.spent.discretisation);
  file.write_number_attribute(path, "spent_compression", c.spent.compression);
  file.write_number_attribute(path, "spent_nonlinearity", c.spent.nonlinearity);
  if (c.norm_defect) {
    file.write_number_attribute(path, "norm_defect_max", c.norm_defect->max);
    file.write_number_attribute(path, "norm_defect_rms", c.norm_defect->rms);
  }
  for (const OutputError& o : c.outputs) {
    const std::string output = path + "/" + o.name;
    file.create_group(output);
    file.write_text_attribute(output, "units", o.unit);
    file.write_number_attribute(output, "range", o.range);
    file.write_number_attribute(output, "max", o.max);
    file.write_number_attribute(output, "p95", o.p95);
    file.write_number_attribute(output, "mean", o.mean);
    file.write_number_attribute(output, "rms", o.rms);
    file.write_number_attribute(output, "max_si", o.max_si);
    file.write_numbers_attribute(output, "worst", o.worst);
  }
}

void write_model(Hdf5Writer& file, const ModelDescription& model) {
  const std::string path = "/model";
  file.create_group(path);
  file.write_text_attribute(path, "name", model.name);
  file.write_text_attribute(path, "title", model.title);
  file.write_text_attribute(path, "equations", model.equations);
  file.write_text_attribute(path, "frames", model.frames);
  file.write_text_attribute(path, "source", model.source);
  if (model.of_text)
    file.write_text_attribute(path, "definition", to_toml(*models::equations_of(*model.of_text)));
  file.create_group(path + "/fixed");
  for (const auto& [name, value] : model.fixed) {
    const auto unit = model.fixed_units.find(name);
    file.write_vector(path + "/fixed/" + name, Eigen::VectorXd::Constant(1, value));
    file.write_text_attribute(path + "/fixed/" + name, "units",
                              unit == model.fixed_units.end() ? "1" : unit->second);
  }
}

void write_build(Hdf5Writer& file, const BuildRecord& build) {
  const std::string path = "/build";
  file.create_group(path);
  file.write_text_attribute(path, "builder", build.builder);
  file.write_text_attribute(path, "strategy", build.strategy);
  file.write_text_attribute(path, "status", to_string(build.status));
  file.write_text_attribute(path, "message", build.message);
  file.write_number_attribute(path, "evaluations", build.evaluations);
  file.write_number_attribute(path, "grid_size", build.grid_size);
  file.write_integer_attribute(path, "iterations", build.iterations);
  file.write_integer_attribute(path, "rounds", build.rounds);
}

void write_provenance(Hdf5Writer& file, const Provenance& provenance) {
  const std::string path = "/provenance";
  file.create_group(path);
  file.write_text_attribute(path, "generator", provenance.generator);
  file.write_text_attribute(path, "plan", provenance.plan);
  file.write_text_attribute(path, "created", provenance.created);
  file.write_text_attribute(path, "host", provenance.host);
  file.write_number_attribute(path, "build_seconds", provenance.build_seconds);
}

}  // namespace

void save(const Codebook& book, const std::filesystem::path& path) {
  Hdf5Writer file(path);
  file.write_text_attribute("/", "format", format::kFormat);
  file.write_text_attribute("/", "format_version", fmt::format("{}.{}", format::kMajor, format::kMinor));
  file.write_text_attribute("/", "generator", fmt::format("samara {}", version()));
  file.write_text_attribute("/", "model", book.model().name);
  file.write_text_attribute("/", "title", book.title());
  for (std::size_t k = 0; k < book.pieces().size(); ++k)
    write_piece(file, fmt::format("/pieces/{}", k), book.pieces()[k]);
  if (book.mesh() != nullptr) write_mesh(file, *book.mesh());
  if (book.certificate()) write_certificate(file, *book.certificate());
  write_model(file, book.model());
  write_build(file, book.build());
  write_provenance(file, book.provenance());
  file.commit();
}

}  // namespace samara::codebooks
