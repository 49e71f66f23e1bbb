#include "options/flow_arguments.h"

#include <memory>

#include <CLI/CLI.hpp>

#include "options/option_parts.h"

namespace samara::apps {

void add_flow(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<FlowArguments>();
  CLI::App* command = app.add_subcommand(
      "flow", "the flow about a body that is held in a stream, of a plan, with its turbulence");
  command->add_option("PLAN", values->plan, "plan with a table [flow], TOML")->required();
  command->add_option("-o,--output", values->output, "flow file to write, HDF5")->required();
  CLI::Option* resume = command->add_flag(
      "--resume", values->resume,
      "only go on where a run of the same plan and output stopped, which is done anyway if there is one");
  command->add_flag("--fresh", values->fresh, "begin anew, and drop what an earlier run has left")
      ->excludes(resume);
  command->add_flag("--json", values->json, kJson);
  command->callback([&arguments, values] { arguments.flow = *values; });
}

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
  command->callback([&arguments, values] { arguments.picture = *values; });
}

}  // namespace samara::apps
