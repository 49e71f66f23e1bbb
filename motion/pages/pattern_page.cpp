#include "samara/motion/pages/pattern_page.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "page_parts.h"
#include "samara/base/errors.h"
#include "samara/identification/pages/html_page.h"
#include "samara/motion/patterns/transitions.h"
#include "samara/motion/records/even_frames.h"
#include "samara/motion/sweeps/pattern_map.h"
#include "samara/motion/sweeps/phase_diagram.h"
#include "samara/motion/sweeps/sweep_plan.h"

namespace samara::motion {

namespace {

using Data = nlohmann::ordered_json;

/// Below, a place of the map is drawn pale.
constexpr double kSure = 0.7;
/// Of a grid with more points, slices are drawn from the nearest falls, as of drawn points: each cell asks all points.
constexpr Eigen::Index kMostCells = 40'000;
/// Places along each side of such a slice, and coordinates whose slices there are.
constexpr int kRaster = 32;
constexpr Eigen::Index kMostAxes = 6;

/// Six digits are more than a picture shows; null where it is not known.
Data short_number(double value) {
  return std::isfinite(value) ? Data(std::stod(fmt::format("{:.6g}", value))) : Data();
}

template <class Values>
Data short_numbers(const Values& values) {
  Data list = Data::array();
  for (const double value : values) list.push_back(short_number(value));
  return list;
}

/// A letter for a pattern, large where the map is sure of it.
char letter(Pattern pattern, double probability) {
  const auto code = static_cast<char>('a' + static_cast<int>(pattern));
  return probability < kSure ? code : static_cast<char>(std::toupper(code));
}

Data thresholds_data(const PatternThresholds& thresholds) {
  Data object;
  for (const NamedThreshold& one : named_thresholds()) object[one.name] = thresholds.*one.value;
  return object;
}

Data body_data(const FallNumbers& numbers) {
  const RegimeAnswer answer = regime(numbers.Re, numbers.I_disc);
  return {{"Re", numbers.Re},
          {"I_disc", numbers.I_disc},
          {"I_plate", numbers.I_plate},
          {"I_ellipse", numbers.I_ellipse},
          {"regime", to_string(answer.regime)},
          {"beyond", to_string(answer.beyond)},
          {"distance", answer.distance},
          {"measured", answer.measured}};
}

Data diagram_data() {
  Data lines = Data::array();
  for (const RegimeBoundary& line : drawn_regime_boundaries())
    lines.push_back({{"name", line.name},
                     {"Re", short_numbers(line.points.col(0))},
                     {"I_disc", short_numbers(line.points.col(1))}});
  return {{"boundaries", lines},
          {"Re", {kMeasuredDiscs.least_Re, kMeasuredDiscs.most_Re}},
          {"I_disc", {kMeasuredDiscs.least_I, kMeasuredDiscs.most_I}},
          {"bodies", Data::array()},
          {"missing", ""}};
}

Data chain_data(const std::vector<std::vector<Pattern>>& sequences) {
  const Transitions all = transitions(sequences);
  Data object = {{"falls", all.falls}, {"steps", Data::array()}};
  for (Eigen::Index i = 0; i < all.counts.rows(); ++i) {
    for (Eigen::Index j = 0; j < all.counts.cols(); ++j) {
      if (!std::isfinite(all.probability(i, j))) continue;
      object["steps"].push_back({{"from", i},
                                 {"to", j},
                                 {"count", all.counts(i, j)},
                                 {"probability", all.probability(i, j)},
                                 {"interval", {all.lower(i, j), all.upper(i, j)}}});
    }
  }
  return object;
}

Data features_data() {
  Data list = Data::array();
  for (const FeatureInfo& info : feature_infos())
    list.push_back(
        {{"name", info.name}, {"unit", info.unit}, {"meaning", info.meaning}, {"values", Data::array()}});
  return list;
}

/// Falls for the scatter: what each is called, from which release, its features.
struct ShownFalls {
  Data features = features_data(), patterns = Data::array(), groups = Data::array();

