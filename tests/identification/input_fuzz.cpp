// Mutated captures, sidecars, exports and PEtab tables: each is read, or refused with an InputError, in less than ten
// seconds; nothing else. (The command gives the exit code 3 for an InputError.)
//
//   input_fuzz COUNT [KIND]   so many mutations of each kind: csv, sidecar, export, petab
//
// The text of a mutation that fails is printed; so are, at the end, how many were read.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <string>
#include <vector>

#include "files.h"
#include "samara/base/streams.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/petab/petab_problem.h"

namespace {

namespace id = samara::identification;

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : stream_(1, seed) {}

  std::string operator()(std::string text) {
    for (std::size_t change = 1 + below(3); change > 0; --change) text = once(std::move(text));
    return text;
  }

  std::size_t below(std::size_t count) {
    return count == 0 ? 0 : static_cast<std::size_t>(stream_.bits() % count);
  }

 private:
  std::string once(std::string text) {
    static const std::vector<std::string> words = {"nan",
                                                   "inf",
                                                   "-1",
                                                   "0",
                                                   "1e308",
                                                   "1e999",
                                                   "1,5",
                                                   "1.5.2",
                                                   "\"",
                                                   "'",
                                                   "[",
                                                   "]",
                                                   "{",
                                                   "}",
                                                   "=",
                                                   "#",
                                                   ";",
                                                   ",",
                                                   "\t",
                                                   "\n",
                                                   "\n\n",
                                                   "\r\n",
                                                   ":",
                                                   "- ",
                                                   "/",
                                                   "..",
                                                   "*",
                                                   "px",
                                                   "m",
                                                   "deg",
                                                   "furlong",
                                                   "t",
                                                   "x",
                                                   "\\",
                                                   "\xff",
                                                   "é",
                                                   "0:00:00:00",
                                                   "true",
                                                   "=\"\"",
                                                   std::string(1, '\0'),
                                                   std::string(300, '9'),
                                                   "[[",
                                                   "a.b"};
    const std::size_t at = below(text.size() + 1);
    switch (below(9)) {
      case 0:
        return text.substr(0, at);
      case 1:
        if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
        return text;
      case 2:
        return text.insert(at, words[below(words.size())]);
      case 3:
        return text.erase(at, 1 + below(12));
      case 4:
        return replace_token(text, at, words[below(words.size())]);
      case 5:
        return replace_token(text, at, token(text, below(text.size() + 1)));
      case 6:
        return with_lines(text, [&](std::vector<std::string>& lines) {
          lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(below(lines.size())));
        });
      case 7:
        return with_lines(text, [&](std::vector<std::string>& lines) {
          const std::string line = lines[below(lines.size())];
          lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(below(lines.size() + 1)), line);
        });
      default:
        return with_lines(text, [&](std::vector<std::string>& lines) {
          std::swap(lines[below(lines.size())], lines[below(lines.size())]);
        });
    }
  }

  static bool is_separator(char c) { return std::string(" \t\n,;=[]\":{}").find(c) != std::string::npos; }

  static std::pair<std::size_t, std::size_t> token_at(const std::string& text, std::size_t at) {
    std::size_t begin = std::min(at, text.size()), end = begin;
    while (begin > 0 && !is_separator(text[begin - 1])) --begin;
    while (end < text.size() && !is_separator(text[end])) ++end;
    return {begin, end - begin};
  }
  static std::string token(const std::string& text, std::size_t at) {
    const auto [begin, size] = token_at(text, at);
    return text.substr(begin, size);
  }
  static std::string replace_token(std::string text, std::size_t at, const std::string& other) {
    const auto [begin, size] = token_at(text, at);
    return text.replace(begin, size, other);
  }

  template <class Change>
  static std::string with_lines(const std::string& text, const Change& change) {
    std::vector<std::string> lines;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
      lines.push_back(text.substr(begin, end - begin));
      begin = end;
    }
    if (!lines.empty()) change(lines);
    std::string joined;
    for (const std::string& line : lines) joined += line;
    return joined;
  }

  samara::Stream stream_;
};

/// Files of an input that is sound, of which one is mutated at a time.
struct Input {
  std::string kind;
  std::vector<std::pair<std::string, std::string>> files;  ///< name, text
  std::vector<std::size_t> mutated;                        ///< which of them
  std::string opened;                                      ///< the file that is read
};

