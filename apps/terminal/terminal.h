#pragma once

#include <map>
#include <string>

#include "samara/base/progress.h"
#include "samara/models/interface/model.h"

/// Exit codes, and everything that goes to stderr. What stderr does not take is lost; the answer and
/// the exit code are not.
namespace samara::apps {

inline constexpr int kDone = 0;
inline constexpr int kInternalFailure = 1;
inline constexpr int kWrongCall = 2;
inline constexpr int kBadInput = 3;
inline constexpr int kToleranceMissed = 4;
inline constexpr int kOutsideBox = 5;
inline constexpr int kInterrupted = 130;

/// To be called first. Closed standard streams are opened such that they can be neither read nor written:
/// else a file opened later would take their descriptor, and receive what is written to them.
void hold_closed_streams();
/// @throws InputError if stdin is one of them, or a directory. @param expected in it
void require_stdin(const std::string& expected);

/// How much is said on stderr. Errors always are.
enum class Verbosity {
  quiet,    ///< nothing else
  usual,    ///< warnings, narration, progress
  verbose,  ///< also every stage as it begins, and every note
};
void set_verbosity(Verbosity verbosity);
bool is_verbose();

/// "samara: <sentence>" on stderr.
void complain(const std::string& sentence);
/// "samara: warning: <sentence>" on stderr.
void warn(const std::string& sentence);
/// Warns of values (SI, by parameter) that no body or fluid has.
void warn_of_parameters(const models::Model& model, const std::map<std::string, double>& values);
/// One line of narration on stderr.
void narrate(const std::string& line);
/// Lines of help on stderr, whatever the verbosity.
void explain_on_stderr(const std::string& lines);

/// Draws one line that overwrites itself, if stderr is a terminal: what is done, how long it has taken, how long its
/// stage may still take. Else prints such a line every half minute, and --verbose also one for each stage. Asks for
/// the work to end once is_interrupted().
ProgressCallback progress_line();
/// Removes that line.
void clear_progress();

}  // namespace samara::apps
