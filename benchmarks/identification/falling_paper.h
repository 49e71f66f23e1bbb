#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "windows.h"

/// Round sheets of paper that fall in air, seen as positions alone (T. Howison, J. Hughes, F. Iida, Nature
/// Machine Intelligence 2020): a disc with quasi-steady forces, its coefficients from windows of some drops.
namespace samara::benchmarks::identification {

inline constexpr int kPaperAhead = 10;  ///< frames of 1/98 s: 0.1 s

/// Drops of sheets of a shape ("circle", "square", "hexagon", "cross"), in the order of the source, without the
/// release and what is near the floor, with what the model must know of each as labels: "disc_radius" of the
/// disc that has its area, and the sheet's own "inertia" and "inertia_z". Drops with a jump of over 10 cm between
/// frames are left out, as the source does, and a cross that says its arms are wider than long.
std::vector<samara::identification::Capture> paper_drops(const std::filesystem::path& folder,
                                                         const std::string& shape = "circle");

struct PaperSplit {
  std::vector<Window> fitted, unseen;
  std::vector<Window> rest = {};  ///< of drops that are neither
};
/// `drops` drops to fit and as many others, or those that there are, drawn with a seed.
/// @param stride of the windows: cut() of windows.h
PaperSplit split(const std::vector<samara::identification::Capture>& all, std::size_t drops, int frames,
                 std::uint64_t seed, int stride = 0);

std::unique_ptr<samara::models::TrajectoryFamily> paper_family();
samara::identification::FitOptions paper_options();

/// A point with drag against its velocity.
std::unique_ptr<samara::models::TrajectoryFamily> point_family();
samara::identification::FitOptions point_options();

}  // namespace samara::benchmarks::identification
