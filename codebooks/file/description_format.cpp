#include "samara/codebooks/file/description_format.h"

#include <map>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "samara/base/termination.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/models/equations/equation_model.h"

namespace samara::codebooks {

using io::Hdf5Reader;
using io::Hdf5Writer;

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

ModelDescription read_model(const Hdf5Reader& file) {
  const std::string path = "/model";
  ModelDescription model;
  model.name = file.text_attribute(path, "name");
  model.title = file.text_attribute(path, "title");
  model.equations = file.text_attribute(path, "equations");
  model.frames = file.text_attribute(path, "frames");
  model.source = file.text_attribute(path, "source");
  if (file.has_attribute(path, "definition")) {
    try {
      model.of_text =
          read_equation_model(io::TomlTable::parse(file.text_attribute(path, "definition"), "definition"));
    } catch (const InputError& error) {
      throw file.error(path, fmt::format("holds equations that cannot be read: {}", error.what()));
    }
  }
  for (const std::string& name : file.children(path + "/fixed")) {
    model.fixed[name] = file.vector(path + "/fixed/" + name, {.rows = 1})[0];
    model.fixed_units[name] = file.text_attribute(path + "/fixed/" + name, "units");
  }
  return model;
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

namespace {

/// Older files have words of their own for some.
Termination read_status(const Hdf5Reader& file, const std::string& path) {
  static const std::map<std::string, Termination> older = {{"", Termination::failed},
                                                           {"iteration limit", Termination::max_iterations},
                                                           {"not determined", Termination::not_determined},
                                                           {"stalled", Termination::stagnated},
                                                           {"max_evaluations", Termination::max_calls}};
  const std::string word = file.text_attribute(path, "status");
  if (const std::optional<Termination> status = termination_of(word)) return *status;
  if (const auto known = older.find(word); known != older.end()) return known->second;
  throw file.error(path, fmt::format("status is \"{}\", which is no status of a build", word));
}

}  // namespace

BuildRecord read_build(const Hdf5Reader& file) {
  const std::string path = "/build";
  BuildRecord build;
  build.builder = file.text_attribute(path, "builder");
  build.strategy = file.text_attribute(path, "strategy");
  build.status = read_status(file, path);
  build.message = file.text_attribute(path, "message");
  build.evaluations = file.number_attribute(path, "evaluations");
  build.grid_size = file.number_attribute(path, "grid_size");
  build.iterations = static_cast<int>(file.integer_attribute(path, "iterations"));
  build.rounds = static_cast<int>(file.integer_attribute(path, "rounds"));
  return build;
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

Provenance read_provenance(const Hdf5Reader& file) {
  const std::string path = "/provenance";
  return {file.text_attribute(path, "generator"), file.text_attribute(path, "plan"),
          file.text_attribute(path, "created"), file.text_attribute(path, "host"),
          file.number_attribute(path, "build_seconds")};
}

}  // namespace samara::codebooks
