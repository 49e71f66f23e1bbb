#include "samara/codebooks/source/checkpoint.h"

#include <cmath>
#include <stdexcept>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "same_codebook.h"
#include "sample_books.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using samara::InputError;

namespace {

namespace fs = std::filesystem;

/// The kill of a build, as an exception through the progress callback: nothing is tidied up.
struct Killed : std::runtime_error {
  Killed() : std::runtime_error("killed") {}
};

BuildOptions options_with(const fs::path& checkpoint) {
  BuildOptions options;
  options.certificate_points = 100;
  options.checkpoint = checkpoint;
  return options;
}

Plan coin() {
  Plan plan = parse_plan(coin_plan(), "coin.toml");
  plan.builder.strategy = "slabs";
  return plan;
}

/// Builds until the given number of reports, and a report more.
/// @returns the stage in which it was killed; empty if the build ended before
std::string build_and_kill(const fs::path& checkpoint, int reports, bool resume = false) {
  BuildOptions options = options_with(checkpoint);
  options.resume = resume;
  std::string stage;
  options.progress = [&](const samara::Progress& report) -> bool {
    if (--reports >= 0) return true;
    stage = report.stage;
    throw Killed();
  };
  try {
    build(coin(), options);
    return "";
  } catch (const Killed&) {
    return stage;
  }
}

/// Builds until a new checkpoint is there.
/// @returns false if the build ended before, done
bool build_a_round(const fs::path& path, bool resume) {
  BuildOptions options = options_with(path);
  options.resume = resume;
  const std::string before = fs::exists(path) ? content(path) : "";
  options.progress = [&](const samara::Progress&) -> bool {
    if (fs::exists(path) && content(path) != before) throw Killed();
    return true;
  };
  try {
    build(coin(), options);
    return false;
  } catch (const Killed&) {
    return true;
  }
}

void leave_checkpoint(const fs::path& path) {
  REQUIRE(build_a_round(path, false));
  REQUIRE(fs::exists(path));
}

BuildResult resumed(const fs::path& checkpoint) {
  BuildOptions options = options_with(checkpoint);
  options.resume = true;
  return build(coin(), options);
}

const BuildResult& undisturbed() {
  static const BuildResult result = build(coin(), options_with({}));
  return result;
}

void check_equals_undisturbed(const BuildResult& result) {
  check_same_but_provenance(result.book, undisturbed().book);
  CHECK(result.met == undisturbed().met);
  CHECK(result.message == undisturbed().message);
}

}  // namespace

TEST_CASE("a build killed at any moment and resumed equals an undisturbed one to the last bit") {
  const TemporaryDirectory directory;
  const fs::path checkpoint = directory / "book.h5.checkpoint";
  // Before every slab, and when the certificate begins.
  std::string stage;
  int kills = 0;
  int with_checkpoint = 0;
  while (stage != "certificate") {
    stage = build_and_kill(checkpoint, kills);
    REQUIRE(stage != "");
    ++kills;
    if (fs::exists(checkpoint)) ++with_checkpoint;
    INFO("killed at report " << kills << ", in " << stage);
    check_equals_undisturbed(resumed(checkpoint));
    CHECK(directory.file_count() == 0);
  }
  CHECK(kills > 5);
  CHECK(with_checkpoint > 2);
}

TEST_CASE("a build killed after each of its checkpoints still ends, and as if undisturbed") {
  const TemporaryDirectory directory;
  const fs::path checkpoint = directory / "checkpoint";
  int kills = 0;
  while (build_a_round(checkpoint, true)) {
    // What is left is enough to end from.
    fs::copy_file(checkpoint, directory / "copy");
    check_equals_undisturbed(resumed(directory / "copy"));
    ++kills;
    REQUIRE(kills < 200);
  }
  CHECK(kills >= 1);
  CHECK(directory.file_count() == 0);
}

TEST_CASE("a checkpoint changes nothing, and is gone when the build is done") {
  const TemporaryDirectory directory;
  const BuildResult result = build(coin(), options_with(directory / "checkpoint"));
  check_equals_undisturbed(result);
  CHECK(directory.file_count() == 0);
}

