#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "samara/models/interface/parametric_model.h"
#include "samara/models/stochastic/ensemble.h"
#include "samara/models/stochastic/gust_layout.h"
#include "terminal/output.h"

/// A cloud of realisations as a table, as JSON, as HDF5 and in words.
namespace samara::apps {

/// What its file says of itself.
inline constexpr const char* kCloudFormat = "samara-cloud";

struct CloudFile {
  const models::Ensemble& cloud;
  const models::ParametricModel& model;
  std::uint64_t seed = 0;
  double step = 0.0;  ///< [s]
  std::optional<double> ground = {};
  double body_radius = 0.0;  ///< [m]
  std::string C_0;           ///< as it was given; empty: by the Reynolds number of the turbulence
  bool rotation = false;
  std::string air;  ///< what they fly through, in words
};

struct CloudTable {
  std::vector<std::string> header;
  Eigen::MatrixXd rows;
};

/// One row per time: how many fly, and of each state mean, its standard error and the deviation between realisations.
CloudTable cloud_table(const models::Ensemble& cloud);

/// All but trajectories and single landings; null where there are too few to tell.
Json cloud_json(const CloudFile& file);

/// All there is. @throws ArgumentError if the file cannot be written.
void write_cloud(const std::string& path, const CloudFile& file);

/// What became of them, in a sentence or two.
std::string cloud_summary(const CloudFile& file, const models::GustLayout& layout);

}  // namespace samara::apps
