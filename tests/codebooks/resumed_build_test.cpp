#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/source/checkpoint.h"
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
  const fs::path checkpoint = directory / "checkpoint";
  Checkpoint(checkpoint, "another plan").save_march({1.0});
  check_equals_undisturbed(build(coin(), options_with(checkpoint)));
  CHECK(directory.file_count() == 0);
  put_content(checkpoint, "");
  check_equals_undisturbed(build(coin(), options_with(checkpoint)));
  CHECK(directory.file_count() == 0);
}

TEST_CASE("a file that is no checkpoint is neither replaced nor removed by a build") {
  const TemporaryDirectory directory;
  const fs::path capture = directory / "capture.csv";
  const Plan field = parse_plan(
      "model = \"heat_rod\"\n[fixed]\ncapacity = 3.6e6\nlength = 0.2\n[box]\nconductivity = [15, 60]\n"
      "[time]\nend = 600\n",
      "field.toml");
  for (const Plan& plan : {coin(), field}) {
    put_content(capture, "t,z\n0,1\n");
    CHECK_THAT(error_text<InputError>([&] { build(plan, options_with(capture)); }),
               Contains("capture.csv: this is no checkpoint"));
    CHECK(content(capture) == "t,z\n0,1\n");
  }
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
  for (const std::string line : {"# a remark", "seed = 2"}) {
    const std::string other = coin_plan() + line + "\n";
    CHECK_THAT(error_text<InputError>([&] { build(parse_plan(other, "other.toml"), options); }),
               Contains(checkpoint.string() + ": the checkpoint belongs to another plan") &&
                   Contains("where this one has \"" + line + "\""));
  }
  // An empty line more, or no break of the last one.
  const std::string whole = coin_plan();
  REQUIRE(whole.ends_with("\n"));
  for (const std::string& other : {whole + "\n", whole.substr(0, whole.size() - 1)}) {
    CHECK_THAT(error_text<InputError>([&] { build(parse_plan(other, "other.toml"), options); }),
               Contains("they differ in line breaks at the end"));
  }
  CHECK(content(checkpoint) == before);
}

TEST_CASE("a checkpoint whose plan is damaged says so, and not that it is of another") {
  const TemporaryDirectory directory;
  const fs::path checkpoint = directory / "checkpoint";
  leave_checkpoint(checkpoint);
  std::string bytes = content(checkpoint);
  const std::size_t place = bytes.find("[box]");
  REQUIRE(place != std::string::npos);
  bytes[place] = '(';
  put_content(checkpoint, bytes);
  CHECK_THAT(
      error_text<InputError>([&] { resumed(checkpoint); }),
      Contains(checkpoint.string() + ": the checkpoint is damaged: it does not say of which plan it is") &&
          Contains("--fresh begins anew"));
  CHECK(content(checkpoint) == bytes);
}

TEST_CASE("a checkpoint that is cut anywhere is gone on from, or refused where it does not name its plan") {
  const TemporaryDirectory directory;
  const fs::path checkpoint = directory / "checkpoint";
  leave_checkpoint(checkpoint);
  REQUIRE(build_a_round(checkpoint, true));
  const std::string whole = content(checkpoint);
  const auto part = [&](double share) {
    return whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size())));
  };
  for (const double share : {0.5, 0.9, 0.999}) {
    put_content(checkpoint, part(share));
    check_equals_undisturbed(resumed(checkpoint));
  }
  // A kill, or a disk that was full, may leave anything after the last whole record.
  put_content(checkpoint, whole + std::string(1000, '\0'));
  check_equals_undisturbed(resumed(checkpoint));
  const auto refusal = [&] { return error_text<InputError>([&] { resumed(checkpoint); }); };
  for (const std::string& other : {std::string(), whole.substr(0, 30)}) {
    put_content(checkpoint, other);
    CHECK_THAT(refusal(), Contains("checkpoint: this is no checkpoint; --fresh begins anew"));
  }
  for (const std::string& other : {part(1e-3), coin_plan()}) {
    put_content(checkpoint, other);
    CHECK_THAT(refusal(),
               Contains("checkpoint: this is no checkpoint of a build or a cloud, and would be lost"));
  }
  save(four_pieces(), checkpoint);
  CHECK_THAT(refusal(), Contains("this is no checkpoint"));
  // And a checkpoint is no codebook.
  put_content(checkpoint, whole);
  CHECK_THAT(error_text<InputError>([&] { load(checkpoint); }), Contains("is not an HDF5 file"));
}

TEST_CASE("a checkpoint whose march is none of the plan is refused, and what to do is said") {
  const TemporaryDirectory directory;
  const fs::path path = directory / "checkpoint";
  leave_checkpoint(path);
  const std::vector<double> good = Checkpoint(path, coin().text).march();
  REQUIRE(good.size() > 100);
  const auto refusal = [&](const auto& damage) {
    std::vector<double> state = good;
    damage(state);
    Checkpoint(path, coin().text).save_march(state);
    return error_text<InputError>([&] { resumed(path); });
  };
  CHECK_THAT(refusal([](auto& s) { s.resize(s.size() / 2); }),
             Contains("--fresh begins anew, and removes it"));
  CHECK_THAT(refusal([](auto& s) { s[1] += 1.0; }), Contains("belongs to another problem or other options"));
  CHECK_THAT(refusal([](auto& s) { s.push_back(0.0); }), Contains("longer than its march"));
}
