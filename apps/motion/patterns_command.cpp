#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <set>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "inputs/assignments.h"
#include "inputs/capture_inputs.h"
#include "motion/motion_answers.h"
#include "motion/pattern_points.h"
#include "motion/sweep_patterns.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/base/text.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/io/atomic_file.h"
#include "samara/motion/pages/pattern_page.h"
#include "samara/motion/patterns/labelled_segments.h"
#include "samara/motion/patterns/transitions.h"
#include "samara/motion/sweeps/sweep_file.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

std::vector<identification::Capture> captures_of(const PatternsArguments& arguments) {
  std::vector<identification::Capture> all;
  const std::vector<std::filesystem::path> files(arguments.inputs.begin(), arguments.inputs.end());
  identification::check_sidecar(arguments.sidecar, files, false);
  for (const std::filesystem::path& file : files)
    std::ranges::move(identification::read_captures(file, arguments.sidecar), std::back_inserter(all));
  if (all.empty()) throw InputError(arguments.inputs.front(), "has no captures, expected at least one");
  return all;
}

std::string transitions_text(const motion::Transitions& all) {
  std::string text;
  for (Eigen::Index i = 0; i < all.counts.rows(); ++i) {
    for (Eigen::Index j = 0; j < all.counts.cols(); ++j) {
      if (!std::isfinite(all.probability(i, j))) continue;
      text += fmt::format("  {:<14} to {:<14} {:>6}  {:.2f} ({:.2f} to {:.2f}, 95 %)",
                          motion::pattern_names()[static_cast<std::size_t>(i)],
                          motion::pattern_names()[static_cast<std::size_t>(j)], all.counts(i, j),
                          all.probability(i, j), all.lower(i, j), all.upper(i, j));
      if (std::isfinite(all.changes(i, j)))
        text += fmt::format(", there after {:.1f} changes", all.changes(i, j));
      text += "\n";
    }
  }
  return text.empty() ? "no fall changes its pattern\n" : "changes of pattern\n" + text;
}

Json transitions_json(const motion::Transitions& all) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < all.counts.rows(); ++i) {
    for (Eigen::Index j = 0; j < all.counts.cols(); ++j) {
      if (!std::isfinite(all.probability(i, j))) continue;
      list.push_back({{"from", motion::pattern_names()[static_cast<std::size_t>(i)]},
                      {"to", motion::pattern_names()[static_cast<std::size_t>(j)]},
                      {"count", all.counts(i, j)},
                      {"probability", all.probability(i, j)},
                      {"interval", {all.lower(i, j), all.upper(i, j)}},
                      {"changes", number_or_null(all.changes(i, j))}});
    }
  }
  return list;
}

std::string capture_text(const motion::LabelledMotion& capture) {
  std::string text = capture.id;
  if (capture.record.left_out > 0) text += fmt::format(" ({} frames not seen)", capture.record.left_out);
  text += "\n";
  for (const motion::LabelledWindow& window : capture.windows) {
    text += fmt::format("  {:8.3f} to {:8.3f} s  {:<12}  margin {:.2f}  {}\n", window.from, window.to,
                        to_string(window.label.pattern), window.label.margin, window.label.why);
  }
  return text;
}

Json capture_json(const motion::LabelledMotion& capture) {
  Json windows = Json::array();
  for (const motion::LabelledWindow& window : capture.windows) {
    windows.push_back({{"from", window.from},
                       {"to", window.to},
                       {"pattern", to_string(window.label.pattern)},
                       {"windows", window.windows},
                       {"margin", number_or_null(window.label.margin)},
                       {"why", window.label.why}});
  }
  return {{"id", capture.id},
          {"left_out", capture.record.left_out},
          {"attitude", capture.record.has_attitude()},
          {"windows", windows}};
}

