#pragma once

#include "options/arguments.h"

/// The subcommands, one file each. They return the exit code; errors are exceptions of samara::Error.
namespace samara::apps {

int run(const ModelsArguments& arguments);
int run(const SimulateArguments& arguments);
int run(const PlanArguments& arguments);
int run(const NamesArguments& arguments);
int run(const BuildArguments& arguments);
int run(const InfoArguments& arguments);
int run(const QueryArguments& arguments);
int run(const StatsArguments& arguments);
int run(const ExportArguments& arguments);
int run(const ExploreArguments& arguments);
int run(const PlotArguments& arguments);
int run(const ValidateArguments& arguments);
int run(const FitArguments& arguments);
int run(const BodyArguments& arguments);
int run(const DesignArguments& arguments);
int run(const FollowArguments& arguments);
int run(const WindArguments& arguments);
int run(const FlowArguments& arguments);
int run(const PictureArguments& arguments);
int run(const SweepArguments& arguments);
int run(const DatabaseArguments& arguments);
int run(const PatternsArguments& arguments);
int run(const RegimeArguments& arguments);
int run(const GhostArguments& arguments);
int run(const SynthesizeArguments& arguments);

}  // namespace samara::apps
