#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "samara/codebooks/plan/plan.h"
#include "samara/flow/march/solve_flow.h"
#include "samara/models/bodies/triangle_mesh.h"

namespace samara::flow {

/// A plan of a flow (TOML, docs/flow.md): the table [flow]; for a body that moves [motion]; for a book of
/// flows [box], [book] and [tolerance].
struct FlowPlan {
  FlowCase flow;
  FlowEnd end = FlowEnd::mean;
  double max_time = 200.0;
  double max_memory = 2e9;
  std::uint64_t seed = 1;
  int threads = 0;
  std::string title;
  std::string text;  ///< as read

  std::vector<codebooks::BoxEntry> box;  ///< angle_of_attack [rad], log10_reynolds; empty: one flow
  bool of_fields = false;                ///< a book of the mean fields, not of loads and energy
  double relative = 0.05;                ///< of each output's range over the box
  /// Solves that the builder may take.
  long max_calls = 400;
  int certificate_points = 8;  ///< solves that it does not see
  int box_line = 0;            ///< where the box stands in the text; 0: there is none
};

/// Reads a closed mesh from a file: models::read_mesh() of the library samara::mesh_files, which plans without meshes
/// do not need.
using MeshReader = std::function<models::TriangleMesh(const std::string& path)>;

/// @param mesh_reader for plans with a mesh, whose path lies relative to the plan
/// @throws InputError, with file and line, for unknown keys, kinds and units, and values that are none of theirs,
/// and for one flow, not a book, also what check_case() and check_path() refuse
FlowPlan read_flow_plan(const std::filesystem::path& path, const MeshReader& mesh_reader = {});
FlowPlan parse_flow_plan(const std::string& text, const std::string& name,
                         const MeshReader& mesh_reader = {});

}  // namespace samara::flow
