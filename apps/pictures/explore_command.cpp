#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/option_parts.h"
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

struct ExploreArguments {
  std::vector<std::string> books;
  std::vector<std::string> captures;
  std::string fit;  ///< JSON
  std::vector<std::string> outputs;
  ShownWords body;
  int times = 200;
  std::string output;
  bool json = false;
};

void check_page(const ExploreArguments& arguments) {
  std::vector<std::string> inputs = arguments.books;
  for (const std::string& capture : arguments.captures) {
    for (const std::filesystem::path& file : id::capture_files(capture)) inputs.push_back(file.string());
  }
  if (!arguments.fit.empty()) inputs.push_back(arguments.fit);
  if (!arguments.body.body.empty()) inputs.push_back(arguments.body.body);
  check_output(arguments.output, inputs);
  check_ending("--output", arguments.output, ".html");
}

int run_explore(const ExploreArguments& arguments) {
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

}  // namespace

void add_explore(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<ExploreArguments>();
  CLI::App* command = app.add_subcommand(
      "explore", "a page for the browser that evaluates codebooks: curves, captures, the body in motion");
  command->add_option("BOOK", values->books, "codebook files")->required();
  command
      ->add_option("--capture", values->captures,
                   "captures to show: tables, or sidecars (.toml); may be repeated")
      ->allow_extra_args(false);
  command->add_option("--fit", values->fit, "fit (samara fit -o FIT.json) where the sliders begin");
  command->add_option("--outputs", values->outputs, "to show; default: all");
  add_shown_words(*command, values->body);
  command->add_option("--times", values->times, "at which curves are drawn")
      ->capture_default_str()
      ->check(whole_number());
  command->add_option("-o,--output", values->output, "page to write, .html")->required();
  command->add_flag("--json", values->json, kJsonOfFile);
  on_call(*command, arguments, values, run_explore);
}

}  // namespace samara::apps
