#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// What the user typed, as plain values; the only file that knows the option parser is arguments.cpp.
namespace samara::apps {

struct ModelsArguments {
  std::string model;  ///< empty: all
  bool json = false;
  bool check = false;  ///< what check_model() says of it
};

/// A body in a fluid, as given on the command line.
struct BodyWords {
  std::string body;  ///< ellipsoid, disc, plate, or a mesh file; empty: none
  std::vector<std::string> sizes;
  std::string unit;  ///< of the file
  std::string density;
  std::string fluid;
  std::string
      added_mass;  ///< "panels" or "ellipsoid"; empty: by panels of a mesh, of the ellipsoid of a shape
};

/// Many realisations of one motion in a random flow.
struct CloudWords {
  std::string realisations;             ///< empty: a single trajectory is asked for
  std::string seed, first;              ///< empty: 1 and 0
  std::vector<std::string> turbulence;  ///< kind and NAME=VALUE; empty: none
  std::string C_0, radius;              ///< empty: the default
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
  CloudWords cloud;
  std::string output;
};

struct BuildArguments {
  std::string plan;
  std::string output;
  bool resume = false;
  bool fresh = false;
  bool force = false;
};

struct InfoArguments {
  std::string book;
  bool json = false;
};

struct StatsArguments {
  std::string book;
  std::vector<std::string> set, groups;
  std::string fit;
  std::vector<double> quantiles;
  int draws = 4096;
  std::uint64_t seed = 1;
  bool json = false;
};

struct QueryArguments {
  std::string book;
  std::vector<std::string> set;
  std::vector<std::string> at;
  std::string until;  ///< empty: the codebook's own time
  bool gradient = false;
  bool clamp = false;
  std::string output;
  bool json = false;
};

struct ExportArguments {
  std::string book;
  std::string to;  ///< "paraview"
  std::vector<std::string> set;
  std::vector<std::string> at;
  std::string output;
};

struct ValidateArguments {
  std::string book;
  std::string plan;  ///< whose command is called; empty: the codebook is one of a model
  std::optional<int> points;
  std::uint64_t seed = 1;
  bool json = false;
};

struct FitArguments {
  std::string source;  ///< codebook file or model name
  std::vector<std::string> captures;
  std::string sidecar;  ///< of every table; empty: those beside them
  std::string config;
  std::string span;
  std::string coefficients;  ///< JSON of another fit
  bool reference = false;
  bool profiles = false;
  std::vector<std::string> left_out;
  std::string left_out_span;
  std::string ahead;
  std::string output;
  std::string report;
  std::string series;  ///< codebook of a series to write
  bool json = false;
};

struct BodyArguments {
  BodyWords words;
  std::string viscosity;  ///< empty: no Reynolds number
  bool json = false;
  bool toml = false;
};

struct DesignArguments {
  std::string source;  ///< codebook file or model name
  std::string fit;     ///< JSON
  std::string config;
  int captures = 1;
  std::string duration;       ///< empty: as the fit
  std::optional<int> frames;  ///< none: as the fit
  std::vector<std::string> release;
  std::vector<std::string> set;
  std::vector<std::string> outputs;
  std::vector<std::string> noise;
  std::string criterion = "D";
  std::vector<std::string> coefficients;
  int times = 0;
  int draws = 8;
  std::uint64_t seed = 1;
  std::string output;
  bool json = false;
};

/// One of the commands, or nothing but an exit code (help, version, a wrong call).
struct Arguments {
  std::optional<int> exit_code;
  std::vector<std::string> model_libraries;
  std::optional<ModelsArguments> models;
  std::optional<SimulateArguments> simulate;
  std::optional<BuildArguments> build;
  std::optional<InfoArguments> info;
  std::optional<QueryArguments> query;
  std::optional<StatsArguments> stats;
  std::optional<ExportArguments> exported;
  std::optional<ValidateArguments> validate;
  std::optional<FitArguments> fit;
  std::optional<BodyArguments> body;
  std::optional<DesignArguments> design;
};

/// Prints help to stdout and mistakes to stderr itself.
Arguments parse(int argc, const char* const* argv);

}  // namespace samara::apps
