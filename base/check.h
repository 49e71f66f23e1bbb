#pragma once

#include <string>
#include <vector>

namespace samara {

/// What a test kit has found of a part that a user has written: a model, a family of trajectories, an evolution system,
/// a strategy.
struct Check {
  std::vector<std::string> findings;    ///< a sentence per broken promise; none is good
  std::vector<std::string> notes = {};  ///< what breaks no promise, but is good to know

  bool passed() const { return findings.empty(); }
};

}  // namespace samara
