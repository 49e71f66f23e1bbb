#include "falling_paper.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "discs.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "samara/pgd/tensors/random.h"

namespace samara::benchmarks::identification {

using samara::identification::Capture;
using samara::identification::FitOptions;
using samara::models::TrajectoryFamily;

namespace {

constexpr double kThickness = 2.5 / 36000.0;  ///< m, as the source has it
constexpr double kPaper = 0.070;              ///< kg/m^2
constexpr double kAir = 1.2754;               ///< kg/m^3
constexpr double kMisfit = 6e-3;              ///< m: twice what the model misses, not the noise
constexpr double kStep = 5.2e-3;              ///< s: two a frame

/// Of a sheet with a mass of 1 kg a square metre.
struct Sheet {
  double area, inertia, inertia_z;
};

/// @param size m: a radius, half a side, a hexagon's apothem, or half a cross from arm to arm
/// @param width m, of the arms of a cross
Sheet sheet_of(const std::string& shape, double size, double width) {
  double area = std::numbers::pi * size * size, spin = area * size * size / 2.0;
  if (shape == "square") {
    area = 4.0 * size * size;
    spin = area * 2.0 / 3.0 * size * size;
  } else if (shape == "hexagon") {
    area = 2.0 * std::numbers::sqrt3 * size * size;
    spin = area * 5.0 / 9.0 * size * size;
  } else if (shape == "cross") {
    const double arm = 2.0 * size * width, middle = width * width;
    area = 2.0 * arm - middle;
    spin = (2.0 * arm * (4.0 * size * size + width * width) - middle * 2.0 * width * width) / 12.0;
  }
  return {area, 0.5 * spin, spin};  // all look the same after a quarter or a sixth of a turn
}

}  // namespace

std::vector<Capture> paper_drops(const std::filesystem::path& folder, const std::string& shape) {
  const auto sidecar = std::filesystem::path(SAMARA_EXAMPLES_DIR) / "captures" / "falling_paper.toml";
  std::vector<Capture> drops = samara::identification::read_captures(folder / (shape + ".csv"), sidecar);
  const auto number = [](const Capture& drop, const char* label) {
    const auto found = drop.labels.find(label);
    return found == drop.labels.end() || found->second.empty() ? 0.0 : std::stod(found->second);
  };
  constexpr double kLongestStep = 0.1;  // m
  std::erase_if(drops, [&](const Capture& drop) {
    return number(drop, "max_step_m") > kLongestStep ||
           number(drop, "cross_width_m") > 2.0 * number(drop, "radius_m");
  });
  for (Capture& drop : drops) {
    const Sheet sheet = sheet_of(shape, number(drop, "radius_m"), number(drop, "cross_width_m"));
    drop.labels["disc_radius"] = fmt::format("{}", std::sqrt(sheet.area / std::numbers::pi));
    drop.labels["inertia"] = fmt::format("{}", kPaper * sheet.inertia);
    drop.labels["inertia_z"] = fmt::format("{}", kPaper * sheet.inertia_z);
  }
  return drops;
}

PaperSplit split(const std::vector<Capture>& all, std::size_t drops, int frames, std::uint64_t seed,
                 int stride) {
  pgd::Random random(seed);
  const std::vector<std::size_t> order = random_order(all.size(), random);
  PaperSplit result;
  for (std::size_t k = 0; k < all.size(); ++k) {
    std::vector<Window>& windows = k < drops ? result.fitted : k < 2 * drops ? result.unseen : result.rest;
    for (Window& window : cut(all[order[k]], frames, kPaperAhead, stride))
      windows.push_back(std::move(window));
  }
  return result;
}

std::unique_ptr<models::TrajectoryFamily> paper_family() {
  // An ellipsoid with 3/4 of the thickness as semi-axis has the volume and the mass of the disc.
  const std::map<std::string, double> fixed = {
      {"c", 0.75 * kThickness}, {"density", kPaper / kThickness}, {"fluid_density", kAir}, {"wz(0)", 0.0}};
  Box box = disc_start_box(5.0, 5.0, 100.0);
  for (const char* name : {"a", "b"}) box[name] = {0.01, 0.1};
  for (const char* name : {"I_x", "I_y", "I_z"}) box[name] = {1e-9, 1e-4};
  box["C_D0"] = {0.01, 3.0};
  box["C_D90"] = {0.3, 20.0};
  box["C_T"] = {0.05, 10.0};
  box["C_R"] = {0.05, 10.0};
  box["C_w"] = {0.05, 50.0};
  return samara::models::step_trajectories(models::find_model("immersed_body"), fixed, box, kStep);
}

FitOptions paper_options() {
  FitOptions options = disc_options({{"C_D0", 0.2}, {"C_D90", 4.0}, {"C_T", 1.5}, {"C_R", 1.0}, {"C_w", 2.0}},
                                    kMisfit, "traj");
  options.unknowns.known = {{"a", "disc_radius"},
                            {"b", "disc_radius"},
                            {"I_x", "inertia"},
                            {"I_y", "inertia"},
                            {"I_z", "inertia_z"}};
  options.compared.averaged_frames = 5;
  return options;
}

std::unique_ptr<models::TrajectoryFamily> point_family() {
  // Drag and weight of any disc of the paper: diameter and mass of one of 1 m^2.
  const std::map<std::string, double> fixed = {
      {"diameter", 2.0 / std::sqrt(std::numbers::pi)}, {"mass", kPaper},  {"fluid_density", kAir},
      {"displaced_mass", kAir * kThickness},           {"added_mass", 0}, {"C_M", 0.0}};
  Box box;
  for (const char* name : {"x(0)", "y(0)", "z(0)", "vx(0)", "vy(0)", "vz(0)"}) box[name] = {-3.0, 3.0};
  box["C_D"] = {0.05, 5.0};
  return samara::models::step_trajectories(models::find_model("sphere_flight"), fixed, box, kStep);
}

FitOptions point_options() {
  FitOptions options;
  options.starts.initial = {{"C_D", 1.0}};
  options.loss.length_scale = kMisfit;
  options.compared.averaged_frames = 5;
  options.segments.length = 10.0;
  options.uncertainty.cluster_by = {"traj"};
  options.starts.count = 1;
  options.solver.max_iterations = 40;
  return options;
}

}  // namespace samara::benchmarks::identification
