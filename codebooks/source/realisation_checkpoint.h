#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "samara/models/stochastic/realisations.h"

/// Realisations that go on after an end that was not their own.
namespace samara::codebooks {

struct RealisationCheckpoint {
  std::filesystem::path file = {};  ///< removed once all have flown; empty: nothing is kept
  bool keep = false;  ///< the file stays, for a caller that removes it when the result is written
  /// Which air it is, seed included, in any words: what flew through another is not taken up.
  std::string air = {};
  /// Told in one sentence each: that realisations are taken up, or replaced; and that the file cannot be written.
  std::function<void(const std::string&)> note = {}, warning = {};
};

/// models::realise(), from where the same call was cancelled or killed, to the bits of an undisturbed run; it may ask
/// for more realisations now. The checkpoint of another call is replaced.
/// @throws ArgumentError as models::realise(), before the file is looked at; InputError as check_checkpoint_path()
models::Ensemble realise(const models::ParametricModel& model, std::span<const double> point,
                         const models::AirSource& air, std::span<const double> times,
                         const models::RealiseOptions& options, const RealisationCheckpoint& checkpoint);

}  // namespace samara::codebooks
