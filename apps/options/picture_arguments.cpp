#include "options/option_parts.h"

/// The options of what is looked at: pages, pictures, animations.
namespace samara::apps {

void add_shown_words(CLI::App& command, ShownWords& words) {
  command.add_option("--body", words.body,
                     std::string("what is drawn, if the model's parameters do not say it: ") + kBody);
  command.add_option("--size", words.sizes,
                     "semi-axes of an ellipsoid; radius and thickness of a disc; full sides of a plate");
  command.add_option("--unit", words.unit, "of a mesh file, which says none: mm, cm, m");
}

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
  on_call(command, arguments.explore, values);
}

void add_plot(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<PlotArguments>();
  CLI::App* command = app.add_subcommand("plot", "a picture of a codebook, a fit or a table, as SVG");
  command->add_option("INPUT", values->input, "codebook, fit (.json), or table (.csv, .tsv)")->required();
  command
      ->add_option(
          "--of", values->of,
          "of a codebook: trajectories (the default), error, ranks, indices (of Sobol'); of a fit: captures "
          "(the default), profiles")
      ->check(CLI::IsMember({"trajectories", "error", "ranks", "indices", "captures", "profiles"}));
  command
      ->add_option(
          "--set", values->set,
          std::string("of trajectories; the middle of the box where nothing is said: ") + kAssignments)
      ->allow_extra_args(false);
  command->add_option("--outputs", values->outputs, "to show; default: all");
  command->add_option("--capture", values->capture, "id of a capture of the fit; default: the first");
  command->add_option("--points", values->points, "of errors")->capture_default_str()->check(whole_number());
  command->add_option("--seed", values->seed, "of these points, from 0")
      ->capture_default_str()
      ->check(whole_number<std::uint64_t>());
  command->add_option("--columns", values->columns, "of panels")
      ->capture_default_str()
      ->check(whole_number());
  command->add_option("--title", values->title, "above the picture");
  command->add_option("-o,--output", values->output, "picture to write, .svg")->required();
  command->add_flag("--json", values->json, kJsonOfFile);
  on_call(command, arguments.plot, values);
}

}  // namespace samara::apps
