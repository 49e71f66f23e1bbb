#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "commands.h"
#include "output.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/file/save.h"
#include "samara/io/atomic_file.h"
#include "terminal.h"

namespace samara::apps {

int run(const BuildArguments& arguments) {
  // A build may take long: that its result cannot be written should be known before. No stream takes a
  // codebook.
  check_output(arguments.output, {arguments.plan});
  { const io::PendingFile probe(arguments.output); }
  const codebooks::Plan plan = codebooks::read_plan(arguments.plan);
  codebooks::BuildOptions options;
  options.checkpoint = arguments.output + ".checkpoint";
  options.keep_checkpoint = true;
  options.resume = arguments.resume;
  if (arguments.resume && !std::filesystem::exists(options.checkpoint))
    narrate(fmt::format("there is no {} to resume from: the build begins anew", options.checkpoint.string()));
  options.progress = progress_line();
  options.warning = [](const std::string& sentence) { warn(sentence); };
  const codebooks::BuildResult result = codebooks::build(plan, options);
  codebooks::save(result.book, arguments.output);
  if (!result.resumable) {
    std::error_code ignored;
    std::filesystem::remove(options.checkpoint, ignored);
  }
  narrate(fmt::format("built {} by {} in {:.1f} s: {}", arguments.output, result.book.build().builder,
                      result.book.provenance().build_seconds, effort(result.book)));
  print(to_table(*result.book.certificate(), result.book));
  if (result.met) return kDone;
  warn(fmt::format("{} is written and marked: {}", arguments.output, result.message));
  if (result.resumable) {
    warn(fmt::format("the calls that were answered are kept in {}: --resume goes on from there",
                     options.checkpoint.string()));
  }
  return kToleranceMissed;
}

}  // namespace samara::apps
