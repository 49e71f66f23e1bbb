#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "samara/base/errors.h"
#include "samara/codebooks/source/journal.h"

namespace samara::codebooks {

/// Whether there is a checkpoint; a path that the system refuses has none.
bool is_checkpoint(const std::filesystem::path& path);

/// A kind of checkpoints. Files are known by their beginning or their format, damaged ones, too: what is more is looked
/// at by whoever goes on from them.
struct CheckpointKind {
  const char* of;                                     ///< what they are checkpoints of, "a build"
  bool (*is_one)(const std::filesystem::path& file);  ///< of a regular file
};

/// Those of this header, and of realisation_checkpoint.h.
inline constexpr CheckpointKind kJournalKind = {"a build or a cloud", is_journal};

/// Of a path whose file is replaced, and removed in the end: nothing stands there, an empty file, or a checkpoint of
/// the kind. @throws InputError if anything else does
void check_checkpoint_path(const std::filesystem::path& path, const CheckpointKind& kind = kJournalKind);

/// To begin anew. @throws InputError as check_checkpoint_path()
void remove_checkpoint(const std::filesystem::path& path, const CheckpointKind& kind = kJournalKind);

/// Why a checkpoint cannot be taken up, and what the user can do about it.
InputError bad_checkpoint(const std::filesystem::path& path, const std::string& reason);

/// Calls at the same times, in the order they were made.
struct CallSheet {
  std::vector<double> times;   ///< empty: there is no time
  std::vector<double> points;  ///< the coordinates of the first, of the second, ..
  std::vector<double> values;  ///< the answers in the same order, outputs fastest, then times
  double seconds = 0.0;        ///< that these calls have taken
};

/// A checkpoint lies beside a build, so that the build can go on after a kill: the state of a march, that of a build by
/// steps, the calls of sampling, or some of them (of a plan of kind "auto").
///
/// It is a journal (journal.h) that names program, version and plan, and then says what has changed: a state is
/// the one before, edited; calls are added. So it costs what is new. When it has grown to some times of what it
/// holds it is written anew. A kill while it is written costs the last change at most.
class Checkpoint {
 public:
  /// Nothing is read or written yet. Several may be of one file.
  /// @throws InputError as check_checkpoint_path()
  Checkpoint(std::filesystem::path path, std::string plan);

  /// The state of the march, empty if the file holds none.
  /// @throws InputError if the file is not there, broken or of another plan or version
  std::vector<double> march() const;

  /// That of a build by steps, likewise.
  std::vector<double> steps() const;

  /// The calls, none if the file holds none. @throws InputError as march()
  std::vector<CallSheet> calls() const;

  /// A file that is broken or of another plan is replaced; of this plan, what it holds besides stays.
  /// @throws ArgumentError if it cannot be written
  void save_march(const std::vector<double>& state) { save_state(march_, state); }
  void save_steps(const std::vector<double>& state) { save_state(steps_, state); }

  /// @param calls those that this object has saved, and more; others that are in the file are replaced
  /// @throws ArgumentError as save_march()
  void save_calls(const std::vector<CallSheet>& calls);

 private:
  struct Contents {
    std::vector<double> march, steps;
    std::vector<CallSheet> calls;
  };
  /// How much of a sheet the file holds.
  struct HeldSheet {
    std::size_t points = 0, values = 0;
  };
  Contents read(std::optional<Journal>& journal) const;
  /// @param held march_ or steps_
  void save_state(std::vector<double>& held, const std::vector<double>& state);
  std::vector<CallSheet> follow_file();
  void hold(const std::vector<CallSheet>& calls);
  bool has_room_for(const std::string& record) const;
  void append(const std::string& record);
  void write_anew(const std::vector<CallSheet>& calls);

  std::filesystem::path path_;
  std::string plan_;
  std::optional<Journal> journal_;     ///< empty: the file is to be replaced
  std::vector<double> march_, steps_;  ///< in the file
  std::vector<HeldSheet> held_;        ///< calls in the file
};

/// A function that saves, and does not throw where that fails: a disk that is full must not end work that needs no
/// disk. What `save` throws of the family of Error is told, once.
template <class... State>
std::function<void(const State&...)> told_once(
    std::type_identity_t<std::function<void(const State&...)>> save,
    std::function<void(const std::string&)> warning) {
  return
      [save = std::move(save), warning = std::move(warning), warned = false](const State&... state) mutable {
        try {
          save(state...);
        } catch (const Error& error) {  // a file that cannot be written, or read before it is written anew
          if (!warned && warning) warning(std::string("no checkpoint: ") + error.what());
          warned = true;
        }
      };
}

}  // namespace samara::codebooks
