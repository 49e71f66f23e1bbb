#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// What the user typed, as plain values; the option parser is known to arguments.cpp, option_parts.h, the files named
/// *_arguments.cpp and those in options/ only.
namespace samara::apps {

struct ModelsArguments {
  std::string model;  ///< empty: all
  std::string output;
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
  std::string realisations;                ///< empty: a single trajectory is asked for
  std::string seed, first;                 ///< empty: 1 and 0
  std::vector<std::string> turbulence;     ///< kind and NAME=VALUE; empty: none
  std::string flow, speed, length, place;  ///< file of a flow, how fast, how large, where; empty: none
  std::vector<std::string> flow_at;        ///< NAME=VALUE, where it is a codebook of flows
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

struct WindArguments {
  std::string file;
  std::vector<std::string> at;  ///< points; none: say what the wind is
  std::string until;            ///< empty: 600 s, as are those below
  std::string step;             ///< 0.05 s
  std::optional<std::uint64_t> seed;
  std::optional<std::uint64_t> realisation;
  std::string output;
  bool json = false;
};

struct BuildArguments {
  std::string plan;
  std::string output;  ///< empty: only with dry_run
  std::vector<std::string> set;
  std::string tolerance, threads;  ///< empty: those of the plan
  bool dry_run = false;
  bool resume = false;
  bool fresh = false;
  bool force = false;
  bool json = false;
};

struct PlanArguments {
  std::string model;
  std::string output;
  bool json = false;
};

/// Asked by the completion of shells.
struct NamesArguments {
  std::string source;  ///< a model, a codebook or a plan
};

struct InfoArguments {
  std::string book;
  bool plan = false;  ///< the text of the plan alone
  std::string output;
  bool json = false;
};

struct StatsArguments {
  std::string book;
  std::vector<std::string> set, groups;
  std::string fit;
  std::vector<double> quantiles;
  int draws = 4096;
  std::uint64_t seed = 1;
  std::string output;
  bool json = false;
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

struct PlotArguments {
  std::string input;  ///< codebook, JSON of a fit, or table
  std::string of;     ///< empty: trajectories of a codebook, captures of a fit
  std::vector<std::string> set;
  std::vector<std::string> outputs;
  std::string capture;  ///< id, of a fit
  int points = 64;      ///< of errors
  std::uint64_t seed = 1;
  int columns = 2;
  std::string title;
  std::string output;
  bool json = false;
};

struct ExportArguments {
  std::string book;
  std::string to;  ///< "paraview", "flat"
  std::vector<std::string> set;
  std::vector<std::string> at;
  std::string output;
  bool json = false;
};

struct ValidateArguments {
  std::string book;
  std::string plan;  ///< whose command is called; empty: the codebook is one of a model
  std::optional<int> points;
  std::uint64_t seed = 1;
  std::string output;
  bool json = false;
};

struct FitArguments {
  std::string source;  ///< codebook file or model name
  std::vector<std::string> captures;
  std::string sidecar;  ///< of every table; empty: those beside them
  std::string petab;    ///< folder for the tables of a PEtab problem
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
  std::string output;
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

struct CompareArguments {
  std::vector<std::string> configs;
  std::vector<std::string> sources;  ///< codebook files or model names: one for all, or one for each config
  std::vector<std::string> captures;
  std::string sidecar;  ///< of every table; empty: those beside them
  std::string by;
  std::optional<int> folds;
  std::string span, ahead;  ///< empty: as the configs say
  int replicates = 1000;
  std::uint64_t seed = 1;
  std::string output;
  bool json = false;
};

struct FollowArguments {
  std::string source;  ///< model, or codebook file
  std::string fit;     ///< JSON
  std::string track;
  std::string sidecar;
  std::string config;
  std::vector<std::string> training;
  std::string ahead;  ///< empty: no forecasts
  std::vector<std::string> noise;
  std::string velocity_noise, rate_noise, spread, drift, step;
  std::optional<int> start_frames;
  std::string output;
  bool json = false;
};

struct FlowArguments {
  std::string plan;
  std::string output;
  bool resume = false;
  bool fresh = false;
  bool json = false;
};

struct PictureArguments {
  std::string flow;
  std::vector<std::string> set;  ///< NAME=VALUE, where it is a codebook of flows
  std::string field = "k";
  int scale = 0;  ///< 0: chosen by the size of the grid
  bool no_streamlines = false;
  std::string output;
  bool json = false;
};

struct SweepArguments {
  std::string plan;
  std::string output;
  bool resume = false;
  bool fresh = false;
  bool json = false;
};

struct DatabaseArguments {
  std::string sweep;
  std::string output;
  bool json = false;
};

struct PatternsArguments {
  std::vector<std::string> inputs;   ///< a sweep, or captures
  std::string sidecar;               ///< of every table; empty: those beside them
  std::string labels;                ///< a person's, of segments
  std::vector<std::string> classes;  ///< what these words mean
  std::string length;                ///< of the body; empty: not known
  std::string body;                  ///< model of the body of captures; empty: not known
  std::vector<std::string> set;      ///< values of its parameters; of a sweep those of the point to clamp
  std::vector<std::string> thresholds;
  std::string report;  ///< page to write; empty: none
  int clusters = 4;
  std::string draw,
      clamp;  ///< of a sweep: the pattern that points are to lead to; empty: a report is asked for
  std::optional<long> count, release;
  std::optional<std::uint64_t> seed;
  std::string output;
  bool json = false;
};

struct RegimeArguments {
  std::string model;
  std::vector<std::string> set;
  std::string output;
  std::string sweep;  ///< whose shares of patterns are told; empty: none
  bool json = false;
};

struct GhostArguments {
  std::string model;
  std::string path;              ///< table of poses
  std::vector<std::string> set;  ///< values of the model
  std::string coefficients;      ///< course that the motion declares, a file; empty: none
  std::vector<std::string> box;  ///< ranges of coefficients
  std::string output;            ///< sizes frame by frame; empty: none
  bool json = false;
};

struct SynthesizeArguments {
  std::string plan;
  std::string output;   ///< the motion
  std::string course;   ///< its coefficients, a file; empty: none
  std::string csv;      ///< its states; empty: none
  std::string picture;  ///< of path and coefficients; empty: none
  std::string report;   ///< page for the browser; empty: none
  bool resume = false;  ///< only go on from what an interrupted search has left
  bool fresh = false;   ///< begin anew
  ShownWords body;
  bool json = false;
};

/// One of the commands, or nothing but an exit code (help, version, a wrong call).
struct Arguments {
  std::optional<int> exit_code;
  bool quiet = false, verbose = false;
  std::vector<std::string> model_libraries;
  std::optional<ModelsArguments> models;
  std::optional<SimulateArguments> simulate;
  std::optional<PlanArguments> plan;
  std::optional<NamesArguments> names;
  std::optional<BuildArguments> build;
  std::optional<InfoArguments> info;
  std::optional<QueryArguments> query;
  std::optional<StatsArguments> stats;
  std::optional<ExportArguments> exported;
  std::optional<ExploreArguments> explore;
  std::optional<PlotArguments> plot;
  std::optional<ValidateArguments> validate;
  std::optional<FitArguments> fit;
  std::optional<BodyArguments> body;
  std::optional<DesignArguments> design;
  std::optional<CompareArguments> compare;
  std::optional<FollowArguments> follow;
  std::optional<WindArguments> wind;
  std::optional<FlowArguments> flow;
  std::optional<PictureArguments> picture;
  std::optional<SweepArguments> sweep;
  std::optional<DatabaseArguments> database;
  std::optional<PatternsArguments> patterns;
  std::optional<RegimeArguments> regime;
  std::optional<GhostArguments> ghost;
  std::optional<SynthesizeArguments> synthesize;
};

/// Prints help to stdout and mistakes to stderr itself.
Arguments parse(int argc, const char* const* argv);

}  // namespace samara::apps
