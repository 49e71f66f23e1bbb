#include "samara/flow/files/flow_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/version.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/hdf5_writer.h"

namespace samara::flow {

namespace {

constexpr std::array kAxes = {"x", "y", "z"};
constexpr std::array kComponents = {"u", "v", "w"};

/// Entries of a field, x running fastest, over the cells or over the faces of a direction.
std::vector<double> packed(const MacGrid& grid, const Field& field, int face_direction) {
  std::array<int, 3> end = grid.cells;
  if (face_direction >= 0) end[static_cast<std::size_t>(face_direction)] += 1;
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(end[0]) * static_cast<std::size_t>(end[1]) *
                 static_cast<std::size_t>(end[2]));
  for (int k = 0; k < end[2]; ++k) {
    for (int j = 0; j < end[1]; ++j) {
      const auto row = field.begin() + grid.at(0, j, k);
      values.insert(values.end(), row, row + end[0]);
    }
  }
  return values;
}

/// Writes fields as [y, x] or [z, y, x], with their axes and units.
class FieldWriter {
 public:
  FieldWriter(io::Hdf5Writer& file, const MacGrid& grid) : file_(file), grid_(grid) {
    for (int d = 0; d < grid.dimensions; ++d) {
      for (const bool faces : {false, true}) {
        const auto at = static_cast<std::size_t>(d);
        const int count = grid.cells[at] + (faces ? 1 : 0);
        Eigen::VectorXd places(count);
        for (int i = 0; i < count; ++i) places(i) = grid.origin(d) + (i + (faces ? 0.0 : 0.5)) * grid.spacing;
        const std::string name = axis(d, faces ? d : -1);
        file.write_vector(name, places);
        file.make_scale(name, kAxes[at]);
        file.write_text_attribute(name, "unit", "l");
      }
    }
  }

  void write(const std::string& name, const Field& field, int face_direction, const char* unit) const {
    if (field.empty()) return;
    const std::vector<double> values = packed(grid_, field, face_direction);
    const auto extent = [&](std::size_t d) {
      return Eigen::Index{grid_.cells[d]} + (static_cast<int>(d) == face_direction ? 1 : 0);
    };
    if (grid_.dimensions == 3) {
      file_.write_block(name, {extent(2), extent(1), extent(0)}, values);
    } else {
      using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      file_.write_matrix(name, Eigen::Map<const Rows>(values.data(), extent(1), extent(0)));
    }
    file_.write_text_attribute(name, "unit", unit);
    for (int d = 0; d < grid_.dimensions; ++d)
      file_.attach_scale(name, static_cast<unsigned>(grid_.dimensions - 1 - d), axis(d, face_direction));
  }

 private:
  static std::string axis(int d, int face_direction) {
    return fmt::format("/axes/{}{}", kAxes[static_cast<std::size_t>(d)], d == face_direction ? "_faces" : "");
  }

