#include "samara/codebooks/source/checkpoint.h"

#include <algorithm>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/base/errors.h"
#include "samara/codebooks/source/list_edits.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using samara::InputError;

namespace fs = std::filesystem;

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
