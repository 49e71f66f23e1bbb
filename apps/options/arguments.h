#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

/// What the user typed, as plain values, where several files ask for it; what one command alone asks for stands in its
/// file.
namespace samara::apps {

/// A body in a fluid, as given on the command line.
struct BodyWords {
  std::string body;  ///< ellipsoid, disc, plate, or a mesh file; empty: none
  std::vector<std::string> sizes;
  std::string unit;  ///< of the file
  std::string density;
  std::string fluid;
  /// "panels" or "ellipsoid"; empty: by panels of a mesh, of the ellipsoid of a shape.
  std::string added_mass;
};

/// Many realisations of one motion in a random flow.
struct CloudWords {
  std::string realisations;                ///< empty: a single trajectory is asked for
  std::string seed, first;                 ///< empty: 1 and 0
  std::vector<std::string> turbulence;     ///< kind and NAME=VALUE; empty: none
  std::string flow, speed, length, place;  ///< file of a flow, how fast, how large, where; empty: none
  std::vector<std::string> flow_at;        ///< NAME=VALUE, where it is a codebook of flows
  std::string outside;                     ///< of the flow's grid: end or stream; empty: end
  std::string C_0, radius;                 ///< empty: the default
  bool rotation = false;
  std::vector<std::string> states;
  std::string ground;  ///< empty: none
  std::string keep;    ///< empty: none
  bool antithetic = false;
  std::string relative_error;  ///< empty: all realisations
  std::string threads;         ///< empty: as many as the machine has
  std::string picture;
  bool json = false;
};

/// A body as it is drawn.
struct ShownWords {
  std::string body;  ///< ellipsoid, disc, plate, or a mesh file; empty: as the model's parameters say
  std::vector<std::string> sizes;
  std::string unit;  ///< of the file
};

struct SimulateArguments {
  std::string model;
  BodyWords body;
  std::vector<std::string> set;
  std::string until = "1";
  int frames = 101;
  std::string integrator = "cvodes";
  std::string step;  ///< empty: none was given
  bool forces = false;
  std::string coefficients;  ///< codebook of a series that parameters follow
  std::string wind;          ///< file of a wind; empty: the model's own
  CloudWords cloud;
  std::string output;
};

struct QueryArguments {
  std::string book;
  std::vector<std::string> set;
  std::vector<std::string> at;
  std::optional<int> frames;  ///< rows over the whole time; none: 11
  std::string points;         ///< table of points; "-": stdin
  std::string until;          ///< empty: the codebook's own time
  std::string second;         ///< codebook of attitudes upside down, of composed windows; empty: none
  bool gradient = false;
  bool clamp = false;
  ShownWords body;  ///< of an animation
  std::string output;
  bool json = false;
};

/// A call of the command: what it is for, or nothing but an exit code (help, version, a wrong call).
struct Arguments {
  std::optional<int> exit_code;
  bool quiet = false, verbose = false;
  std::vector<std::string> model_libraries;
  std::function<int()> run;  ///< returns the exit code; errors are exceptions of samara::Error
};

/// Prints help to stdout and mistakes to stderr itself.
Arguments parse(int argc, const char* const* argv);

}  // namespace samara::apps
