#pragma once

namespace samara::models {

/// Bounds of one coordinate, SI, both included.
struct Interval {
  double lower = 0.0;
  double upper = 0.0;

  double width() const { return upper - lower; }
  bool contains(double value) const { return value >= lower && value <= upper; }
};

}  // namespace samara::models
