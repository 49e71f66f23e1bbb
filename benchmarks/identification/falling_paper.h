#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "windows.h"

/// Round sheets of paper that fall in air, seen as positions alone (T. Howison, J. Hughes, F. Iida, Nature
/// Machine Intelligence 2020): a disc with quasi-steady forces, its coefficients from windows of some drops.
namespace samara::benchmarks::identification {

inline constexpr int kPaperAhead = 10;  ///< frames of 1/98 s: 0.1 s

/// Drops of discs, in the order of the source, without the release and what is near the floor, with what the
/// model must know of each as labels.
std::vector<samara::identification::Capture> paper_drops(const std::filesystem::path& folder);

struct PaperSplit {
  std::vector<Window> fitted, unseen;
};
/// `drops` drops to fit and as many others, drawn with a seed.
PaperSplit split(const std::vector<samara::identification::Capture>& all, std::size_t drops, int frames,
                 std::uint64_t seed);

std::unique_ptr<samara::models::TrajectoryFamily> paper_family();
samara::identification::FitOptions paper_options();

/// A point with drag against its velocity.
std::unique_ptr<samara::models::TrajectoryFamily> point_family();
samara::identification::FitOptions point_options();

}  // namespace samara::benchmarks::identification
