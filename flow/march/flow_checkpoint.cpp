#include "samara/flow/march/flow_checkpoint.h"

#include <algorithm>
#include <string>
#include <system_error>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/version.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/hdf5_writer.h"

namespace samara::flow {

namespace {

constexpr const char* kCheckpointFormat = "samara-flow-checkpoint";

/// visit(name, double, bool, long or vector of doubles) for all that a run holds.
template <class Visitor>
void visit_state(FlowRun& run, const Visitor& visit) {
  FlowState& state = run.march.state();
  visit("time", state.time);
  visit("steps", state.steps);
  visit("last_step", state.last_step);
  for (std::size_t d = 0; d < 3; ++d) {
    visit("u" + std::to_string(d), state.u[d]);
    visit("u_before" + std::to_string(d), state.u_before[d]);
  }
  visit("p", state.p);
  visit("p_change", state.p_change);
  if (KEpsilon* const turbulence = run.march.turbulence()) {
    visit("k", turbulence->k);
    visit("epsilon", turbulence->epsilon);
  }
  run.mean.fields.visit(visit, "average_");
  if (run.older) run.older->fields.visit(visit, "older_");
  visit("averaging", run.averaging);
  visit("change", run.change);
  visit("worst_disagreement", run.worst_disagreement);
  visit("largest_force", run.largest_force);
  visit("unconverged", run.unconverged);
  visit("not_positive", run.not_positive);
}

constexpr std::size_t kPeriodNumbers = 7, kRecordNumbers = 5;

std::vector<double> flat(const std::vector<PeriodMeans>& periods) {
  std::vector<double> values;
  for (const PeriodMeans& p : periods)
    values.insert(values.end(), {p.length, p.drag, p.lift, p.moment, p.drag_squared, p.lift_squared,
                                 p.by_crossing ? 1.0 : 0.0});
  return values;
}

std::vector<double> flat(const std::vector<LoadRecord>& history) {
  std::vector<double> values;
  for (const LoadRecord& r : history) values.insert(values.end(), {r.time, r.step, r.drag, r.lift, r.moment});
  return values;
}

std::vector<PeriodMeans> periods_of(const std::vector<double>& v) {
  std::vector<PeriodMeans> periods;
  for (std::size_t i = 0; i + kPeriodNumbers <= v.size(); i += kPeriodNumbers)
    periods.push_back({v[i], v[i + 1], v[i + 2], v[i + 3], v[i + 4], v[i + 5], v[i + 6] != 0.0});
  return periods;
}

std::vector<LoadRecord> history_of(const std::vector<double>& v) {
  std::vector<LoadRecord> history;
  for (std::size_t i = 0; i + kRecordNumbers <= v.size(); i += kRecordNumbers)
    history.push_back({v[i], v[i + 1], v[i + 2], v[i + 3], v[i + 4]});
  return history;
}

Eigen::Map<const Eigen::VectorXd> as_vector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

std::vector<double> as_numbers(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

}  // namespace

std::string case_text(const FlowCase& flow, const FlowOptions& options) {
  std::string text = fmt::format(
      "samara {} flow, solver {}: {} of {} dimensions, angle {} Re {} I {} turbulence {} domain {} {} {} n "
      "{} central "
      "{} end {} seed {}",
      version(), kRevision, flow.shape.kind, flow.shape.dimensions, flow.angle_of_attack, flow.reynolds,
      flow.intensity, static_cast<int>(flow.turbulence), flow.extent.before, flow.extent.behind,
      flow.extent.side, flow.cells_per_length, flow.central, static_cast<int>(options.end), options.seed);
  for (const double extent : flow.shape.half) text += fmt::format(" {}", extent);
  text += fmt::format(" {}", flow.shape.thickness);
  for (const double size : flow.shape.sizes) text += fmt::format(" {}", size);
  if (flow.motion)
    text += fmt::format("; moving in a stream of {}: {}, period {}", flow.stream, flow.motion->text,
                        flow.motion->period);
  return text;
}

bool is_flow_checkpoint(const std::filesystem::path& file) {
  return io::is_hdf5_with(file, kCheckpointFormat);
}

void save_checkpoint(FlowRun& run, const std::filesystem::path& path) {
  io::Hdf5Writer file(path);
  file.write_text_attribute("/", "format", kCheckpointFormat);
  file.write_text_attribute("/", "case", run.text);
  file.write_number_attribute("/", "has_older", run.older ? 1.0 : 0.0);
  visit_state(run, [&](const std::string& name, auto& value) {
    if constexpr (std::is_arithmetic_v<std::remove_reference_t<decltype(value)>>) {
      file.write_number_attribute("/", name, static_cast<double>(value));
    } else if (!value.empty()) {
      file.write_vector("/" + name, as_vector(value));
    }
  });
  file.write_vector("/counter", as_vector(run.counter.state()));
  file.write_vector("/discarded", as_vector(flat(run.discarded)));
  file.write_vector("/averaged", as_vector(flat(run.mean.periods)));
  if (run.older) file.write_vector("/older", as_vector(flat(run.older->periods)));
  file.write_vector("/history", as_vector(flat(run.history)));
  file.commit();
}

bool load_checkpoint(FlowRun& run, const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return false;
  const io::Hdf5Reader file(path);
  if (!file.has_attribute("/", "format") || file.text_attribute("/", "format") != kCheckpointFormat)
    throw file.error("/", "is no checkpoint of a flow");
  if (file.text_attribute("/", "case") != run.text)
    throw file.error(
        "/", "is a checkpoint of another case, seed or version; expected this one, or --fresh to begin anew");
  if (file.number_attribute("/", "has_older") != 0.0) run.older = run.empty_mean();
  visit_state(run, [&](const std::string& name, auto& value) {
    using Value = std::remove_reference_t<decltype(value)>;
    if constexpr (std::is_arithmetic_v<Value>) {
      value = static_cast<Value>(file.number_attribute("/", name));
    } else if (!value.empty()) {
      value = as_numbers(file.vector("/" + name, {.rows = static_cast<Eigen::Index>(value.size())}));
    }
  });
  run.counter.set_state(as_numbers(file.vector("/counter", {.rows = 11})));
  run.discarded = periods_of(as_numbers(file.vector("/discarded")));
  run.mean.periods = periods_of(as_numbers(file.vector("/averaged")));
  if (run.older) run.older->periods = periods_of(as_numbers(file.vector("/older")));
  run.history = history_of(as_numbers(file.vector("/history")));
  run.march.find_body();
  return true;
}

}  // namespace samara::flow