  io::Hdf5Writer& file_;
  const MacGrid& grid_;
};

Field in_centres(const MacGrid& grid, const Field& faces, int d) {
  const Index s = grid.stride[static_cast<std::size_t>(d)];
  Field centres = grid.field();
  for (int k = 0; k < grid.cells[2]; ++k) {
    for (int j = 0; j < grid.cells[1]; ++j) {
      for (int i = 0; i < grid.cells[0]; ++i) {
        const auto c = static_cast<std::size_t>(grid.at(i, j, k));
        centres[c] = 0.5 * (faces[c] + faces[c + static_cast<std::size_t>(s)]);
      }
    }
  }
  return centres;
}

/// visit(group, attribute, number) for all numbers of a summary that are always known.
template <class Summary, class Visitor>
void visit_numbers(Summary& s, const Visitor& visit) {
  visit("/loads", "C_D", s.drag);
  visit("/loads", "C_L", s.lift);
  visit("/loads", "C_M", s.moment);
  visit("/loads", "bubble_end", s.bubble_end);
  visit("/status", "averaged_time", s.averaged_time);
  visit("/status", "time", s.time);
  visit("/plan", "reynolds", s.reynolds);
  visit("/plan", "angle_of_attack", s.angle_of_attack);
  visit("/checks", "divergence", s.checks.divergence);
  visit("/checks", "force_disagreement", s.checks.force_disagreement);
  visit("/checks", "energy_defect", s.checks.energy_defect);
  visit("/checks", "production", s.checks.production);
  visit("/checks", "y_plus_low", s.checks.y_plus_low);
  visit("/checks", "y_plus_high", s.checks.y_plus_high);
  visit("/checks", "viscous_share", s.checks.viscous_share);
  visit("/checks", "blockage", s.checks.blockage);
}

/// The same for those that are NaN where they are not known, and then left out of the file.
template <class Summary, class Visitor>
void visit_deviations(Summary& s, const Visitor& visit) {
  visit("/loads", "C_D_rms", s.drag_rms);
  visit("/loads", "C_L_rms", s.lift_rms);
  visit("/loads", "strouhal", s.strouhal);
}

FlowSummary summary_of(const FlowResult& result, const FlowPlan& plan) {
  FlowSummary s;
  s.reynolds = plan.flow.reynolds;
  s.angle_of_attack = plan.flow.angle_of_attack;
  s.intensity = plan.flow.intensity;
  s.drag = result.drag.value;
  if (std::isfinite(result.drag.half_width)) s.drag_half_width = result.drag.half_width;
  s.lift = result.lift;
  s.moment = result.moment;
  s.drag_rms = result.drag_rms;
  s.lift_rms = result.lift_rms;
  s.strouhal = result.strouhal;
  s.bubble_end = result.bubble_end;
  s.averaged_time = result.averaged_time;
  s.time = result.time;
  s.checks = result.checks;
  return s;
}

void write_history(io::Hdf5Writer& file, const std::vector<LoadRecord>& history) {
  const auto column = [&](const char* name, double LoadRecord::*of) {
    Eigen::VectorXd values(static_cast<Eigen::Index>(history.size()));
    for (std::size_t i = 0; i < history.size(); ++i) values(static_cast<Eigen::Index>(i)) = history[i].*of;
    file.write_vector(std::string("/loads/") + name, values);
  };
  column("t", &LoadRecord::time);
  file.make_scale("/loads/t", "t");
  column("drag", &LoadRecord::drag);
  column("lift", &LoadRecord::lift);
  column("moment", &LoadRecord::moment);
  for (const char* name : {"drag", "lift", "moment"})
    file.attach_scale(std::string("/loads/") + name, 0, "/loads/t");
}

/// Where the body was at the times of the loads.
void write_path(io::Hdf5Writer& file, const std::vector<LoadRecord>& history, const FlowCase& flow) {
  const auto column = [&](const std::string& name, const char* unit, const auto& of) {
    Eigen::VectorXd values(static_cast<Eigen::Index>(history.size()));
    for (std::size_t i = 0; i < history.size(); ++i)
      values(static_cast<Eigen::Index>(i)) = of(flow.motion->path(history[i].time));
    file.write_vector("/loads/" + name, values);
    file.write_text_attribute("/loads/" + name, "unit", unit);
    file.attach_scale("/loads/" + name, 0, "/loads/t");
  };
  for (int d = 0; d < flow.shape.dimensions; ++d)
    column(kAxes[static_cast<std::size_t>(d)], "l", [d](const BodyPose& pose) { return pose.place(d); });
  column("angle", "rad", [&](const BodyPose& pose) { return flow.angle_of_attack + pose.angle; });
}

/// Numbers of a dataset of the file into a field.
Field read_field(const io::Hdf5Reader& file, const MacGrid& grid, const std::string& name) {
  Field field = grid.field();
  const std::array<Eigen::Index, 3> cells = {grid.cells[2], grid.cells[1], grid.cells[0]};
  if (grid.dimensions == 3) {
    const io::Hdf5Block block = file.block(name);
    if (block.size != cells) throw file.error(name, "does not have the cells of the grid");
    std::size_t at = 0;
    for (int k = 0; k < grid.cells[2]; ++k) {
      for (int j = 0; j < grid.cells[1]; ++j) {
        for (int i = 0; i < grid.cells[0]; ++i)
          field[static_cast<std::size_t>(grid.at(i, j, k))] = block.values[at++];
      }
    }
    return field;
  }
  const Eigen::MatrixXd matrix = file.matrix(name, {.rows = cells[1], .columns = cells[2]});
  for (int j = 0; j < grid.cells[1]; ++j) {
    for (int i = 0; i < grid.cells[0]; ++i) field[static_cast<std::size_t>(grid.at(i, j))] = matrix(j, i);
  }
  return field;
}

MacGrid read_grid(const io::Hdf5Reader& file) {
  const std::int64_t dimensions = file.integer_attribute("/grid", "dimensions");
  const std::vector<double> cells = file.numbers_attribute("/grid", "cells");
  const std::vector<double> origin = file.numbers_attribute("/grid", "origin");
  const double spacing = file.number_attribute("/grid", "spacing");
  constexpr double kMostCells = 1e5;
  const auto is_count = [](double n) { return n >= 1.0 && n <= kMostCells && n == std::floor(n); };
  if ((dimensions != 2 && dimensions != 3) || cells.size() != 3 || origin.size() != 3 || !(spacing > 0.0) ||
      !std::isfinite(spacing) || !std::all_of(cells.begin(), cells.end(), is_count) ||
      !std::all_of(origin.begin(), origin.end(), [](double x) { return std::isfinite(x); }))
    throw file.error("/grid", "is no grid");
  for (std::size_t d = 0; d < 3; ++d) {
    const bool crossed = static_cast<std::int64_t>(d) < dimensions;
    if (crossed ? cells[d] < 2.0 : cells[d] != 1.0)
      throw file.error("/grid", fmt::format("has {} cells along {}, expected {}", cells[d], kAxes[d],
                                            crossed ? "at least 2" : "1 in the plane"));
  }
  // The file is as large as its fields: more memory than that is not taken for a damaged number.
  const std::vector<Eigen::Index> shape = file.shape("/centre/u");
  Eigen::Index stored = 1;
  for (const Eigen::Index n : shape) stored *= n;
  if (static_cast<double>(stored) != cells[0] * cells[1] * cells[2])
    throw file.error("/grid", "does not have as many cells as the fields");
  return MacGrid(static_cast<int>(dimensions),
                 {static_cast<int>(cells[0]), static_cast<int>(cells[1]), static_cast<int>(cells[2])},
                 spacing, {origin[0], origin[1], origin[2]});
}

/// Shares are shares, k is not negative, and eps is positive where there is fluid.
void check_fields(const io::Hdf5Reader& file, const StoredFlow& flow) {
  const auto every_cell = [&](const std::string& dataset, const Field& values, const char* expected,
                              const auto& good) {
    for (int k = 0; k < flow.grid.cells[2]; ++k) {
      for (int j = 0; j < flow.grid.cells[1]; ++j) {
        for (int i = 0; i < flow.grid.cells[0]; ++i) {
          const auto c = static_cast<std::size_t>(flow.grid.at(i, j, k));
          if (good(values[c], flow.open[c] > 0.0)) continue;
          throw file.error(dataset, fmt::format("has the value {} in cell ({}, {}, {}), expected {}",
                                                values[c], i, j, k, expected));
        }
      }
    }
  };
  every_cell("/body/open", flow.open, "shares from 0 to 1",
             [](double share, bool) { return share >= 0.0 && share <= 1.0; });
  for (const CentreField& field : flow.fields) {
    const std::string dataset = "/centre/" + field.name;
    if (field.name == "k" || field.name == "k_modelled" || field.name == "k_resolved")
      every_cell(dataset, field.values, "none below 0",
                 [](double k, bool open) { return k >= 0.0 || !open; });
    if (field.name == "epsilon")
      every_cell(dataset, field.values, "positive ones",
                 [](double epsilon, bool open) { return epsilon > 0.0 || !open; });
  }
}

}  // namespace

