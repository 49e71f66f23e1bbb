#pragma once

#include <string>
#include <vector>

/// What the test kits for parts of one's own find (a model, an evolution system, a strategy, ..).
namespace samara {

struct Findings {
  std::vector<std::string> sentences;  ///< one per broken promise; none is good

  bool passed() const { return sentences.empty(); }
};

}  // namespace samara
