#include "options/option_parts.h"

#include <CLI/CLI.hpp>

namespace samara::apps {

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
  option("--outside", words.outside,
         "what a flight that leaves the grid of --flow meets: end (it ends there as left_flow, which is the "
         "default) or stream (the stream as it flows in)");
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

void add_shown_words(CLI::App& command, ShownWords& words) {
  command.add_option("--body", words.body,
                     std::string("what is drawn, if the model's parameters do not say it: ") + kBody);
  command.add_option("--size", words.sizes,
                     "semi-axes of an ellipsoid; radius and thickness of a disc; full sides of a plate");
  command.add_option("--unit", words.unit, "of a mesh file, which says none: mm, cm, m");
}

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

}  // namespace samara::apps
