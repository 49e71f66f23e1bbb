#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

/// Pictures of points for people to look at, as SVG.
namespace samara::benchmarks::identification {

struct Points {
  std::string name;
  std::string color;  ///< as CSS has it
  std::vector<Eigen::Vector2d> at;
};

struct Panel {
  std::string x_label, y_label;
  std::vector<Points> series;
  bool with_diagonal = false;  ///< y = x
};

/// Panels side by side, each with a frame, ticks at round numbers and a key above.
std::string scatter_svg(const std::string& title, const std::vector<Panel>& panels);

}  // namespace samara::benchmarks::identification
