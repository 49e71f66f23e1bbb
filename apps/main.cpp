#include <exception>
#include <filesystem>
#include <new>

#include "commands.h"
#include "model_libraries.h"
#include "samara/base/errors.h"
#include "terminal.h"

namespace samara::apps {

namespace {

int dispatch(const Arguments& arguments) {
  if (arguments.exit_code) return *arguments.exit_code;
  load_model_libraries(arguments.model_libraries);
  if (arguments.models) return run(*arguments.models);
  if (arguments.simulate) return run(*arguments.simulate);
  if (arguments.build) return run(*arguments.build);
  if (arguments.info) return run(*arguments.info);
  if (arguments.query) return run(*arguments.query);
  if (arguments.stats) return run(*arguments.stats);
  if (arguments.exported) return run(*arguments.exported);
  if (arguments.explore) return run(*arguments.explore);
  if (arguments.plot) return run(*arguments.plot);
  if (arguments.validate) return run(*arguments.validate);
  if (arguments.fit) return run(*arguments.fit);
  if (arguments.design) return run(*arguments.design);
  if (arguments.wind) return run(*arguments.wind);
  if (arguments.flow) return run(*arguments.flow);
  if (arguments.picture) return run(*arguments.picture);
  if (arguments.sweep) return run(*arguments.sweep);
  if (arguments.database) return run(*arguments.database);
  if (arguments.patterns) return run(*arguments.patterns);
  if (arguments.regime) return run(*arguments.regime);
  if (arguments.ghost) return run(*arguments.ghost);
  if (arguments.synthesize) return run(*arguments.synthesize);
  return run(*arguments.body);
}

int guarded(int argc, const char* const* argv) {
  try {
    return dispatch(parse(argc, argv));
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
  return samara::apps::guarded(argc, argv);
}
