#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "inputs/flows.h"
#include "options/option_parts.h"
#include "samara/flow/files/flow_picture.h"
#include "samara/io/atomic_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

struct PictureArguments {
  std::string flow;
  std::vector<std::string> set;  ///< NAME=VALUE, where it is a codebook of flows
  std::string field = "k";
  int scale = 0;  ///< 0: chosen by the size of the grid
  bool no_streamlines = false;
  std::string output;
  bool json = false;
};

int run_picture(const PictureArguments& arguments) {
  check_output(arguments.output, {arguments.flow});
  check_ending("--output", arguments.output, ".png");
  const flow::StoredFlow stored = flow_of_file(arguments.flow, arguments.set, "--set");
  flow::PictureOptions options;
  options.field = arguments.field;
  options.pixels_per_cell = arguments.scale;
  options.streamlines = !arguments.no_streamlines;
  io::write_text_atomically(arguments.output, io::format_png(flow::draw_flow(stored, options)));
  tell_of_file(arguments.output, arguments.json);
  return kDone;
}

}  // namespace

void add_picture(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<PictureArguments>();
  CLI::App* command = app.add_subcommand("picture", "a field of a flow file in colours, as PNG");
  command->add_option("FLOW", values->flow, "flow file, or codebook of the fields of flows")->required();
  command
      ->add_option("--set", values->set,
                   std::string("of a codebook, its angle_of_attack and log10_reynolds: ") + kAssignments)
      ->allow_extra_args(false);
  command
      ->add_option("--field", values->field,
                   "u, v, w, p, k, k_modelled, k_resolved, epsilon, or speed, of the mean velocity")
      ->capture_default_str();
  command->add_option("--scale", values->scale, "pixels along a cell; default: about 1200 pixels in all")
      ->check(CLI::Range(1, 64));
  command->add_flag("--no-streamlines", values->no_streamlines, "colours only");
  command->add_option("-o,--output", values->output, "picture to write, PNG")->required();
  command->add_flag("--json", values->json, kJsonOfFile);
  on_call(*command, arguments, values, run_picture);
}

}  // namespace samara::apps