std::vector<Input> sound_inputs() {
  const std::string rows = "0,0,1.5\n0.1,0.02,1.4\n0.2,0.05,1.3\n0.3,0.09,\n0.4,0.15,1.1\n0.5,0.2,1\n";
  const std::string table = "# body: coin\nt[s],x[cm],theta[deg]\n" + rows;
  const std::string sidecar =
      "file = \"cells.csv\"\ngroup_by = [\"drop\"]\nframe_rate = \"60 Hz\"\nfrom = \"0 s\"\nleast_frames = "
      "3\nflip = [\"x\"]\n"
      "where = { drop = [\"1\", \"2\"] }\ndelimiter = \";\"\ndecimal = \",\"\n[columns]\nframe = { quantity "
      "= \"t\", unit = "
      "\"frame\" }\ny_px = { quantity = \"x\", unit = \"px\" }\n[scale]\nx = { length = \"38 cm\", over = "
      "\"largest - first\" "
      "}\n[clean]\noutliers = 5\nlongest_gap = \"0.2 s\"\n[labels]\nfile = \"labels.csv\"\ncolumn = "
      "\"drop\"\n";
  std::string cells = "drop;frame;y_px\n";
  for (int k = 0; k < 20; ++k)
    cells += std::to_string(1 + k / 10) + ";" + std::to_string(k % 10) + ";" +
             std::to_string(10 + k * k % 37) + ",5\n";
  const std::string motive =
      "Format Version,1.23,Take Name,fall,Capture Frame Rate,120,Rotation Type,Quaternion,Length "
      "Units,Meters\n\n"
      ",Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\n"
      ",Name,card,card,card,card,card,card,card\n,ID,1,1,1,1,1,1,1\n"
      ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position\n"
      "Frame,Time "
      "(Seconds),X,Y,Z,W,X,Y,Z\n0,0,0,0,0,1,0.1,1.5,0.2\n1,0.01,0,0,0.1,0.995,0.1,1.4,0.2\n2,0.02,0,0,0.2,0."
      "98,0.1,"
      "1.3,0.2\n3,0.03,,,,,,,\n";
  const std::string units = "length_unit = \"cm\"\ntime_unit = \"ms\"\n";
  const std::string condition = "conditionId\tv\nslow\t2\nfast\tv_fast\n";
  std::string measured = "observableId\tsimulationConditionId\tmeasurement\ttime\tnoiseParameters\n";
  for (int k = 1; k < 8; ++k)
    for (const char* name : {"slow", "fast"})
      measured += std::string("speed\t") + name + "\t" + std::to_string(5 - 0.5 * k) + "\t" +
                  std::to_string(0.1 * k) + "\t0.01\n";
  return {
      {"csv", {{"drop.csv", table}}, {0}, "drop.csv"},
      {"csv",
       {{"cells.csv", cells}, {"cells.toml", sidecar}, {"labels.csv", "drop,spin\n1,20\n2,30\n"}},
       {0, 2},
       "cells.toml"},
      {"sidecar",
       {{"cells.toml", sidecar}, {"cells.csv", cells}, {"labels.csv", "drop,spin\n1,20\n2,30\n"}},
       {0},
       "cells.toml"},
      {"sidecar",
       {{"pose.toml",
         "file = \"pose.csv\"\nup = \"-z\"\n[columns]\nt = { quantity = \"t\", unit = \"s\" }\np1 = { "
         "quantity = \"x\", unit = \"m\" "
         "}\np2 = { quantity = \"y\", unit = \"m\" }\np3 = { quantity = \"z\", unit = \"m\" "
         "}\n[attitude]\neuler = [\"a\", \"b\", "
         "\"c\"]\norder = \"zyx\"\nunit = \"deg\"\n"},
        {"pose.csv", "t,p1,p2,p3,a,b,c\n0,1,2,3,4,5,6\n1,1,2,4,4,6,6\n2,1,3,4,4,7,6\n3,1,3,4,9,7,6\n"}},
       {0},
       "pose.toml"},
      {"export",
       {{"ball.txt", "Ball 1;;\nt;x;y\n0,0;1,5;-2,5E-1\n0,1;2,5;0\n0,2;3,5;0\n0,3;4,5;1\n"},
        {"ball.toml", units}},
       {0},
       "ball.txt"},
      {"export",
       {{"kinovea.csv",
         "\"Time\";\"b/0/X\";\"b/0/"
         "Y\"\n\"0\";\"1,5\";\"10\"\n\"40\";\"2,5\";\"9,5\"\n\"80\";\"3,5\";\"9\"\n"},
        {"kinovea.toml", units}},
       {0},
       "kinovea.csv"},
      {"export",
       {{"tracks.txt",
         "#Kinovea Trajectory data export\n#T X Y\n\n# ball\n0 866.00 320.00\n20 847,5 321.00\n40 830 "
         "322\n\n# arm\n0 1 2\n20 3 4\n40 5 6\n"},
        {"tracks.toml", units}},
       {0},
       "tracks.txt"},
      {"export", {{"card.csv", motive}}, {0}, "card.csv"},
      {"petab",
       {{"problem.yaml",
         "format_version: 1\nparameter_file: parameters.tsv\nproblems:\n- condition_files: "
         "[conditions.tsv]\n  measurement_files:\n  - "
         "measurements.tsv\n  observable_files:\n  - observables.tsv\n  sbml_files: []\n"},
        {"parameters.tsv",
         "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\tobjectivePriorType\tob"
         "jectivePriorParameters\n"
         "rate\tlog10\t0.1\t5\t1\t1\tnormal\t1.2;0.3\nv_fast\tlin\t0.5\t9\t3\t0\t\t\n"},
        {"observables.tsv",
         "observableId\tobservableFormula\tnoiseFormula\nspeed\tv\tnoiseParameter1_speed\n"},
        {"conditions.tsv", condition},
        {"measurements.tsv", measured}},
       {0, 1, 2, 3, 4},
       "problem.yaml"},
  };
}

