#include "flow/flow_output.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/names.h"
#include "samara/base/rounded.h"

namespace samara::apps {

namespace {

bool is_turbulent(const flow::StoredFlow& stored) {
  return std::any_of(stored.fields.begin(), stored.fields.end(),
                     [](const flow::CentreField& field) { return field.name == "epsilon"; });
}

std::string or_unknown(double value) {
  return std::isfinite(value) ? fmt::format("{:.4f}", value) : "unknown";
}

}  // namespace

std::string to_table(const flow::StoredFlow& stored, const std::string& path) {
  const flow::FlowSummary& s = stored.summary;
  const flow::MacGrid& grid = stored.grid;
  std::string text = fmt::format("{}{}\n", path, s.title.empty() ? "" : fmt::format(": {}", s.title));
  text += fmt::format("flow, {}: {}\n", s.status, s.message);
  text +=
      fmt::format("Re {:.4g}, angle of attack {:.4g} rad; {} x {} x {} cells of {:.4g} l, {:.3g} % blocked\n",
                  s.reynolds, s.angle_of_attack, grid.cells[0], grid.cells[1], grid.cells[2], grid.spacing,
                  100.0 * s.checks.blockage);
  // A steady flow is its own mean, which says nothing of the error of its grid.
  const std::string drag = s.status == "steady" ? fmt::format("{:.4g}", s.drag)
                           : s.drag_half_width  ? with_error(s.drag, s.drag_half_width) + " (95 %)"
                                                : with_error(s.drag, s.drag_half_width) + " of unknown error";
  text += fmt::format("C_D {}   C_D' {}\nC_L {:.4f}   C_L' {}   C_M {:.4f}\n", drag, or_unknown(s.drag_rms),
                      s.lift, or_unknown(s.lift_rms), s.moment);
  if (s.moving) {
    text += fmt::format("the body moves; fields are those of t = {:.4g} l/U\n", s.time);
  } else {
    text += fmt::format("Strouhal number {}\nbubble ends {:.3f} l behind the centre\n",
                        or_unknown(s.strouhal), s.bubble_end);
    text += fmt::format("averaged over {:.4g} of {:.4g} l/U\n", s.averaged_time, s.time);
  }
  text += fmt::format("h div u/U {:.1e}, forces by surface and by box differ by {:.1e} of the {}\n",
                      s.checks.divergence, s.checks.force_disagreement, s.moving ? "largest force" : "drag");
  if (!is_turbulent(stored)) return printable(text, "\n");
  text += fmt::format(
      "budget of k open by {:.1e}, {} cells clipped, {} guarded; y+ {:.3g} to {:.3g}, {:.0f} % viscous\n",
      s.checks.energy_defect, s.checks.clipped_cells, s.checks.guarded_cells, s.checks.y_plus_low,
      s.checks.y_plus_high, 100.0 * s.checks.viscous_share);
  text += "k-epsilon is known to give a square cylinder 20 % too little drag and a bubble twice too long\n";
  return printable(text, "\n");
}

Json to_json(const flow::StoredFlow& stored) {
  const flow::FlowSummary& s = stored.summary;
  Json object = {{"schema", "samara-flow-info/1"},
                 {"title", s.title},
                 {"status", s.status},
                 {"message", s.message},
                 {"reynolds", s.reynolds},
                 {"angle_of_attack", s.angle_of_attack},
                 {"moving", s.moving},
                 {"cells", stored.grid.cells},
                 {"spacing", stored.grid.spacing},
                 {"C_D", s.drag},
                 {"C_D_half_width", s.drag_half_width ? Json(*s.drag_half_width) : Json(nullptr)},
                 {"C_D_rms", s.drag_rms},
                 {"C_L", s.lift},
                 {"C_L_rms", s.lift_rms},
                 {"C_M", s.moment},
                 {"strouhal", s.strouhal},
                 {"bubble_end", s.bubble_end},
                 {"averaged_time", s.averaged_time},
                 {"time", s.time}};
  object["checks"] = {
      {"divergence", s.checks.divergence},       {"force_disagreement", s.checks.force_disagreement},
      {"unconverged", s.checks.unconverged},     {"energy_defect", s.checks.energy_defect},
      {"clipped_cells", s.checks.clipped_cells}, {"guarded_cells", s.checks.guarded_cells},
      {"production", s.checks.production},       {"y_plus", {s.checks.y_plus_low, s.checks.y_plus_high}},
      {"viscous_share", s.checks.viscous_share}, {"blockage", s.checks.blockage}};
  object["fields"] = Json::array();
  for (const flow::CentreField& field : stored.fields)
    object["fields"].push_back({{"name", field.name}, {"unit", field.unit}});
  object["provenance"] = {{"generator", s.generator}, {"plan", s.plan}};
  return object;
}

}  // namespace samara::apps
