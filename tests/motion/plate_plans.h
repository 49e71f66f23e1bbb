#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "samara/io/toml_document.h"
#include "samara/models/laws/registry.h"
#include "samara/motion/planning/planner.h"

/// Plates of I* 1.3 in their plane, a hundred of them.
inline std::shared_ptr<const samara::motion::MotionDatabase> plate_motions() {
  static const auto database =
      std::make_shared<const samara::motion::MotionDatabase>(samara::motion::build_database(
          samara::motion::run_sweep(
              samara::motion::parse_sweep_plan(
                  "model = \"falling_plate_nd\"\n[fixed]\nbeta = 0\ninertia_ratio = 1.3\n[axes]\n"
                  "C_T = { from = 0.8, to = 1.4 }\nC_R = { from = 2, to = 4 }\nA = { from = 1, to = 1.8 }\n"
                  "[sample]\ncount = 100\n[releases]\ntilt = [0.6]\n[run]\nuntil = 60\nstep = 0.05\n"
                  "settle = 10\n",
                  "plates.toml"))
              .sweep));
  return database;
}

inline samara::motion::MotionPlan sequence_plan(double height = 40.0) {
  samara::motion::MotionPlan plan;
  plan.model = samara::models::find_model("falling_plate_nd");
  plan.fixed = {{"inertia_ratio", 1.3}, {"beta", 0.0}, {"theta(0)", 0.6}, {"y(0)", height},
                {"C_T", 1.1},           {"C_R", 3.0},  {"A", 1.4}};
  plan.box = {{"C_T", 0.8, 1.4, 1.1}, {"C_R", 2.0, 4.0, 3.0}, {"A", 1.0, 1.8, 1.4}};
  plan.search = {.beam = 10, .children = 12, .sweeps = 1, .step = 0.02, .ramp = 1.0, .seed = 1};
  return plan;
}

inline samara::motion::Sketch slanted_sketch(double height) {
  Eigen::MatrixX3d points(2, 3);
  points << 0.0, 0.0, height, 0.4 * height, 0.0, 0.0;
  return samara::motion::Sketch(points);
}

inline samara::motion::MotionSequence read_text(
    const std::string& text, const samara::motion::MotionDatabase* database = plate_motions().get()) {
  const auto root = samara::io::TomlTable::parse("[sequence]\n" + text, "motion.toml");
  return samara::motion::read_sequence(root.table("sequence"), std::filesystem::path(), database);
}