  void add(const Features& features_of, Pattern pattern, Eigen::Index group) {
    for (std::size_t f = 0; f < kFeatures; ++f)
      features[f]["values"].push_back(short_number(features_of.values[f]));
    patterns.push_back(static_cast<int>(pattern));
    groups.push_back(group);
  }
  Data data(Eigen::Index of) const {
    return {{"of", of}, {"patterns", patterns}, {"groups", groups}, {"features", features}};
  }
};

Data page_data(const std::string& kind, const PatternThresholds& thresholds) {
  return {{"schema", "samara-patterns-page/1"},
          {"kind", kind},
          {"patterns", pattern_names()},
          {"sure", kSure},
          {"thresholds", thresholds_data(thresholds)},
          {"diagram", diagram_data()}};
}

std::string release_name(const Sweep& sweep, Eigen::Index release) {
  if (sweep.releases.empty()) return "its own";
  const Release& one = sweep.releases[static_cast<std::size_t>(release)];
  constexpr double kDegree = std::numbers::pi / 180.0;
  return fmt::format("{:.4g} deg about {:.4g} deg", one.tilt / kDegree, one.axis / kDegree);
}

bool has_cells(const Sweep& sweep) {
  Eigen::Index cells = sweep.axes.empty() ? 0 : 1;
  for (const auto& axis : sweep.axes) cells *= static_cast<Eigen::Index>(axis.size());
  return cells > 0 && cells <= kMostCells && cells * sweep.release_count() == sweep.fall_count();
}

/// The map at every point of a grid, the last axis fastest.
std::string cells_text(const Sweep& sweep, const PatternMap& map) {
  std::string text;
  for (Eigen::Index n = 0; n < map.size(); ++n) {
    const MapAnswer answer = map.at(sweep.points.row(n));
    text += letter(answer.pattern, answer.probability);
  }
  return text;
}

/// Slices through the middle of the box by two coordinates each (or the one that there is), row after row.
Data rasters_data(const Sweep& sweep, const PatternMap& map) {
  Data list = Data::array();
  const Eigen::VectorXd middle = 0.5 * (sweep.lower + sweep.upper);
  const Eigen::VectorXd cell = (sweep.upper - sweep.lower) / kRaster;
  const Eigen::Index axes = std::min(kMostAxes, middle.size());
  const auto slice = [&](Eigen::Index x, Eigen::Index y) {
    std::string text;
    for (int row = 0; row < (y < 0 ? 1 : kRaster); ++row) {
      for (int column = 0; column < kRaster; ++column) {
        Eigen::VectorXd point = middle;
        point[x] = sweep.lower[x] + (column + 0.5) * cell[x];
        if (y >= 0) point[y] = sweep.lower[y] + (row + 0.5) * cell[y];
        const MapAnswer answer = map.at(point);
        text += letter(answer.pattern, answer.probability);
      }
    }
    list.push_back({{"x", x}, {"y", y}, {"map", text}});
  };
  if (axes == 1) slice(0, -1);
  for (Eigen::Index x = 0; x < axes; ++x) {
    for (Eigen::Index y = x + 1; y < axes; ++y) slice(x, y);
  }
  return list;
}

Data box_data(const Sweep& sweep) {
  Data box = {{"names", sweep.names},
              {"units", sweep.units},
              {"lower", short_numbers(sweep.lower)},
              {"upper", short_numbers(sweep.upper)},
              {"raster", kRaster},
              {"axes", Data()},
              {"releases", Data::array()}};
  const bool cells = has_cells(sweep);
  if (cells) {
    for (const auto& axis : sweep.axes) box["axes"].push_back(short_numbers(axis));
  }
  const bool is_mapped = sweep.fall_count() / sweep.release_count() > PatternMap::kNeighbours;
  for (Eigen::Index r = 0; r < sweep.release_count(); ++r) {
    Data release = {{"name", release_name(sweep, r)}, {"counts", sweep.counts(r)}};
    if (is_mapped) {
      const PatternMap map(sweep, r);
      release["left_one_out"] = map.left_one_out();
      if (cells) {
        release["cells"] = cells_text(sweep, map);
      } else {
        release["slices"] = rasters_data(sweep, map);
      }
    }
    box["releases"].push_back(release);
  }
  return box;
}

Data placed_data(const Sweep& sweep) {
  Data diagram = diagram_data();
  const PlacedBodies placed = placed_bodies(sweep, kMostShownBodies);
  diagram["missing"] = placed.missing;
  for (std::size_t k = 0; k < placed.bodies.size(); ++k) {
    Data body = body_data(placed.bodies[k]);
    body["falls"] = placed.falls[k];
    body["shares"] = short_numbers(placed.shares.row(static_cast<Eigen::Index>(k)));
    diagram["bodies"].push_back(body);
  }
  return diagram;
}

std::string html_of(const std::string& title, const std::string& summary, const Data& data) {
  return identification::html_text(
      {.title = title,
       .summary = summary,
       .markup = "<main id=\"report\"></main>\n",
       .data = {{"patterns", data.dump(-1, ' ', false, Data::error_handler_t::replace)}},
       .styles = {page::kPatternsStyle},
       .scripts = {page::kPatternsMarks, page::kPatternsMap, page::kPatternsPage}});
}

/// "12 zigzag, 3 chaotic"
std::string counts_text(const std::vector<int>& counts) {
  std::string text;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counts[k], pattern_names()[k]);
  }
  return text;
}

/// None where no trajectories were kept, or the model of the plan is not there any more.
Data kept_chain(const Sweep& sweep) {
  try {
    return sweep.trajectories.empty() ? Data() : chain_data(kept_sequences(sweep));
  } catch (const InputError&) {
    return {};
  }
}

