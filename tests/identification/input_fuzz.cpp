// Damaged plans, captures, sidecars, exports and PEtab tables: the calls of `samara build --dry-run` and
// `samara fit` give an answer, or an exception that stands for a documented exit code (3: a file is wrong),
// in less than ten seconds; nothing else.
//
//   input_fuzz COUNT [KIND]            so many of each kind: plan, csv, sidecar, export, petab
//   input_fuzz --write FOLDER COUNT    so many of each kind as files, for the command itself (tests/apps/mutations.py)
//
// Per kind a line of counts, among them of exit codes; the text of what fails.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <glog/logging.h>

#include "files.h"
#include "mutator.h"
#include "samara/base/errors.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/identification/files/fit_files.h"
#include "sound_inputs.h"

namespace {

namespace id = samara::identification;
using samara::codebooks::Codebook;

constexpr const char* kDamagedKinds[] = {"plan", "csv", "sidecar", "export", "petab"};

std::vector<SoundInput> inputs_of(const std::string& kind) {
  std::vector<SoundInput> inputs = sound_inputs();
  std::erase_if(inputs, [&](const SoundInput& input) { return input.kind != kind; });
  return inputs;
}

/// Mutation number `trial` of one of the inputs.
struct Mutation {
  std::size_t input = 0, file = 0;
  std::string text;
};

Mutation mutation_of(const std::vector<SoundInput>& inputs, int trial) {
  Mutation mutation;
  mutation.input = static_cast<std::size_t>(trial) % inputs.size();
  const SoundInput& input = inputs[mutation.input];
  Mutator mutate(static_cast<std::uint64_t>(trial));
  mutation.file = input.mutated[mutate.below(input.mutated.size())];
  mutation.text = mutate(input.files[mutation.file].second);
  return mutation;
}

/// The exit code that the command gives: 0, or 4 for a fit without a result.
int answer(const std::string& kind, const std::filesystem::path& path,
           const std::shared_ptr<const Codebook>& book) {
  if (kind == "plan") {
    samara::codebooks::read_plan(path);
    return 0;
  }
  const id::FitRequest request{.captures = {path}, .book = book};
  id::files_read(request);
  return id::fit_files(request).is_usable ? 0 : 4;
}

/// The exit code, as main() of the command has it. @throws what it would take for an internal failure
int exit_code(const std::string& kind, const std::filesystem::path& path,
              const std::shared_ptr<const Codebook>& book) {
  try {
    return answer(kind, path, book);
  } catch (const samara::OutsideBoxError&) {
    return 5;
  } catch (const samara::NoResultError&) {
    return 4;
  } catch (const samara::InputError&) {
    return 3;
  } catch (const samara::ArgumentError&) {
    return 2;
  }
}

/// 0, or 1 where a mutation does something else than to be answered or refused.
int fuzz(const std::string& kind, int count, const std::shared_ptr<const Codebook>& book) {
  const std::vector<SoundInput> inputs = inputs_of(kind);
  std::map<int, int> codes;
  int failures = 0;
  double slowest = 0.0;
  // Each in a folder of its own, sound but for one file at a time.
  std::vector<TemporaryDirectory> files(inputs.size());
  for (std::size_t k = 0; k < inputs.size(); ++k)
    for (const auto& [name, text] : inputs[k].files) files[k].put(name, text);
  for (int trial = 0; trial < count; ++trial) {
    const Mutation mutation = mutation_of(inputs, trial);
    const auto& [name, sound] = inputs[mutation.input].files[mutation.file];
    const TemporaryDirectory& folder = files[mutation.input];
    folder.put(name, mutation.text);
    const auto begin = std::chrono::steady_clock::now();
    std::string failure;
    try {
      ++codes[exit_code(kind, folder.path() / inputs[mutation.input].opened, book)];
    } catch (const std::exception& error) {
      failure = error.what();
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    folder.put(name, sound);
    slowest = std::max(slowest, seconds);
    if (seconds > 10.0) failure = "took " + std::to_string(seconds) + " s";
    if (failure.empty()) continue;
    if (++failures <= 5)
      std::printf("%s, mutation %d of %s: %s\n%s\n----\n", kind.c_str(), trial, name.c_str(), failure.c_str(),
                  mutation.text.c_str());
  }
  std::printf("%s: %d mutations, %d failures, slowest %.3f s, exit codes", kind.c_str(), count, failures,
              slowest);
  for (const auto& [code, times] : codes) std::printf(" %d: %d", code, times);
  std::printf("\n");
  // Of a reader that takes or refuses everything nothing was tested.
  const bool tells = codes[3] > 0 && codes[3] < count;
  return failures == 0 && tells ? 0 : 1;
}

/// FOLDER/KIND/NUMBER/..; prints kind, exit code and the file that is opened of each.
void write(const std::filesystem::path& folder, int count, const std::shared_ptr<const Codebook>& book) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "source.toml") << sound_source();
  for (const std::string kind : kDamagedKinds) {
    const std::vector<SoundInput> inputs = inputs_of(kind);
    for (int trial = 0; trial < count; ++trial) {
      const Mutation mutation = mutation_of(inputs, trial);
      const SoundInput& input = inputs[mutation.input];
      const std::filesystem::path place = folder / kind / std::to_string(trial);
      std::filesystem::create_directories(place);
      for (std::size_t k = 0; k < input.files.size(); ++k) {
        std::ofstream(place / input.files[k].first, std::ios::binary)
            << (k == mutation.file ? mutation.text : input.files[k].second);
      }
      std::printf("%s %d %s\n", kind.c_str(), exit_code(kind, place / input.opened, book),
                  (place / input.opened).c_str());
    }
  }
}

std::shared_ptr<const Codebook> source() {
  return std::make_shared<const Codebook>(
      samara::codebooks::build(samara::codebooks::parse_plan(sound_source(), "source.toml")).book);
}

}  // namespace

int main(int count, char** arguments) {
  FLAGS_minloglevel = google::GLOG_FATAL;  // as in the command: Ceres would print lines of its own
  const bool writes = count == 4 && std::strcmp(arguments[1], "--write") == 0;
  const int mutations = count > 1 ? std::atoi(arguments[writes ? 3 : 1]) : 0;
  if (mutations < 1 || (count > 3 && !writes)) {
    std::fputs(
        "usage: input_fuzz COUNT [plan|csv|sidecar|export|petab], or input_fuzz --write FOLDER COUNT\n",
        stderr);
    return 2;
  }
  const std::shared_ptr<const Codebook> book = source();
  if (writes) {
    write(arguments[2], mutations, book);
    return 0;
  }
  int failed = 0;
  for (const std::string kind : kDamagedKinds)
    if (count == 2 || kind == arguments[2]) failed += fuzz(kind, mutations, book);
  return failed == 0 ? 0 : 1;
}