motion::PatternThresholds thresholds_of(const PatternsArguments& arguments) {
  motion::PatternThresholds thresholds;
  std::set<std::string> given;
  for (const std::string& text : arguments.thresholds) {
    const Setting one = setting_of("--threshold", text);
    if (!given.insert(one.name).second)
      throw ArgumentError(fmt::format("--threshold: \"{}\" is set twice", one.name));
    const double value = number_or_quantity("--threshold: " + one.name, one.text, "1");
    try {
      set_threshold(thresholds, one.name, value);
    } catch (const ArgumentError& error) {
      throw ArgumentError(fmt::format("--threshold: {}", error.what()));
    }
  }
  return thresholds;
}

/// What the call says of the body that falls.
struct CaptureBody {
  double length = 0.0;  ///< m, 0: not known
  std::optional<motion::FallNumbers> numbers;
};

CaptureBody body_of_captures(const PatternsArguments& arguments) {
  CaptureBody body;
  if (arguments.body.empty() && !arguments.set.empty())
    throw ArgumentError("--set is of the body: --body was expected");
  if (!arguments.body.empty()) {
    const models::ParametricModel model = body_of(arguments.body, arguments.set);
    body.numbers = motion::fall_numbers(model.model(), model.parameters({}));
    body.length = body.numbers->length;
  }
  if (!arguments.length.empty()) body.length = positive_quantity("--length", arguments.length, "m");
  return body;
}

int patterns_of_captures(const PatternsArguments& arguments) {
  const motion::PatternThresholds thresholds = thresholds_of(arguments);
  const CaptureBody body = body_of_captures(arguments);
  const double length = body.length;
  const std::vector<identification::Capture> captures = captures_of(arguments);
  std::vector<std::vector<motion::Pattern>> sequences;
  std::vector<motion::LabelledMotion> motions;
  Json object = {{"schema", "samara-patterns/1"},
                 {"thresholds", thresholds_json(thresholds)},
                 {"captures", Json::array()}};
  std::string text;
  for (const identification::Capture& capture : captures) {
    const motion::MotionRecord record = motion::record_of(capture, length);
    try {
      motions.push_back({capture.id, record, motion::label_windows(record, {}, thresholds)});
    } catch (const ArgumentError& error) {
      identification::refuse(capture.file, fmt::format("capture \"{}\": {}", capture.id, error.what()));
    }
    sequences.emplace_back();
    for (const motion::LabelledWindow& window : motions.back().windows)
      sequences.back().push_back(window.label.pattern);
    text += capture_text(motions.back());
    object["captures"].push_back(capture_json(motions.back()));
  }
  const motion::Transitions changes = motion::transitions(sequences);
  text += transitions_text(changes);
  object["transitions"] = transitions_json(changes);
  if (!arguments.labels.empty()) {
    const motion::PatternClasses classes = motion::pattern_classes(arguments.classes);
    const auto segments = motion::read_labelled_segments(arguments.labels, classes);
    const motion::SegmentAgreement both = motion::compare(segments, captures, classes, length, thresholds);
    text += fmt::format(
        "beside {} labels of {} (rows) the rule (columns): agreement {:.3f}, balanced {:.3f}, kappa "
        "{:.3f}, adjusted Rand index {:.3f}\n{}",
        segments.size(), arguments.labels, both.agreement.share, both.agreement.balanced,
        both.agreement.kappa, both.agreement.adjusted_rand,
        confusion_table(both.agreement.confusion, both.words, both.words));
    object["labels"] = to_json(both.agreement);
    object["labels"]["words"] = both.words;
  } else if (!arguments.classes.empty()) {
    throw ArgumentError("--class says what words of --labels mean: --labels was expected");
  }
  text += thresholds_text(thresholds);
  if (!arguments.report.empty())
    io::write_text_atomically(arguments.report, motion::pattern_html(motions, thresholds, body.numbers));
  write_answer(arguments.output, arguments.json ? json_line(object) : text);
  return kDone;
}