/// The frames of a window, as a motion that has settled.
Features window_features(const MotionRecord& record, const LabelledWindow& window) {
  const double* const begin = record.times.data();
  const double* const end = begin + record.times.size();
  const Eigen::Index first = std::lower_bound(begin, end, window.from) - begin;
  const Eigen::Index count = std::upper_bound(begin, end, window.to) - begin - first;
  if (count < kFewestFrames) return {};
  const MotionRecord piece = part(record, first, count);
  if (!long_gap(piece.times).empty()) return {};
  return features(piece, {.settle_share = 0.0});
}

}  // namespace

std::vector<std::vector<Pattern>> kept_sequences(const Sweep& sweep) {
  std::vector<std::vector<Pattern>> sequences;
  if (sweep.trajectories.empty()) return sequences;
  const SweepPlan plan = parse_sweep_plan(sweep.plan_text, "the plan of the sweep");
  const MotionStates states(plan.model->info());
  const models::ParametricModel model = plan.parametric_model();
  const auto size = static_cast<std::size_t>(sweep.trajectories.front().cols());
  for (std::size_t n = 0; n < sweep.trajectories.size(); ++n) {
    const auto& kept = sweep.trajectories[n];
    RecordBuilder builder(states, static_cast<std::size_t>(kept.rows()));
    std::vector<double> state(size);
    for (Eigen::Index k = 0; k < kept.rows() && kept.row(k).allFinite(); ++k) {
      Eigen::Map<Eigen::RowVectorXd>(state.data(), kept.cols()) = kept.row(k);
      builder.add(sweep.times[k], state);
    }
    if (static_cast<Eigen::Index>(builder.count()) < kFewestFrames) continue;
    const Eigen::Index fall = static_cast<Eigen::Index>(n);
    const Eigen::VectorXd q =
        plan.lane_points(sweep.points.row(sweep.point_of(fall))).row(sweep.release_of(fall));
    const auto parameters = model.parameters({q.data(), static_cast<std::size_t>(q.size())});
    const MotionRecord record = builder.record(MotionStates::body_length(*plan.model, parameters));
    sequences.emplace_back();
    for (const LabelledWindow& window : label_windows(record, {}, sweep.thresholds))
      sequences.back().push_back(window.label.pattern);
  }
  return sequences;
}

std::string pattern_html(const Sweep& sweep) {
  Data data = page_data("sweep", sweep.thresholds);
  data["model"] = sweep.model;
  data["diagram"] = placed_data(sweep);
  data["box"] = box_data(sweep);
  ShownFalls shown;
  for (const Eigen::Index n : drawn_numbers(sweep.fall_count(), kMostShownFalls)) {
    const auto k = static_cast<std::size_t>(n);
    shown.add(sweep.features[k], sweep.labels[k].pattern, sweep.release_of(n));
  }
  data["falls"] = shown.data(sweep.fall_count());
  data["chain"] = kept_chain(sweep);
  const std::string summary = fmt::format("{} falls: {}", sweep.fall_count(), counts_text(sweep.counts()));
  data["summary"] = summary;
  return html_of(fmt::format("Patterns of {}", sweep.model), summary, data);
}

std::string pattern_html(const std::vector<LabelledMotion>& motions, const PatternThresholds& thresholds,
                         const std::optional<FallNumbers>& body) {
  Data data = page_data("captures", thresholds);
  if (body) {
    data["diagram"]["bodies"].push_back(body_data(*body));
  } else {
    data["diagram"]["missing"] = "the call does not say which body falls";
  }
  ShownFalls shown;
  std::vector<std::vector<Pattern>> sequences;
  std::vector<int> counts(kPatterns, 0);
  data["captures"] = Data::array();
  for (std::size_t n = 0; n < motions.size(); ++n) {
    const LabelledMotion& motion = motions[n];
    Data windows = Data::array();
    sequences.emplace_back();
    for (const LabelledWindow& window : motion.windows) {
      windows.push_back({{"from", window.from},
                         {"to", window.to},
                         {"pattern", static_cast<int>(window.label.pattern)},
                         {"margin", short_number(window.label.margin)},
                         {"why", window.label.why}});
      shown.add(window_features(motion.record, window), window.label.pattern, static_cast<Eigen::Index>(n));
      sequences.back().push_back(window.label.pattern);
      ++counts[static_cast<std::size_t>(window.label.pattern)];
    }
    data["captures"].push_back(
        {{"id", motion.id}, {"left_out", motion.record.left_out}, {"windows", windows}});
  }
  data["falls"] = shown.data(static_cast<Eigen::Index>(shown.patterns.size()));
  data["chain"] = chain_data(sequences);
  const std::string summary = fmt::format("{} capture{}, windows: {}", motions.size(),
                                          motions.size() == 1 ? "" : "s", counts_text(counts));
  data["summary"] = summary;
  return html_of("Patterns of captures", summary, data);
}

}  // namespace samara::motion
