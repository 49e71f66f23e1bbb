#include "samara/codebooks/source/realisation_checkpoint.h"

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <sys/stat.h>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/models/laws/registry.h"
#include "samara/models/stochastic/fluid_seen.h"

using Catch::Matchers::Contains;
using samara::codebooks::RealisationCheckpoint;
using samara::models::Ensemble;
using samara::models::ParametricModel;
using samara::models::RealiseOptions;

namespace {

const std::vector<double> kFlightTimes = {0.0, 0.05};

ParametricModel ball(double speed = 1.0) {
  return {samara::models::find_model("sphere_flight_in_gusts"), {{"vx(0)", speed}}, {}};
}

std::shared_ptr<const samara::models::AirSource> gusty_air() {
  return samara::models::fluid_seen_in(samara::models::uniform_turbulence(0.1, 0.2), 7, {.C_0 = 6.0});
}

/// @param told gets the sentences that were told on the way
Ensemble flown(const RealiseOptions& options, RealisationCheckpoint checkpoint,
               std::vector<std::string>& told, double speed = 1.0) {
  told.clear();
  checkpoint.note = checkpoint.warning = [&](const std::string& sentence) { told.push_back(sentence); };
  return samara::codebooks::realise(ball(speed), {}, *gusty_air(), kFlightTimes, options, checkpoint);
}

}  // namespace

TEST_CASE("realisations that were cut off go on from their checkpoint to the same bits, and it is removed") {
  const TemporaryDirectory directory;
  const RealisationCheckpoint checkpoint = {.file = directory / "cloud.checkpoint", .air = "seed 7"};
  const RealiseOptions options = {.realisations = 1536};
  const Ensemble all = samara::models::realise(ball(), {}, *gusty_air(), kFlightTimes, options);
  std::vector<std::string> told;
  // Killed after the first 1024, which are in the file by then.
  RealiseOptions killed = options;
  killed.so_far = [](const Ensemble&) { throw std::runtime_error("killed"); };
  CHECK_THROWS_WITH(flown(killed, checkpoint, told), "killed");
  REQUIRE(std::filesystem::exists(checkpoint.file));
  const Ensemble resumed = flown(options, checkpoint, told);
  REQUIRE(told.size() == 1);
  CHECK_THAT(told[0], Contains("cloud.checkpoint holds 1024 realisations of this call, which goes on"));
  CHECK(resumed.mean == all.mean);
  CHECK(resumed.mean_error == all.mean_error);
  CHECK(resumed.status == all.status);
  CHECK_FALSE(std::filesystem::exists(checkpoint.file));
}

TEST_CASE("a checkpoint of realisations that is to be kept stays until its owner removes it") {
  const TemporaryDirectory directory;
  const RealisationCheckpoint checkpoint = {
      .file = directory / "cloud.checkpoint", .keep = true, .air = "seed 7"};
  std::vector<std::string> told;
  const Ensemble all = flown({.realisations = 1536}, checkpoint, told);
  CHECK(told.empty());
  const Ensemble again = flown({.realisations = 1536}, checkpoint, told);
  REQUIRE(told.size() == 1);
  CHECK_THAT(told[0], Contains("cloud.checkpoint holds 1024 realisations of this call"));
  CHECK(again.mean == all.mean);
  CHECK(std::filesystem::exists(checkpoint.file));
}

TEST_CASE(
    "a checkpoint of realisations of another call, or an empty file, is replaced, and no file of others") {
  const TemporaryDirectory directory;
  const RealisationCheckpoint checkpoint = {.file = directory / "cloud.checkpoint", .air = "seed 7"};
  const RealiseOptions options = {.realisations = 512};
  RealiseOptions killed = {.realisations = 1536};
  killed.so_far = [](const Ensemble&) { throw std::runtime_error("killed"); };
  std::vector<std::string> told;
  const auto is_replaced = [&](const RealisationCheckpoint& other, double speed) {
    flown(options, other, told, speed);
    return told.size() == 1 && told[0].find("is of another call, and is replaced") != std::string::npos;
  };
  // The last call asks for fewer than were left.
  for (const auto& [air, speed] : {std::pair{"seed 8", 1.0}, {"seed 7", 2.0}, {"seed 7", 1.0}}) {
    CHECK_THROWS(flown(killed, checkpoint, told));
    RealisationCheckpoint other = checkpoint;
    other.air = air;
    CHECK(is_replaced(other, speed));
  }
  put_content(checkpoint.file, "");
  CHECK(is_replaced(checkpoint, 1.0));
  put_content(checkpoint.file, "t,x,y,z\n0,1,2,3\n");
  CHECK_THAT(error_text<samara::InputError>([&] { flown(options, checkpoint, told); }),
             Contains("cloud.checkpoint: this is no checkpoint of a build or a cloud"));
  CHECK(content(checkpoint.file) == "t,x,y,z\n0,1,2,3\n");
}

TEST_CASE("options of realisations that are wrong are named before a checkpoint is looked at") {
  const TemporaryDirectory directory;
  const RealisationCheckpoint checkpoint = {.file = directory / "cloud.checkpoint", .air = "seed 7"};
  std::vector<std::string> told;
  const auto refusal = [&](const RealiseOptions& options) {
    const std::string sentence = error_text<samara::ArgumentError>([&] { flown(options, checkpoint, told); });
    CHECK(told.empty());
    return sentence;
  };
  const auto check_refusals = [&] {
    CHECK_THAT(refusal({.realisations = 0}), Contains("realisations is 0; at least 1 was expected"));
    CHECK_THAT(refusal({.first = -1}), Contains("first is -1; 0 or more was expected"));
    CHECK_THAT(refusal({.step = 0.0}), Contains("step is 0"));
    CHECK_THAT(refusal({.states = {"speed"}}), Contains("has no state \"speed\""));
    CHECK_THAT(refusal({.states = {"z", "x", "z"}}), Contains("states have \"z\" twice"));
    CHECK_THAT(refusal({.ground = 3.0}), Contains("expected below the start"));
    CHECK_THAT(refusal({.max_steps = 10}), Contains("are more than 10"));
  };
  RealiseOptions killed = {.realisations = 1536};
  killed.so_far = [](const Ensemble&) { throw std::runtime_error("killed"); };
  CHECK_THROWS_WITH(flown(killed, checkpoint, told), "killed");
  const std::string before = content(checkpoint.file);
  check_refusals();
  CHECK(content(checkpoint.file) == before);
  // A folder in its place is refused, too, but after the options.
  std::filesystem::remove(checkpoint.file);
  std::filesystem::create_directory(checkpoint.file);
  check_refusals();
  CHECK_THAT(error_text<samara::InputError>([&] { flown({.realisations = 2}, checkpoint, told); }),
             Contains("is a folder"));
  // So is a pipe, which nothing would ever be read from.
  std::filesystem::remove(checkpoint.file);
  REQUIRE(::mkfifo(checkpoint.file.c_str(), 0600) == 0);
  CHECK_THAT(error_text<samara::InputError>([&] { flown({.realisations = 2}, checkpoint, told); }),
             Contains("is no regular file"));
}

TEST_CASE("realisations whose checkpoint cannot be written fly all the same, with one warning") {
  const TemporaryDirectory directory;
  std::vector<std::string> told;
  const Ensemble cloud = flown({.realisations = 1536},
                               {.file = directory.path() / "none" / "cloud.checkpoint", .air = "a"}, told);
  CHECK(cloud.realisations() == 1536);
  REQUIRE(told.size() == 1);
  CHECK_THAT(told[0], Contains("no checkpoint: "));
}
