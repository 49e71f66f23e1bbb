#include <exception>
#include <filesystem>
#include <new>

#include <fmt/format.h>
#include <sys/resource.h>

#include "inputs/model_libraries.h"
#include "options/arguments.h"
#include "samara/base/errors.h"
#include "terminal/interrupts.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

int dispatch(const Arguments& arguments) {
  if (arguments.exit_code) return *arguments.exit_code;
  set_verbosity(arguments.quiet     ? Verbosity::quiet
                : arguments.verbose ? Verbosity::verbose
                                    : Verbosity::usual);
  load_model_libraries(arguments.model_libraries);
  return arguments.run();
}

/// What --verbose says when all is done.
int told_what_it_took(int code) {
  if (!is_verbose()) return code;
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  narrate(fmt::format("took {:.2f} s of processor time and {:.0f} MB",
                      seconds(usage.ru_utime) + seconds(usage.ru_stime),
                      static_cast<double>(usage.ru_maxrss) / 1024.0));
  return code;
}

int guarded(int argc, const char* const* argv) {
  try {
    return told_what_it_took(dispatch(parse(argc, argv)));
  } catch (const OutsideBoxError& error) {
    complain(error.what());
    return kOutsideBox;
  } catch (const NoResultError& error) {
    complain(error.what());
    return kToleranceMissed;
  } catch (const InputError& error) {
    complain(error.what());
    return kBadInput;
  } catch (const ArgumentError& error) {
    complain(error.what());
    return kWrongCall;
  } catch (const std::filesystem::filesystem_error& error) {
    // A path that the system refuses where no check has looked for it.
    complain(error.what());
    return kWrongCall;
  } catch (const std::bad_alloc&) {
    complain("there is not enough memory for this");
    return kInternalFailure;
  } catch (const std::exception& error) {
    complain(error.what());
    return kInternalFailure;
  }
}

}  // namespace

}  // namespace samara::apps

int main(int argc, char** argv) {
  samara::apps::hold_closed_streams();
  samara::apps::end_when_interrupted();
  return samara::apps::guarded(argc, argv);
}
