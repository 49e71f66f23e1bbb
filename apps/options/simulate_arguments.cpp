#include <CLI/CLI.hpp>

#include "options/option_parts.h"
#include "terminal/output.h"

namespace samara::apps {

namespace {

void add_cloud_words(CLI::App& command, CloudWords& words) {
  constexpr const char* kGroup = "Realisations in turbulence";
  const auto option = [&](const char* name, auto& value, const std::string& text) {
    return command.add_option(name, value, text)->group(kGroup);
  };
  option("--realisations", words.realisations,
         "how many flights of the same release: their statistics take the place of the trajectory");
  option("--seed", words.seed,
         "of the noise, or of the turbulence of --wind: the same seed gives the same flights; default: 1");
  option(
      "--turbulence", words.turbulence,
      "uniform or decaying, then deviation=0.3 (of a component) or k=.., and scale=1 (of the eddies) or "
      "epsilon=.., and the stream that carries it, stream_x=.., stream_y=.., stream_z=..; SI or with units");
  option("--flow", words.flow,
         "file of a flow (samara flow): the wake of its body, with its turbulence; the stream runs along x, "
         "the flow's y is up; or a codebook of such fields");
  option("--flow-set", words.flow_at,
         "of a codebook of fields: NAME=VALUE of its angle_of_attack and log10_reynolds, one a time")
      ->allow_extra_args(false);
  option("--speed", words.speed, "of the stream of --flow, m/s or with a unit");
  option("--length", words.length, "of the body of --flow, m or with a unit");
  option("--flow-place", words.place, "where the centre of that body is: \"0, 0, 1 m\"; default: the origin");
  option("--C0", words.C_0,
         "constant of the structure function; default: by the Reynolds number of the turbulence");
  option("--body-radius", words.radius,
         "of the disc over which the body averages the fluid, m or with a unit; default: the body's own; 0: "
         "a point");
  command.add_flag("--rotation", words.rotation, "eddies larger than the body turn it, too (not validated)")
      ->group(kGroup);
  option("--ground", words.ground, "height at which a body has landed, m or with a unit");
  option("--states", words.states, "whose statistics are wanted, one a time; default: the place")
      ->allow_extra_args(false);
  option("--keep", words.keep,
         "trajectories of that many first realisations go into the file; of .glb and .usda up to 1000 by "
         "themselves");
  option("--first", words.first,
         "number of the first realisation: any can be seen again by itself; default: 0");
  command.add_flag("--antithetic", words.antithetic, "in pairs of opposite noise")->group(kGroup);
  option("--relative-error", words.relative_error,
         "stop once the mean displacement is known within this share of its root mean square");
  option("--threads", words.threads, "default, and 0: as many as the machine has");
  option("--picture", words.picture, "SVG of paths, mean and landing places");
}

}  // namespace

void add_body_words(CLI::App& command, BodyWords& words, bool required) {
  command.add_option("--size", words.sizes,
                     "semi-axes of an ellipsoid; radius and thickness of a disc; full sides of a plate");
  command.add_option("--unit", words.unit, "of a mesh file, which says none: mm, cm, m");
  command.add_option("--density", words.density, "of the body, kg/m^3 or with a unit")->required(required);
  command.add_option("--fluid", words.fluid, "density of the fluid, kg/m^3 or with a unit")
      ->required(required);
  command
      .add_option(
          "--added-mass", words.added_mass,
          "by panels, of plates, ellipsoids and meshes, or of the ellipsoid with the same extents; default: "
          "panels of a mesh, else ellipsoid")
      ->check(CLI::IsMember({"panels", "ellipsoid"}));
}

void add_simulate(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<SimulateArguments>();
  CLI::App* command = app.add_subcommand("simulate", "one trajectory, as CSV; or many in turbulence");
  command
      ->add_option("MODEL", values->model,
                   "name of a model (samara models), or file with equations (MODEL.toml)")
      ->required();
  command->add_option("--set", values->set, kAssignments)->allow_extra_args(false);
  command->add_option("--body", values->body.body,
                      std::string("of kirchhoff_body: its parameters from ") + kBody);
  add_body_words(*command, values->body, false);
  command->add_option("--until", values->until, "end of the trajectory, s or with a unit")
      ->capture_default_str();
  command->add_option("--frames", values->frames, "rows, equally spaced in time")
      ->capture_default_str()
      ->check(whole_number());
  command
      ->add_option(
          "--integrator", values->integrator,
          "cvodes (the reference), bdf (the same for stiff equations), adaptive (orders 7 and 8), or "
          "with fixed steps: rk4, rkmk (the attitude stays a rotation), lie_group (of one rigid body: "
          "neither energy nor momentum drifts)")
      ->check(CLI::IsMember({"cvodes", "bdf", "adaptive", "rk4", "rkmk", "lie_group"}))
      ->capture_default_str();
  command->add_option("--step", values->step,
                      "of rk4, rkmk, lie_group and realisations, s or with a unit; frames divide it further");
  command->add_flag("--forces", values->forces,
                    "add what every force term does: TERM.Fx, TERM.Fy, .. (force), TERM.T.. (torque) in body "
                    "axes, TERM.power, and the kinetic energy where the model has one");
  command->add_option(
      "--coefficients", values->coefficients,
      "codebook of a series (samara fit --series) that parameters follow in time; what else it "
      "holds, such as the start, counts where --set says nothing");
  command->add_option("--wind", values->wind,
                      "of bodies in space: file of a wind (WIND.toml), with its turbulence drawn by --seed");
  add_cloud_words(*command, values->cloud);
  command->add_flag("--json", values->cloud.json,
                    "print one JSON object: the trajectory, or of realisations means, covariances, landings "
                    "and their errors");
  command->add_option("-o,--output", values->output,
                      "CSV file, of realisations also HDF5 (.h5), or the motion of the body (.glb or .usda), "
                      "of which --body, "
                      "--size and --unit may then say what is drawn; stdout if not given");
  on_call(command, arguments.simulate, values);
}

void add_wind(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<WindArguments>();
  CLI::App* command =
      app.add_subcommand("wind", "what a file of a wind means; series of its turbulence at points");
  command->add_option("WIND", values->file, "file of a wind (WIND.toml)")->required();
  CLI::Option* at =
      command
          ->add_option("--at", values->at,
                       "a point, along the wind, across it and up, m or with units: \"0, 5 m, 30 m\"; "
                       "may be repeated")
          ->allow_extra_args(false);
  command->add_option("--until", values->until, "duration of the series, s or with a unit; default 600 s")
      ->needs(at);
  command->add_option("--step", values->step, "of the series, s or with a unit; default 0.05 s")->needs(at);
  command->add_option("--seed", values->seed, "default 1")->check(whole_number<std::uint64_t>())->needs(at);
  command->add_option("--realisation", values->realisation, "number of the series of that seed; default 0")
      ->check(whole_number<std::uint64_t>())
      ->needs(at);
  command
      ->add_option("-o,--output", values->output, "CSV file of the series, which --at needs but for --json")
      ->needs(at);
  command->add_flag("--json", values->json, kJson);
  on_call(command, arguments.wind, values);
}

}  // namespace samara::apps