std::vector<CentreField> centre_fields(const FlowResult& result) {
  std::vector<CentreField> fields;
  for (int d = 0; d < result.grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    fields.push_back({kComponents[at], "U", in_centres(result.grid, result.velocity[at], d)});
  }
  Field k = result.k_resolved;
  for (std::size_t c = 0; c < result.k_modelled.size(); ++c) k[c] += result.k_modelled[c];
  fields.push_back({"p", "rho U^2", result.pressure});
  fields.push_back({"k", "U^2", std::move(k)});
  if (!result.k_modelled.empty()) fields.push_back({"k_modelled", "U^2", result.k_modelled});
  fields.push_back({"k_resolved", "U^2", result.k_resolved});
  if (!result.epsilon.empty()) fields.push_back({"epsilon", "U^3/l", result.epsilon});
  return fields;
}

void save_flow(const FlowResult& result, const FlowPlan& plan, const std::filesystem::path& path) {
  const MacGrid& grid = result.grid;
  io::Hdf5Writer file(path);
  file.write_text_attribute("/", "format", kFlowFormat);
  file.write_text_attribute("/", "version", kFlowVersion);
  file.write_text_attribute("/", "title", plan.title);
  file.write_text_attribute("/", "units", "lengths in body lengths l, velocities in U, densities in rho");
  for (const char* group : {"/grid", "/loads", "/status", "/checks", "/plan", "/provenance"})
    file.create_group(group);
  file.write_integer_attribute("/grid", "dimensions", grid.dimensions);
  file.write_number_attribute("/grid", "spacing", grid.spacing);
  file.write_numbers_attribute(
      "/grid", "cells", std::array<double, 3>{1.0 * grid.cells[0], 1.0 * grid.cells[1], 1.0 * grid.cells[2]});
  file.write_numbers_attribute("/grid", "origin",
                               std::array<double, 3>{grid.origin.x(), grid.origin.y(), grid.origin.z()});

  const FieldWriter fields(file, grid);
  for (int d = 0; d < grid.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    fields.write(fmt::format("/fields/{}", kComponents[at]), result.velocity[at], d, "U");
    fields.write(fmt::format("/body/open_{}", kAxes[at]), result.body.face[at], d, "1");
  }
  for (const CentreField& field : centre_fields(result))
    fields.write("/centre/" + field.name, field.values, -1, field.unit.c_str());
  fields.write("/body/open", result.body.cell, -1, "1");

  write_history(file, result.history);
  if (plan.flow.motion) write_path(file, result.history, plan.flow);
  file.write_text_attribute("/status", "status", to_string(result.status));
  file.write_text_attribute("/status", "message", result.message);
  file.write_integer_attribute("/status", "steps", result.steps);
  const FlowSummary summary = summary_of(result, plan);
  visit_numbers(summary, [&](const char* group, const char* name, double value) {
    file.write_number_attribute(group, name, value);
  });
  visit_deviations(summary, [&](const char* group, const char* name, double value) {
    if (std::isfinite(value)) file.write_number_attribute(group, name, value);
  });
  if (summary.drag_half_width)
    file.write_number_attribute("/loads", "C_D_half_width", *summary.drag_half_width);
  file.write_number_attribute("/plan", "intensity", *summary.intensity);
  file.write_integer_attribute("/checks", "clipped_cells", result.checks.clipped_cells);
  file.write_integer_attribute("/checks", "guarded_cells", result.checks.guarded_cells);
  file.write_integer_attribute("/checks", "unconverged", result.checks.unconverged);
  file.write_text_attribute("/plan", "text", plan.text);
  file.write_text_attribute("/provenance", "generator", fmt::format("samara {}", version()));
  file.commit();
}

