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
  plan.builder.strategy = "newton";
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
  // In every iteration of the solver, and when the certificate begins.
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

TEST_CASE("a build killed after each of its rounds still ends, and as if undisturbed") {
  const TemporaryDirectory directory;
  const fs::path checkpoint = directory / "checkpoint";
  int kills = 0;
  while (build_a_round(checkpoint, true)) {
    // What is left is enough to end from.
    fs::copy_file(checkpoint, directory / "copy");
    check_equals_undisturbed(resumed(directory / "copy"));
    ++kills;
    REQUIRE(kills < 20);
  }
  CHECK(kills == undisturbed().book.build().rounds - 1);
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
  for (const std::string stage : {"Newton", "certificate"}) {
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

TEST_CASE("a checkpoint with numbers that cannot be is refused, each by its name") {
  const TemporaryDirectory directory;
  const fs::path path = directory / "checkpoint";
  leave_checkpoint(path);
  const samara::pgd::SolverState good = load_checkpoint(path, coin().text);
  const auto refusal = [&](const auto& damage) {
    samara::pgd::SolverState state = good;
    damage(state);
    save_checkpoint(path, coin().text, state);
    return error_text<InputError>([&] { resumed(path); });
  };
  using State = samara::pgd::SolverState;
  const double nan = std::nan("");
  CHECK_THAT(refusal([](State& s) { s.nodes[0] = -3; }), Contains("/: nodes has the number -3"));
  CHECK_THAT(refusal([](State& s) { s.nodes[0] = 1999999999; }), Contains("/: nodes has the number"));
  CHECK_THAT(refusal([](State& s) { s.nodes[0] = 131; }), Contains("do not fit the plan"));
  CHECK_THAT(refusal([](State& s) { s.nodes.pop_back(); }),
             Contains("/piece: has 3 axes and 2 outputs, expected 2"));
  CHECK_THAT(refusal([](State& s) { s.scales.push_back(1.0); }),
             Contains("/piece: has 3 axes and 2 outputs"));
  CHECK_THAT(refusal([&](State& s) { s.scales[0] = nan; }), Contains("/: scales has the number nan"));
  CHECK_THAT(refusal([&](State& s) { s.coarseness = nan; }), Contains("/: coarseness is nan"));
  CHECK_THAT(refusal([](State& s) { s.round = -1; }), Contains("/: round is -1"));
  CHECK_THAT(refusal([](State& s) { s.round = 500; }), Contains("do not fit the plan"));
  CHECK_THAT(refusal([](State& s) { s.time_elements = 0; }), Contains("/: time_elements is 0"));
  CHECK_THAT(refusal([](State& s) { s.rhs_evaluations = -1; }), Contains("/: rhs_evaluations is -1"));
  CHECK_THAT(refusal([](State& s) { s.field.reset(); }), Contains("/piece: is missing"));
}

TEST_CASE("the solver's state survives a checkpoint to the last bit") {
  const TemporaryDirectory directory;
  const fs::path path = directory / "checkpoint";
  samara::pgd::SolverState state;
  state.round = 0;
  state.time_elements = 11;
  state.scales = {1.0 / 3.0, 5e-324};
  state.coarseness = 1.0 / 7.0;
  state.rhs_evaluations = 12'345'678'901;
  state.jacobian_evaluations = 9'876'543'210;
  state.iterations = 17;
  const auto same = [&](const samara::pgd::SolverState& back) {
    CHECK(back.round == state.round);
    CHECK(back.time_elements == state.time_elements);
    CHECK(back.nodes == state.nodes);
    CHECK(back.scales == state.scales);
    CHECK(back.coarseness == state.coarseness);
    CHECK(back.rhs_evaluations == state.rhs_evaluations);
    CHECK(back.jacobian_evaluations == state.jacobian_evaluations);
    CHECK(back.iterations == state.iterations);
    REQUIRE(back.field.has_value() == state.field.has_value());
    if (back.field) check_same_field(*back.field, *state.field);
  };
  const samara::pgd::SeparatedField field = *four_pieces().pieces()[1].groups()[0].sum();
  state.nodes = {7, 129};
  state.nodes.resize(static_cast<std::size_t>(field.axis_count()) - 1, 9);
  state.scales.resize(static_cast<std::size_t>(field.output_count()), 0.25);
  const std::string plan = "# " + std::string(100000, 'x') + "\nmodel = \"caf\xC3\xA9\"\n";
  save_checkpoint(path, plan, state);
  same(load_checkpoint(path, plan));
  state.round = 3;
  state.field = field;
  save_checkpoint(path, plan, state);
  same(load_checkpoint(path, plan));
  CHECK(directory.file_count() == 1);
}
