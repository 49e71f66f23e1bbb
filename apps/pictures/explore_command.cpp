#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "options/commands.h"
#include "pictures/shown_bodies.h"
#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/explorer/explorer_page.h"
#include "samara/identification/report/read_fit.h"
#include "samara/io/atomic_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

namespace id = samara::identification;

void check_page(const ExploreArguments& arguments) {
  std::vector<std::string> inputs = arguments.books;
  for (const std::string& capture : arguments.captures) {
    for (const std::filesystem::path& file : id::capture_files(capture)) inputs.push_back(file.string());
  }
  if (!arguments.fit.empty()) inputs.push_back(arguments.fit);
  if (!arguments.body.body.empty()) inputs.push_back(arguments.body.body);
  check_output(arguments.output, inputs);
}

}  // namespace

int run(const ExploreArguments& arguments) {
  check_page(arguments);
  id::ExplorerContent content{.books = {},
                              .outputs = arguments.outputs,
                              .body = shown_mesh(arguments.body),
                              .times = arguments.times};
  for (const std::string& path : arguments.books) {
    content.books.push_back({codebooks::load(path), std::filesystem::path(path).filename().string()});
    warn_of_missed_tolerance(content.books.back().book, path);
  }
  for (const std::string& path : arguments.captures) {
    std::vector<id::Capture> captures = id::read_captures(path);
    std::move(captures.begin(), captures.end(), std::back_inserter(content.captures));
  }
  if (!arguments.fit.empty()) content.fit = id::read_fit(arguments.fit);
  const id::ExplorerPage page = id::explorer_page(content);
  for (const std::string& sentence : page.warnings) warn(sentence);
  io::write_text_atomically(arguments.output, page.html);
  tell_of_file(arguments.output, arguments.json);
  return kDone;
}

}  // namespace samara::apps