const id::ConfigNames& decay_names() {
  static const id::ConfigNames names = {{{"rate", "s^-1"}, {"v(0)", "m s^-1"}}, {{"v", "m s^-1"}}};
  return names;
}

/// Reads an input; whether it was read. @throws InputError where it is refused
bool read_input(const Input& input, const TestFiles& files) {
  const std::filesystem::path path = files.path() / input.opened;
  if (input.kind != "petab") {
    id::read_captures(path);
    return true;
  }
  const id::PetabProblem problem = id::read_petab(path, decay_names());
  // What it says is a config; one that holds everything says so later.
  id::parse_fit_config(problem.config, "the config", decay_names());
  return true;
}

/// 0, or 1 where a mutation does something else than to be read or refused.
int fuzz(const std::string& kind, int count) {
  std::vector<Input> inputs = sound_inputs();
  std::erase_if(inputs, [&](const Input& input) { return input.kind != kind; });
  int read = 0, failures = 0;
  double slowest = 0.0;
  std::vector<TestFiles> files(
      inputs.size());  // each in a folder of its own, sound but for one file at a time
  for (std::size_t k = 0; k < inputs.size(); ++k)
    for (const auto& [name, text] : inputs[k].files) files[k].put(name, text);
  for (int trial = 0; trial < count; ++trial) {
    const std::size_t place = static_cast<std::size_t>(trial) % inputs.size();
    const Input& input = inputs[place];
    Mutator mutate(static_cast<std::uint64_t>(trial));
    const auto& [name, sound] = input.files[input.mutated[mutate.below(input.mutated.size())]];
    const std::string other = mutate(sound);
    files[place].put(name, other);
    const auto begin = std::chrono::steady_clock::now();
    std::string failure;
    try {
      read += read_input(input, files[place]) ? 1 : 0;
    } catch (const samara::InputError&) {
    } catch (const std::exception& error) {
      failure = error.what();
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    files[place].put(name, sound);
    slowest = std::max(slowest, seconds);
    if (seconds > 10.0) failure = "took " + std::to_string(seconds) + " s";
    if (failure.empty()) continue;
    if (++failures <= 5)
      std::printf("%s, mutation %d of %s: %s\n%s\n----\n", kind.c_str(), trial, name.c_str(), failure.c_str(),
                  other.c_str());
  }
  std::printf("%s: %d mutations, %d read, %d failures, slowest %.3f s\n", kind.c_str(), count, read, failures,
              slowest);
  return failures == 0 && read > 0 && read < count ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) {
  const int mutations = count > 1 ? std::atoi(arguments[1]) : 0;
  if (mutations < 1 || count > 3) {
    std::fputs("usage: input_fuzz COUNT [csv|sidecar|export|petab]\n", stderr);
    return 2;
  }
  int failed = 0;
  for (const std::string kind : {"csv", "sidecar", "export", "petab"})
    if (count == 2 || kind == arguments[2]) failed += fuzz(kind, mutations);
  return failed == 0 ? 0 : 1;
}
