#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace samara::apps {

/// What was typed after `samara patterns`.
struct PatternsArguments {
  std::vector<std::string> inputs;   ///< a sweep, or captures
  std::string sidecar;               ///< of every table; empty: those beside them
  std::string labels;                ///< a person's, of segments
  std::vector<std::string> classes;  ///< what these words mean
  std::string length;                ///< of the body; empty: not known
  std::string body;                  ///< model of the body of captures; empty: not known
  std::vector<std::string> set;      ///< values of its parameters; of a sweep those of the point to clamp
  std::vector<std::string> thresholds;
  std::string report;           ///< page to write; empty: none
  std::optional<int> clusters;  ///< of a sweep
  /// Of a sweep: the pattern that points are to lead to; empty: a report is asked for.
  std::string draw, clamp;
  std::optional<long> count, release;
  std::optional<std::uint64_t> seed;
  std::string output;
  bool json = false;
};

}  // namespace samara::apps