bool is_flow_file(const std::filesystem::path& path) {
  try {
    const io::Hdf5Reader file(path);
    return file.has_attribute("/", "format") && file.text_attribute("/", "format") == kFlowFormat;
  } catch (const InputError&) {
    return false;  // whoever opens it next says why
  }
}

const CentreField& StoredFlow::field(const std::string& name) const {
  std::vector<std::string> names;
  for (const CentreField& field : fields) {
    if (field.name == name) return field;
    names.push_back(field.name);
  }
  throw ArgumentError(fmt::format("the flow has no field \"{}\"{}", name, suggestion(name, names)));
}

StoredFlow load_flow(const std::filesystem::path& path) {
  const io::Hdf5Reader file(path);
  if (!file.has_attribute("/", "format") || file.text_attribute("/", "format") != kFlowFormat)
    throw file.error("/", "is no flow file: its format is not \"samara-flow\"");
  if (const std::string found = file.text_attribute("/", "version"); found != kFlowVersion)
    throw file.error("/", fmt::format("is of version {}, expected {}", found, kFlowVersion));
  StoredFlow flow(read_grid(file));
  FlowSummary& s = flow.summary;
  s.status = file.text_attribute("/status", "status");
  s.message = file.text_attribute("/status", "message");
  s.title = file.text_attribute("/", "title");
  s.plan = file.text_attribute("/plan", "text");
  s.generator = file.text_attribute("/provenance", "generator");
  visit_numbers(s, [&](const char* group, const char* name, double& value) {
    value = file.finite_attribute(group, name);
  });
  visit_deviations(s, [&](const char* group, const char* name, double& value) {
    value = file.has_attribute(group, name) ? file.finite_attribute(group, name) : NAN;
  });
  if (file.has_attribute("/loads", "C_D_half_width"))
    s.drag_half_width = file.finite_attribute("/loads", "C_D_half_width");
  if (file.has_attribute("/plan", "intensity")) s.intensity = file.finite_attribute("/plan", "intensity");
  s.checks.clipped_cells = static_cast<long>(file.integer_attribute("/checks", "clipped_cells"));
  s.checks.guarded_cells = static_cast<long>(file.integer_attribute("/checks", "guarded_cells"));
  s.checks.unconverged = static_cast<long>(file.integer_attribute("/checks", "unconverged"));
  s.moving = file.has("/loads/angle");
  flow.open = read_field(file, flow.grid, "/body/open");
  for (const char* name : {"u", "v", "w", "p", "k", "k_modelled", "k_resolved", "epsilon"}) {
    const std::string dataset = fmt::format("/centre/{}", name);
    if (file.has(dataset))
      flow.fields.push_back(
          {name, file.text_attribute(dataset, "unit"), read_field(file, flow.grid, dataset)});
  }
  check_fields(file, flow);
  return flow;
}

}  // namespace samara::flow