int run_patterns(const PatternsArguments& arguments) {
  if (arguments.clusters && (*arguments.clusters < 1 || *arguments.clusters > 100))
    throw ArgumentError(fmt::format("--clusters is {}, expected 1 to 100", *arguments.clusters));
  // What is called a sweep is read as one, so that a damaged one is refused for what it is.
  const auto is_sweep = [](const std::filesystem::path& path) {
    return ending_of(path) == ".h5" || motion::is_sweep(path);
  };
  const auto sweep = std::ranges::find_if(arguments.inputs, is_sweep);
  if (sweep != arguments.inputs.end() && arguments.inputs.size() > 1)
    throw ArgumentError(fmt::format("\"{}\" is a sweep, which was expected alone", *sweep));
  if (!arguments.output.empty() || !arguments.report.empty()) {
    std::vector<std::string> inputs = sweep != arguments.inputs.end()
                                          ? arguments.inputs
                                          : files_of_captures(arguments.inputs, arguments.sidecar);
    inputs.insert(inputs.end(), {arguments.labels, arguments.body});
    std::erase(inputs, "");
    const char* ending = arguments.json ? ".json" : asks_for_points(arguments) ? ".csv" : ".txt";
    if (!arguments.output.empty()) check_text_output(arguments.output, inputs, ending);
    if (!arguments.report.empty()) check_output(arguments.report, inputs);
    check_outputs_differ({{"--output", arguments.output}, {"--report", arguments.report}});
    check_ending("--report", arguments.report, ".html");
  }
  check_point_words(arguments);
  if (sweep != arguments.inputs.end()) return patterns_of_sweep(arguments);
  if (asks_for_points(arguments))
    throw ArgumentError("--draw and --clamp ask the map of a sweep, and the inputs are captures");
  if (arguments.clusters) throw ArgumentError("--clusters is of sweeps, and the inputs are captures");
  return patterns_of_captures(arguments);
}

}  // namespace

void add_patterns(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<PatternsArguments>();
  CLI::App* command = app.add_subcommand(
      "patterns",
      "of a sweep: counts, map, clusters, landing; of captures: labels window by window, transitions");
  command->add_option("INPUTS", values->inputs, "one sweep (HDF5), or captures: tables, sidecars")
      ->required();
  command->add_option("--clusters", values->clusters, "of a sweep, beside the rule, 4");
  command->add_option("--sidecar", values->sidecar, "of every table; default: those beside them");
  command->add_option("--length", values->length, "of the body, m or with a unit: \"7 cm\"");
  command->add_option(
      "--body", values->body,
      "model of the body of captures: its length, and its place in the diagram of the report");
  command
      ->add_option("--set", values->set,
                   "of the body, or of the point to clamp: NAME=VALUE, SI or with a unit; may be repeated")
      ->allow_extra_args(false);
  command
      ->add_option("--threshold", values->thresholds,
                   "of captures: NAME=VALUE, a threshold of the rule; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--report", values->report,
                      "page for the browser to write: diagram, map, features, chain");
  command->add_option("--labels", values->labels,
                      "a person's labels: a table with capture, first_frame, last_frame, label");
  command
      ->add_option("--class", values->classes,
                   "what a word of the labels means, WORD=PATTERN+PATTERN; may be repeated. Default: names "
                   "of patterns")
      ->allow_extra_args(false);
  command->add_option("--draw", values->draw,
                      "of a sweep: points of the box that lead to this PATTERN, as a table");
  command->add_option("--count", values->count, "of draws, 1");
  command->add_option("--seed", values->seed, "of draws, 1");
  command->add_option("--clamp", values->clamp,
                      "of a sweep: the point of --set, moved to where it leads to this PATTERN");
  command->add_option("--release", values->release, "of the sweep that --draw and --clamp are of, from 0");
  command->add_option("-o,--output", values->output, kAnswerFile);
  command->add_flag("--json", values->json, kJson);
  on_call(*command, arguments, values, run_patterns);
}

}  // namespace samara::apps
