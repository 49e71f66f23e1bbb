#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "measured_data.h"
#include "samara/identification/captures/capture_cleaning.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/captures/capture_suspicions.h"
#include "samara/identification/smoothing/smoothing_attitude.h"
#include "samara/io/delimited_table.h"

using namespace samara::identification;
using Eigen::Index;

namespace {

std::filesystem::path sidecar(const std::string& name) {
  return std::filesystem::path(SAMARA_EXAMPLES_DIR) / "captures" / (name + ".toml");
}

/// Noise of one frame along the mean direction of flight, m.
double along_track_noise(const Capture& flight) {
  Eigen::MatrixX3d positions(flight.frame_count(), 3);
  for (Index k = 0; k < 3; ++k) positions.col(k) = flight.channels[static_cast<std::size_t>(k)].values;
  const Eigen::Vector3d way = (positions.bottomRows(1) - positions.topRows(1)).transpose().normalized();
  return smooth(flight.times, positions * way, flight.times.head(1),
                {.degree = 3, .bandwidth = 1.0, .outlier_threshold = INFINITY})
      .noise[0];
}

double median_of_durations(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

}  // namespace

TEST_CASE("table tennis: the frame grid takes along-track noise from millimetres to below one") {
  const auto folder = measured_data("table-tennis-ball-spin");
  if (folder.empty()) return;
  const std::vector<Capture> flights = read_captures(folder / "[0-9]*.csv", sidecar("table_tennis"));
  CHECK(flights.size() == 106);  // of 112, with 12 frames or more before they bounce
  std::vector<double> printed;
  std::vector<double> gridded;
  std::vector<double> durations;
  for (const Capture& flight : flights) {
    CHECK(flight.labels.contains("x_spin"));
    const int count = flight.frame_count();
    durations.push_back(flight.times[count - 1]);
    if (count < 15) continue;
    gridded.push_back(along_track_noise(flight));
    Capture as_printed = flight;
    const auto table = samara::io::DelimitedTable::read(flight.file, {.header = {"t", "x", "y", "z"}});
    Eigen::VectorXd times = table.numbers("t");
    times.conservativeResize(std::unique(times.begin(), times.end()) - times.begin());
    as_printed.times = times.head(count);
    printed.push_back(along_track_noise(as_printed));
  }
  // Found by an independent trial: 3.3 mm and 0.86 mm, and flights of 0.19 s in the median, the short ones
  // among them (cutting and noise estimated a little differently). Rounding to 1 mm alone makes 0.29 mm.
  CHECK(median_of_durations(printed) > 2.5e-3);
  CHECK(median_of_durations(gridded) < 0.9e-3);
  CHECK(std::abs(median_of_durations(durations) - 0.22) < 0.02);
}

TEST_CASE("blimp: pose and rates in SI units and the world z up agree with one another") {
  const auto folder = measured_data("blimp-rgblimp-mocap");
  if (folder.empty()) return;
  const Capture flight = read_captures(folder / "data_98.csv", sidecar("blimp")).front();
  CHECK(suspicions(flight) == std::vector<std::string>{});
  const Eigen::VectorXd at = flight.times.segment(30, 300);
  Eigen::MatrixX3d positions(flight.frame_count(), 3);
  Eigen::MatrixX4d quaternions(flight.frame_count(), 4);
  for (Index k = 0; k < 3; ++k) positions.col(k) = flight.channel(std::string(1, "xyz"[k])).values;
  for (Index k = 0; k < 4; ++k)
    quaternions.col(k) = flight.channel(kQuaternionChannels[static_cast<std::size_t>(k)]).values;
  const Smoothed path = smooth(flight.times, positions, at, {.bandwidth = 0.5});
  const SmoothedAttitude attitude = smooth_attitude(flight.times, quaternions, at, {.bandwidth = 0.5});
  double speed_error = 0.0;
  double rate_error = 0.0;
  for (Index k = 0; k < at.size(); ++k) {
    const Eigen::Quaterniond q(attitude.attitude(k, 0), attitude.attitude(k, 1), attitude.attitude(k, 2),
                               attitude.attitude(k, 3));
    const Eigen::Vector3d v = q.conjugate() * Eigen::Vector3d(path.rate.row(k).transpose());
    for (Index axis = 0; axis < 3; ++axis) {
      const std::string name(1, "xyz"[axis]);
      speed_error = std::max(speed_error, std::abs(v[axis] - flight.channel("u" + name).values[30 + k]));
      rate_error = std::max(rate_error, std::abs(attitude.angular_velocity(k, axis) -
                                                 flight.channel("w" + name).values[30 + k]));
    }
  }
  // Of 0.5 m/s and 0.6 rad/s: the source's own rates were differenced and smoothed in another way.
  CHECK(speed_error < 0.05);
  CHECK(rate_error < 0.1);
}

TEST_CASE("falling paper and settling plates are read with what is known of each drop") {
  const auto paper = measured_data("falling-paper-cambridge");
  const auto plates = measured_data("settling-plates-water-cardiff");
  if (paper.empty() || plates.empty()) return;
  const auto drops = read_captures(paper / "circle.csv", sidecar("falling_paper"));
  CHECK(drops.size() > 50);
  for (const Capture& drop : drops) {
    CHECK(drop.labels.at("shape") == "circle");
    CHECK(drop.has("silhouette_2"));
    // Down by about 1.1 m, of which the first 0.3 s and the last 3 cm are left out: z points up.
    CHECK(drop.channel("z").values[0] - drop.channel("z").values.minCoeff() > 0.35);
    CHECK(drop.channel("z").values.minCoeff() >= 0.03);
  }
  const auto settling = read_captures(plates / "POM_1x1_pos2.csv", sidecar("settling_plates"));
  CHECK(settling.size() > 10);
  for (const Capture& drop : settling) {
    CHECK(drop.labels.at("material") == "POM");
    CHECK(drop.has("area_2"));
    const Eigen::VectorXd& z = drop.channel("z").values;
    CHECK(z[0] - z.array().isNaN().select(z[0], z.array()).minCoeff() > 0.03);
  }
}

TEST_CASE("rough poses of a falling paper: flips are found, and a quaternion is made of Euler angles") {
  const auto folder = measured_data("paper-6dof-apriltag");
  if (folder.empty()) return;
  const auto pieces = read_captures(folder / "vid220_fall.csv", sidecar("april_tag_paper"));
  CHECK(pieces.size() == 9);
  std::map<std::string, std::vector<const Capture*>> cameras;
  for (const Capture& piece : pieces) {
    cameras[piece.motion].push_back(&piece);
    CHECK(piece.has("qw"));
    CHECK(std::ranges::any_of(piece.notes, [](const std::string& note) {
      return note.find("frames of attitude taken out: far from their neighbours") != std::string::npos;
    }));
    for (const Gap& gap : gaps(piece, "qw")) CHECK(gap.end - gap.begin < 0.036);
  }
  REQUIRE(cameras.size() == 3);
  for (const auto& [id, parts] : cameras) {
    const Eigen::VectorXd& first = parts.front()->channel("z").values;
    const Eigen::VectorXd& last = parts.back()->channel("z").values;
    CHECK(first[0] - last[last.size() - 1] > 0.3);
  }
}
