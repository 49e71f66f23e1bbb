#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

/// Charts as SVG, for papers and pages: panels side by side, all in one style.
namespace samara::io {

struct SvgSeries {
  enum class Kind { line, dashes, points };
  std::string name;      ///< in the key; empty: not there
  Eigen::VectorXd x, y;  ///< NaN, or beyond 1e300: a gap
  Kind kind = Kind::line;
  int colour = 0;  ///< number of the palette's, from 0, again and again
};

/// A thin line across a panel.
struct SvgRule {
  double at = 0.0;
  bool is_vertical = false;
};

struct SvgPanel {
  std::string title;
  std::string x_label, y_label;
  std::vector<SvgSeries> series;
  std::vector<SvgRule> rules = {};
  bool has_log_y = false;         ///< values that are not positive are gaps
  bool with_diagonal = false;     ///< y = x
  bool from_zero = false;         ///< both axes begin at 0 or below
  bool has_equal_scales = false;  ///< a length is as long across as up; not with has_log_y
};

/// A picture of panels, `columns` in a row, ticks at round numbers, a key above each.
/// @throws ArgumentError if there is no panel, columns < 1, or x and y of a series differ in size
std::string svg_charts(const std::string& title, const std::vector<SvgPanel>& panels, int columns);

}  // namespace samara::io
