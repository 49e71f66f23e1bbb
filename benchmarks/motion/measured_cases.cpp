// Measured discs and drops, which the project may not contain: they are found where SAMARA_DATA leads.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>

#include <fmt/format.h>
#include <unistd.h>

#include "motion/cases.h"
#include "motion/decision_tree.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/io/delimited_table.h"
#include "samara/motion/patterns/disc_phase_diagram.h"
#include "samara/motion/patterns/labelled_segments.h"

namespace samara::benchmarks::motion_cases {

namespace {

using motion::Feature;

std::filesystem::path measured(const Options& options, const std::string& test_case, const std::string& set) {
  if (!options.wants(test_case)) return {};
  const char* const root = std::getenv("SAMARA_DATA");
  if (root != nullptr && std::filesystem::is_directory(std::filesystem::path(root) / set))
    return std::filesystem::path(root) / set;
  std::cerr << test_case << " skipped: SAMARA_DATA does not lead to \"" << set << "\"\n";
  return {};
}

void run_field(const Options& options) {
  constexpr const char* kName = "field1997";
  const auto folder = measured(options, kName, "disk-phase-diagram-field1997");
  if (folder.empty()) return;
  const auto table = io::DelimitedTable::read(folder / "points.csv");
  const auto series = table.texts("series");
  const Eigen::VectorXd Re = table.numbers("re"), I = table.numbers("istar"), code = table.numbers("code");
  std::vector<int> truth, answer;
  for (std::size_t k = 0; k < table.rows(); ++k) {
    if (series[k].starts_with("l")) continue;  // lines
    const auto n = static_cast<Eigen::Index>(k);
    truth.push_back(static_cast<int>(code[n]) - 1);
    answer.push_back(static_cast<int>(motion::regime(Re[n], I[n]).regime));
  }
  const motion::Agreement both = motion::agreement(truth, answer, 4);
  std::cerr << kName << ": rows measured, columns by the lines (steady periodic chaotic tumbling)\n"
            << both.confusion << '\n';
  print({kMotion, kName, "agreement", both.share, "1"});
}

std::vector<identification::Capture> drops(const std::filesystem::path& folder) {
  const auto sidecar =
      std::filesystem::temp_directory_path() / fmt::format("samara-drops-{}.toml", ::getpid());
  std::ofstream(sidecar) << R"(group_by = ["traj"]
start = "as given"
[columns]
t_s = { quantity = "t", unit = "s" }
x_m = { quantity = "x", unit = "m" }
y_m = { quantity = "y", unit = "m" }
z_m = { quantity = "z", unit = "m" }
)";
  std::vector<identification::Capture> all;
  for (const char* shape : {"circle", "square", "hexagon", "cross"}) {
    for (identification::Capture& one :
         identification::read_captures(folder / fmt::format("{}.csv", shape), sidecar))
      all.push_back(std::move(one));
  }
  std::filesystem::remove(sidecar);
  return all;
}

/// Twice the radius, by drop.
std::map<std::string, double> diameters(const std::filesystem::path& folder) {
  const auto table = io::DelimitedTable::read(folder / "index.csv");
  const auto names = table.texts("traj");
  const Eigen::VectorXd radii = table.numbers("radius_m");
  std::map<std::string, double> all;
  for (std::size_t k = 0; k < names.size(); ++k) all[names[k]] = 2.0 * radii[static_cast<Eigen::Index>(k)];
  return all;
}

/// A person's word on each segment, the source's own k-means, the rule, and features for a tree.
struct Segments {
  std::vector<int> person, source, rule;
  Eigen::MatrixXd features;
};

const std::vector<Feature> kTreeFeatures = {Feature::excursion,    Feature::sway,   Feature::drift,
                                            Feature::straightness, Feature::veers,  Feature::turns,
                                            Feature::winding,      Feature::wobble, Feature::e,
                                            Feature::recurrence};

void report(const std::string& who, const std::vector<int>& person, const std::vector<int>& answer) {
  const motion::Agreement both = motion::agreement(person, answer, 4);
  std::cerr
      << fmt::format(
             "cambridge, {}: agreement {:.3f}, balanced {:.3f}, kappa {:.3f}; rows the person (tumbling, "
             "chaotic, steady or periodic)\n",
             who, both.share, both.balanced, both.kappa)
      << both.confusion << '\n';
}

/// 0 tumbling, 1 chaotic, 2 steady or periodic, 3 none of these.
int class_of(motion::Pattern pattern) {
  switch (pattern) {
    case motion::Pattern::autorotation:
      return 0;
    case motion::Pattern::chaotic:
    case motion::Pattern::mixed:
      return 1;
    case motion::Pattern::unresolved:
      return 3;
    default:
      return 2;
  }
}

void run_cambridge(const Options& options) {
  constexpr const char* kName = "cambridge";
  const auto folder = measured(options, kName, "falling-paper-cambridge");
  if (folder.empty()) return;
  const auto captures = drops(folder);
  const auto lengths = diameters(folder);
  const auto classes =
      motion::pattern_classes({"1=autorotation", "2=chaotic+mixed", "3=steady+zigzag+spiral+helix"});
  const auto segments = motion::read_labelled_segments(folder / "human_labels.csv", classes);
  const Eigen::VectorXd automatic =
      io::DelimitedTable::read(folder / "human_labels.csv").numbers("source_auto");
  Segments circles, others;
  for (std::size_t n = 0; n < segments.size(); ++n) {
    Segments& to = segments[n].capture.starts_with("circle") ? circles : others;
    const double length = lengths.at(segments[n].capture);
    const bool is_long = segments[n].frame_count() >= motion::kFewestFrames;
    const motion::Features f =
        is_long ? motion::features(record_of(segments[n], captures, length), {.settle_share = 0.0})
                : motion::Features();
    to.person.push_back(std::stoi(segments[n].label) - 1);
    to.source.push_back(static_cast<int>(automatic[static_cast<Eigen::Index>(n)]) - 1);
    to.rule.push_back(class_of(label(f).pattern));
    to.features.conservativeResize(to.features.rows() + 1, static_cast<Eigen::Index>(kTreeFeatures.size()));
    for (std::size_t k = 0; k < kTreeFeatures.size(); ++k) {
      // Without swings nothing comes back.
      const double value = f.knows(kTreeFeatures[k]) ? f[kTreeFeatures[k]] : 1.0;
      to.features(to.features.rows() - 1, static_cast<Eigen::Index>(k)) = value;
    }
  }
  const DecisionTree tree(circles.features, circles.person, 3);
  std::vector<int> answers;
  for (const auto& row : others.features.rowwise()) answers.push_back(tree(row));
  std::vector<std::string> names;
  for (const Feature feature : kTreeFeatures)
    names.push_back(motion::feature_infos()[static_cast<std::size_t>(feature)].name);
  std::cerr << fmt::format("{}: tree set on {} circles:{}\n", kName, circles.person.size(), tree.text(names));
  report("the tree on the other shapes", others.person, answers);
  report("the rule on the other shapes", others.person, others.rule);
  report("the source's k-means on the other shapes", others.person, others.source);
  const motion::Agreement both = motion::agreement(others.person, answers, 4);
  print({kMotion, kName, "agreement", both.share, "1"});
  print({kMotion, kName, "kappa", both.kappa, "1"});
  print({kMotion, kName, "kappa_rule", motion::agreement(others.person, others.rule, 4).kappa, "1"});
  print({kMotion, kName, "kappa_source", motion::agreement(others.person, others.source, 4).kappa, "1"});
}

}  // namespace

void run_measured(const Options& options) {
  run_field(options);
  run_cambridge(options);
}

}  // namespace samara::benchmarks::motion_cases
