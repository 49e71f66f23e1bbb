#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "samara/base/errors.h"

namespace samara::codebooks {

/// A checkpoint lies beside a build, so that the build can go on after a kill: the state of a march, the calls
/// of sampling, or both (of a plan of kind "auto"). Written atomically, like save().

/// Whether there is one; a path that the system refuses has none.
bool is_checkpoint(const std::filesystem::path& path);

/// Why a checkpoint cannot be taken up, and what the user can do about it.
InputError bad_checkpoint(const std::filesystem::path& path, const std::string& reason);

/// Calls at the same times, in the order they were made.
struct CallSheet {
  std::vector<double> times;   ///< empty: there is no time
  std::vector<double> points;  ///< the coordinates of the first, of the second, ..
  std::vector<double> values;  ///< the answers in the same order, outputs fastest, then times
  double seconds = 0.0;        ///< that these calls have taken
};

/// Writes the state of a march in slabs (pgd::SlabOptions::checkpoint); calls that are in the file stay.
void save_march(const std::filesystem::path& path, const std::string& plan, const std::vector<double>& state);

/// Writes the calls of sampling; a state that is in the file stays.
void save_calls(const std::filesystem::path& path, const std::string& plan,
                const std::vector<CallSheet>& calls, std::size_t coordinates);

/// The state of the march, empty if the file holds none.
/// @throws InputError if the file is broken or belongs to another plan.
std::vector<double> load_march(const std::filesystem::path& path, const std::string& plan);

/// The calls, none if the file holds none. @throws InputError as load_march()
std::vector<CallSheet> load_calls(const std::filesystem::path& path, const std::string& plan);

}  // namespace samara::codebooks