TEST_CASE("resuming without a checkpoint begins at the beginning") {
  const TemporaryDirectory directory;
  check_equals_undisturbed(resumed(directory / "checkpoint"));
  check_equals_undisturbed(resumed({}));
}

TEST_CASE("a checkpoint that is not asked for is not taken up, but replaced and removed") {
  const TemporaryDirectory directory;
  put_content(directory / "checkpoint", "something else");
  check_equals_undisturbed(build(coin(), options_with(directory / "checkpoint")));
  CHECK(directory.file_count() == 0);
}

TEST_CASE("a build that is cancelled leaves its checkpoint, and can be resumed") {
  for (const std::string stage : {"slab 3", "certificate"}) {
    const TemporaryDirectory directory;
    const fs::path checkpoint = directory / "checkpoint";
    BuildOptions options = options_with(checkpoint);
    options.progress = [&](const samara::Progress& report) {
      return !(fs::exists(checkpoint) && report.stage == stage);
    };
    CHECK_FALSE(build(coin(), options).met);
    INFO(stage);
    CHECK(fs::exists(checkpoint));
    check_equals_undisturbed(resumed(checkpoint));
    CHECK(directory.file_count() == 0);
  }
}

TEST_CASE("a checkpoint of another plan is refused and left alone") {
  const TemporaryDirectory directory;
  const fs::path checkpoint = directory / "checkpoint";
  leave_checkpoint(checkpoint);
  const std::string before = content(checkpoint);
  BuildOptions options = options_with(checkpoint);
  options.resume = true;
  for (const std::string& other : {coin_plan() + "# a remark\n", coin_plan() + "seed = 2\n"}) {
    CHECK_THAT(error_text<InputError>([&] { build(parse_plan(other, "other.toml"), options); }),
               Contains(checkpoint.string() + ": /plan: the checkpoint belongs to another plan"));
  }
  CHECK(content(checkpoint) == before);
}

TEST_CASE("a checkpoint that is broken, cut or something else is refused") {
  const TemporaryDirectory directory;
  const fs::path checkpoint = directory / "checkpoint";
  leave_checkpoint(checkpoint);
  const std::string whole = content(checkpoint);
  const auto refusal = [&] { return error_text<InputError>([&] { resumed(checkpoint); }); };
  for (const double part : {0.0, 0.3, 0.9, 0.999}) {
    put_content(checkpoint,
                whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size()))));
    CHECK_THAT(refusal(), Contains("checkpoint: "));
  }
  put_content(checkpoint, coin_plan());
  CHECK_THAT(refusal(), Contains("is not an HDF5 file"));
  save(four_pieces(), checkpoint);
  CHECK_THAT(refusal(), Contains("this is no checkpoint"));
  // And a checkpoint is no codebook.
  put_content(checkpoint, whole);
  CHECK_THAT(error_text<InputError>([&] { load(checkpoint); }), Contains("this is not a codebook"));
}

TEST_CASE("a checkpoint whose march is none of the plan is refused, and what to do is said") {
  const TemporaryDirectory directory;
  const fs::path path = directory / "checkpoint";
  leave_checkpoint(path);
  const std::vector<double> good = load_march(path, coin().text);
  REQUIRE(good.size() > 100);
  const auto refusal = [&](const auto& damage) {
    std::vector<double> state = good;
    damage(state);
    save_march(path, coin().text, state);
    return error_text<InputError>([&] { resumed(path); });
  };
  CHECK_THAT(refusal([](auto& s) { s.resize(s.size() / 2); }),
             Contains("--fresh begins anew, and removes it"));
  CHECK_THAT(refusal([](auto& s) { s[1] += 1.0; }), Contains("belongs to another problem or other options"));
  CHECK_THAT(refusal([](auto& s) { s.push_back(0.0); }), Contains("longer than its march"));
}

TEST_CASE("the state of a march survives a checkpoint to the last bit") {
  const TemporaryDirectory directory;
  const fs::path path = directory / "checkpoint";
  const std::vector<double> state = {1.0 / 3.0, 5e-324, -0.0, 1e308, 12'345'678'901.0};
  const std::string plan = "# " + std::string(100000, 'x') + "\nmodel = \"caf\xC3\xA9\"\n";
  save_march(path, plan, state);
  CHECK(load_march(path, plan) == state);
  CHECK(directory.file_count() == 1);
}
