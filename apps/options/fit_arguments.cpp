#include <memory>

#include <CLI/CLI.hpp>

#include "options/option_parts.h"

/// The options of fits, of designs of experiments and of motions that are followed.
namespace samara::apps {

void add_fit(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<FitArguments>();
  CLI::App* command = app.add_subcommand("fit", "coefficients with uncertainty from captured trajectories");
  command
      ->add_option(
          "SOURCE", values->source,
          "codebook file, or a model by its name or its file of equations (with a config that has a [box])")
      ->required();
  // Not required for the parser, which would take the last capture left out for one to fit.
  command->add_option("CAPTURE", values->captures,
                      "capture files: tables, or sidecars (.toml) that map one; or one PEtab problem "
                      "(.yaml), config included");
  command->add_option("--sidecar", values->sidecar,
                      "what the columns of all tables given are, TOML, in place of sidecars beside them");
  command->add_option("--config", values->config, "what to fit and how, TOML");
  command->add_option(
      "--coefficients", values->coefficients,
      "JSON of another fit: its coefficients are where this one begins, or held where the "
      "config has no box for them; without a CAPTURE all are held, and --left-out is predicted");
  command->add_option("--span,--window", values->span,
                      "only this much of each capture from its first frame, s or with a unit");
  command->add_flag("--reference", values->reference,
                    "integrate (CVODES with sensitivities) instead of querying the codebook; only with one");
  command->add_flag("--profiles", values->profiles,
                    "fit again with each coefficient held at other values: intervals, and whether there is a "
                    "limit to both sides");
  command->add_option(
      "--left-out", values->left_out,
      "captures to predict, one or more: their span is seen, with the coefficients held, and --ahead is "
      "compared");
  command->add_option("--left-out-span,--left-out-window", values->left_out_span,
                      "how much of each of them is seen, s or with a unit; default: as --span");
  command->add_option("--ahead", values->ahead, "how far beyond the span to predict, s or with a unit");
  command->add_option("--petab", values->petab,
                      "of a PEtab problem: also write its tables as the fit leaves them, parameters.tsv and "
                      "simulations.tsv, into this folder");
  command->add_option("--series", values->series,
                      "write the coefficients that change in time, those of [series] in the config, to this "
                      "codebook, for samara simulate --coefficients");
  command->add_option("-o,--output", values->output, "also write the result as JSON to this file");
  command->add_option("--report", values->report, "also write a page for the browser to this file, HTML");
  command->add_flag("--json", values->json, "print one JSON object instead of the table");
  on_call(command, arguments.fit, values);
}

void add_design(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<DesignArguments>();
  CLI::App* command = app.add_subcommand(
      "design",
      "the next experiment: which releases, outputs and times would shrink the errors of a fit most");
  command
      ->add_option("SOURCE", values->source, "codebook file, or name of a model (with the config of the fit)")
      ->required();
  command->add_option("--fit", values->fit, "JSON of the fit so far (samara fit -o)")->required();
  command->add_option("--config", values->config, "of that fit, TOML; needed for a model only");
  command->add_option("--captures", values->captures, "how many more")
      ->capture_default_str()
      ->check(whole_number());
  command->add_option("--duration", values->duration,
                      "of each, s or with a unit; default: as the longest of the fit");
  command->add_option("--frames", values->frames, "of each; default: at the rate of the fit's")
      ->check(whole_number());
  command
      ->add_option(
          "--release", values->release,
          "a coordinate that can be chosen; default: all that are no coefficients; the others stay where "
          "the captures of the fit were in the mean")
      ->allow_extra_args(false);
  command
      ->add_option("--set", values->set,
                   "where a release must be, NAME=VALUE or NAME=FROM..TO, SI or with units: \"theta(0)=20 "
                   "deg..60 deg\"")
      ->allow_extra_args(false);
  command->add_option("--seen", values->outputs, "an output that is seen; default: what the fit compared")
      ->allow_extra_args(false);
  command->add_option("--noise", values->noise, "of an output, NAME=VALUE; default: what the fit found")
      ->allow_extra_args(false);
  command
      ->add_option("--criterion", values->criterion,
                   "D (the volume of what remains possible) or A (the mean square of relative errors)")
      ->capture_default_str();
  command->add_option("--for", values->coefficients, "a coefficient whose error counts; default: all")
      ->allow_extra_args(false);
  command->add_option("--times", values->times, "also find so many frames that say most alone")
      ->check(whole_number());
  command->add_option("--draws", values->draws, "of the coefficients from what the fit leaves open")
      ->capture_default_str()
      ->check(whole_number());
  command->add_option("--seed", values->seed, "of draws and first releases")
      ->capture_default_str()
      ->check(whole_number<std::uint64_t>());
  command->add_option("-o,--output", values->output, "also write the design as JSON to this file");
  command->add_flag("--json", values->json, "print one JSON object instead of the tables");
  on_call(command, arguments.design, values);
}

void add_follow(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<FollowArguments>();
  CLI::App* command = app.add_subcommand(
      "follow", "a motion frame by frame with a fitted model: state, coefficients, and what comes next");
  command
      ->add_option("SOURCE", values->source,
                   "a model by its name or its file of equations, or a codebook file")
      ->required();
  command->add_option("FIT", values->fit, "JSON of a fit of it (samara fit -o)")->required();
  command
      ->add_option("TRACK", values->track, "what was measured: a table, or a sidecar (.toml) that maps one")
      ->required();
  command->add_option("--sidecar", values->sidecar,
                      "what the columns of all tables given are, TOML, in place of sidecars beside them");
  command->add_option("--config", values->config,
                      "of the fit, TOML: where [known] finds values of the capture, and the step");
  command->add_option("--ahead", values->ahead,
                      "also forecast so far beyond every frame, s or with a unit: a mean and a band of 90 %");
  command->add_option(
      "--train", values->training,
      "captures on which the noise of model and frames, spread and drift are chosen, one or more");
  command
      ->add_option("--noise", values->noise,
                   "of frames of an output, NAME=VALUE; default: what the fit found")
      ->allow_extra_args(false);
  command->add_option(
      "--velocity-noise", values->velocity_noise,
      "what the model lacks: white noise in the rates of velocities, m/s per root of a second");
  command->add_option("--rate-noise", values->rate_noise,
                      "likewise in the rates of rates of rotation, rad/s per root of a second");
  command->add_option("--spread", values->spread,
                      "how far coefficients of one motion lie from those of the fit: 0.1 is 10 %");
  command->add_option("--drift", values->drift, "of coefficients, per root of a second: 0.1 is 10 %");
  command->add_option("--step", values->step, "of the integration at most, s or with a unit; default: 2 ms");
  command->add_option("--start-frames", values->start_frames, "from which the start is found; default: 8")
      ->check(whole_number());
  command->add_option("-o,--output", values->output,
                      "also write a table with a row a frame to this file, CSV");
  command->add_flag("--json", values->json, "print one JSON object instead of the text");
  on_call(command, arguments.follow, values);
}

}  // namespace samara::apps
