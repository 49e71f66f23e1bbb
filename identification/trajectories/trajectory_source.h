#pragma once

#include "samara/models/trajectories/averaged_source.h"
#include "samara/models/trajectories/interval.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Where a fit takes its trajectories from: any family of trajectories
/// (models/trajectories/trajectory_family.h). Its words, as fits use them.
namespace samara::identification {

using models::FamilyInfo;
using models::FrameMean;
using models::Interval;
using models::TrajectoryFamily;
using models::TrajectoryOutcome;
using models::TrajectorySource;
using models::TrajectoryStatus;
using FitCoordinate = models::FamilyCoordinate;
using FitOutput = models::FamilyOutput;

}  // namespace samara::identification
