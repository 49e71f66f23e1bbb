#include "samara/codebooks/source/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/source/list_edits.h"
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

TEST_CASE("to begin anew removes damaged checkpoints and empty files, and no other") {
  const TemporaryDirectory directory;
  const fs::path file = directory / "book.checkpoint";
  CHECK_NOTHROW(remove_checkpoint(file));
  Checkpoint(file, "plan").save_march({1.0});
  fs::resize_file(file, 40);
  remove_checkpoint(file);
  put_content(file, "");
  remove_checkpoint(file);
  CHECK_FALSE(fs::exists(file));
  put_content(file, "t,z\n0,1\n");
  CHECK_THAT(error_text<InputError>([&] { remove_checkpoint(file); }),
             Contains("this is no checkpoint of a build"));
  CHECK_THAT(
      error_text<InputError>([&] {
        remove_checkpoint(file, {"a dance", [](const fs::path&) { return false; }});
      }),
      Contains("this is no checkpoint of a dance, and would be lost: move it, or choose another name"));
  CHECK(content(file) == "t,z\n0,1\n");
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

TEST_CASE("the state of a march survives a checkpoint to the last bit") {
  const TemporaryDirectory directory;
  const fs::path path = directory / "checkpoint";
  const std::vector<double> state = {1.0 / 3.0, 5e-324, -0.0, 1e308, 12'345'678'901.0};
  const std::string plan = "# " + std::string(100000, 'x') + "\nmodel = \"caf\xC3\xA9\"\n";
  Checkpoint(path, plan).save_march(state);
  CHECK(Checkpoint(path, plan).march() == state);
  CHECK(directory.file_count() == 1);
}

namespace {

/// What grows as the state of a march: fields of slabs that are done, told by their number; records of them; and
/// what every slab changes.
std::vector<double> state_after(int slabs, std::mt19937_64& random, std::vector<double>& fields,
                                std::vector<double>& records) {
  std::normal_distribution<double> normal;
  const auto add = [&](std::vector<double>& list, int count) {
    for (int i = 0; i < count; ++i) list.push_back(normal(random));
  };
  if (slabs > 0) {
    add(fields, 2000);
    add(records, 10);
  }
  std::vector<double> state = {static_cast<double>(slabs)};
  state.insert(state.end(), fields.begin(), fields.end());
  state.push_back(static_cast<double>(slabs));
  add(state, 300);
  state.insert(state.end(), records.begin(), records.end());
  add(state, 20);
  return state;
}

}  // namespace

TEST_CASE("a checkpoint that cannot be kept is told once, whatever is wrong with its file") {
  int told = 0;
  const auto save = told_once<int>([](const int&) { throw samara::InputError("c", "is damaged"); },
                                   [&](const std::string& text) {
                                     ++told;
                                     CHECK_THAT(text, Contains("no checkpoint: c: is damaged"));
                                   });
  CHECK_NOTHROW(save(1));
  CHECK_NOTHROW(save(2));
  CHECK(told == 1);
}

TEST_CASE("a checkpoint costs what is new, however much is done before") {
  const TemporaryDirectory directory;
  const fs::path path = directory / "checkpoint";
  Checkpoint checkpoint(path, "plan");
  std::mt19937_64 random(8);
  std::vector<double> fields, records;
  std::uintmax_t before = 0, largest = 0, all = 0;
  int written_anew = 0;
  constexpr int kSlabs = 60;
  for (int slab = 0; slab <= kSlabs; ++slab) {
    const std::vector<double> state = state_after(slab, random, fields, records);
    checkpoint.save_march(state);
    const std::uintmax_t now = fs::file_size(path);
    if (slab % 20 == 0) REQUIRE(Checkpoint(path, "plan").march() == state);
    if (now <= before) {
      ++written_anew;
      all += now;
    } else {
      all += now - before;
      if (slab > 0) largest = std::max(largest, now - before);
    }
    before = now;
  }
  // 2330 numbers are new, and a few say what is not.
  CHECK(largest < 8 * 2500);
  CHECK(written_anew == 0);
  // The whole of it, time after time, would be 30 times that.
  CHECK(all < 8 * 2500 * (kSlabs + 1));
}

TEST_CASE("a checkpoint of changes alone is written anew before it is much longer than what it holds") {
  const TemporaryDirectory directory;
  const fs::path path = directory / "checkpoint";
  Checkpoint checkpoint(path, "plan");
  std::mt19937_64 random(9);
  std::vector<double> state(20000);
  std::uintmax_t before = 0;
  int times_anew = 0;
  constexpr int kTimes = 45;
  for (int k = 0; k < kTimes; ++k) {
    for (std::size_t i = 0; i < 2000; ++i) state[i] = static_cast<double>(random());
    checkpoint.save_march(state);
    const std::uintmax_t now = fs::file_size(path);
    CHECK(now < 5 * 8 * state.size());
    times_anew += now <= before ? 1 : 0;
    before = now;
  }
  CHECK(Checkpoint(path, "plan").march() == state);
  CHECK(times_anew == 1);  // a tenth is new each time, and the file holds four times the whole, and some
}

TEST_CASE("calls are added to a checkpoint, and cost no more the more there are") {
  const TemporaryDirectory directory;
  const fs::path path = directory / "checkpoint";
  Checkpoint checkpoint(path, "plan");
  std::vector<CallSheet> calls = {{{}, {}, {}, 0.0}, {{0.0, 0.1}, {}, {}, 0.0}};
  std::uintmax_t before = 0;
  for (int k = 0; k < 30; ++k) {
    CallSheet& sheet = calls[static_cast<std::size_t>(k % 2)];
    for (int i = 0; i < 30; ++i) sheet.points.push_back(0.1 * i + k);
    for (int i = 0; i < 50; ++i) sheet.values.push_back(0.3 * i - k);
    sheet.seconds += 0.1;
    checkpoint.save_calls(calls);
    const std::uintmax_t now = fs::file_size(path);
    if (k > 0) CHECK(now - before < 1000);
    before = now;
  }
  const std::vector<CallSheet> loaded = Checkpoint(path, "plan").calls();
  REQUIRE(loaded.size() == 2);
  for (std::size_t s = 0; s < 2; ++s) {
    CHECK(loaded[s].points == calls[s].points);
    CHECK(loaded[s].values == calls[s].values);
    CHECK(loaded[s].seconds == calls[s].seconds);
  }
}

TEST_CASE("edits of a list make the other of it, whatever has moved, gone or come") {
  std::mt19937_64 random(10);
  for (int k = 0; k < 200; ++k) {
    std::vector<double> before(random() % 2000);
    for (double& number : before) number = static_cast<double>(random() % 4);  // much that is alike
    std::vector<double> now;
    while (now.size() < 1500) {
      const std::size_t from = before.empty() ? 0 : random() % before.size();
      const std::size_t count = std::min<std::size_t>(random() % 400, before.size() - from);
      const auto first = before.begin() + static_cast<std::ptrdiff_t>(from);
      now.insert(now.end(), first, first + static_cast<std::ptrdiff_t>(count));
      now.push_back(static_cast<double>(random() % 3));
    }
    EditedList list;
    list.apply(edits_between({}, before));
    REQUIRE(list.numbers() == before);
    list.apply(edits_between(before, now));
    REQUIRE(list.numbers() == now);
  }
  EditedList list;
  list.apply({{0, 0, {1.0, 2.0}}});
  CHECK_THROWS_AS(list.apply({{1, 2, {}}}), samara::ArgumentError);
}
