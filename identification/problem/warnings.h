#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace samara::identification {

/// What a warning is about.
enum class WarningKind {
  source,        ///< codebook, units of a model, coefficients taken from another fit
  captures,      ///< what was measured looks wrong, or does not belong to the model
  model,         ///< the model misses the captures, or what was known beforehand, by far: it, or what
                 ///< is held fixed, is not theirs
  bounds,        ///< a value lies at a bound of its box
  undetermined,  ///< the captures say little or nothing about a value
  errors,        ///< standard errors are rough or too small
  noise,         ///< noise levels could not be estimated, or hold more than noise
  optima,        ///< there may be, or is, another optimum
  segments,      ///< multiple shooting: starts of segments, joins between them
  steps,         ///< the steps of the integrator are too long
  predictions,   ///< captures left out could not be predicted, or not as far as asked
  series,        ///< coefficients that change in time: their smoothness, what determines them
};

/// As in the file of a fit: the enumerator's name.
std::string to_string(WarningKind kind);

struct Warning {
  WarningKind kind;
  std::string sentence;  ///< names what it is about, and its numbers; no full stop
};

/// The warnings of a fit, in the order in which they were found: what a reader must know before using the
/// result. What was merely done to a capture is no warning; it stands in Capture::notes.
class Warnings {
 public:
  /// Adds one, unless the same sentence is there.
  /// @returns whether it was added.
  bool add(WarningKind kind, std::string sentence);
  void add_all(WarningKind kind, std::vector<std::string> sentences);
  void add_all(const Warnings& others);

  auto begin() const { return list_.begin(); }
  auto end() const { return list_.end(); }
  bool empty() const { return list_.empty(); }
  std::size_t size() const { return list_.size(); }
  const Warning& operator[](std::size_t k) const { return list_[k]; }

  std::vector<std::string> sentences() const;
  /// Whether one of the kind has this text somewhere in its sentence.
  bool has(WarningKind kind, std::string_view text = {}) const;

 private:
  std::vector<Warning> list_;
};

}  // namespace samara::identification
