#include "samara/motion/pages/motion_page.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "page_parts.h"
#include "samara/identification/pages/html_page.h"
#include "samara/motion/planning/motion_view.h"
#include "samara/motion/records/motion_record.h"

namespace samara::motion {

namespace {

using MotionData = nlohmann::ordered_json;

/// Six digits are more than a picture shows; null where it is no number.
MotionData shown_number(double value) {
  return std::isfinite(value) ? MotionData(std::stod(fmt::format("{:.6g}", value))) : MotionData();
}

template <class Values>
MotionData shown_list(const Values& values) {
  MotionData list = MotionData::array();
  for (const double value : values) list.push_back(shown_number(value));
  return list;
}

MotionData known(double value) {
  return std::isfinite(value) ? MotionData(value) : MotionData();
}

template <class Name>
MotionData name_or_null(const std::optional<Name>& name) {
  return name ? MotionData(to_string(*name)) : MotionData();
}

MotionData cost_data(const FallCost& cost) {
  return {{"path", cost.path},   {"changes", cost.changes}, {"turbulence", cost.turbulence},
          {"kinds", cost.kinds}, {"landing", cost.landing}, {"total", cost.total()}};
}

MotionData history_data(const MotionResult& motion) {
  MotionData list = MotionData::array();
  for (const PlanningStep& step : motion.history)
    list.push_back(
        {{"stage", step.stage}, {"cost", known(step.cost)}, {"depth", step.depth}, {"pieces", step.pieces}});
  return list;
}

MotionData sequence_data(const MotionSequence& sequence, const SequenceOutcome& outcome) {
  MotionData object = {{"origin", sequence.origin},
                       {"seed", sequence.seed ? MotionData(*sequence.seed) : MotionData()},
                       {"asked", outcome.asked},
                       {"had", outcome.had},
                       {"not_reached", outcome.not_reached},
                       {"log_likelihood", known(outcome.log_likelihood)},
                       {"segments", MotionData::array()},
                       {"stretches", MotionData::array()}};
  for (const SequenceOutcome::Segment& one : outcome.segments)
    object["segments"].push_back({{"begin", one.begin},
                                  {"end", one.end},
                                  {"asked", name_or_null(one.asked)},
                                  {"got", one.got ? to_string(*one.got) : "steady"}});
  for (const SequenceOutcome::Stretch& one : outcome.stretches)
    object["stretches"].push_back({{"begin", one.begin},
                                   {"end", one.end},
                                   {"asked", to_string(one.asked)},
                                   {"got", to_string(one.got.pattern)},
                                   {"why", one.got.why}});
  return object;
}

/// Where events are on the way, for the picture.
MotionData events_data(const MotionView& view, const MotionResult& motion) {
  MotionData list = MotionData::array();
  if (!motion.sequence) return list;
  for (const SequenceOutcome::Segment& segment : motion.sequence->segments) {
    const double* const first = view.times.data();
    const Eigen::Index k = std::min<Eigen::Index>(
        std::lower_bound(first, first + view.times.size(), segment.begin) - first, view.times.size() - 1);
    list.push_back({{"t", segment.begin},
                    {"x", shown_number(view.places(k, 0))},
                    {"y", shown_number(view.places(k, 1))},
                    {"z", shown_number(view.places(k, 2))}});
  }
  return list;
}

MotionData coefficients_data(const MotionPlan& plan, const MotionView& view) {
  MotionData list = MotionData::array();
  const models::ModelInfo& info = plan.model->info();
  for (std::size_t j = 0; j < plan.box.size(); ++j) {
    const SteeredCoefficient& one = plan.box[j];
    const auto parameter = std::ranges::find(info.parameters, one.name, &models::ParameterInfo::name);
    list.push_back({{"name", one.name},
                    {"unit", parameter->unit},
                    {"lower", one.lower},
                    {"upper", one.upper},
                    {"natural", one.natural},
                    {"values", shown_list(view.coefficients.col(static_cast<Eigen::Index>(j)))}});
  }
  return list;
}

MotionData page_of(const MotionPlan& plan, const MotionResult& motion, const GhostForce& ghost) {
  const MotionView view = view_of(plan, motion, ghost);
  const models::ModelInfo& info = plan.model->info();
  MotionData data = {{"schema", "samara-motion-page/1"},
                     {"model", info.name},
                     {"status", to_string(motion.status)},
                     {"message", motion.message},
                     {"planar", MotionStates(info).is_planar()},
                     {"units",
                      {{"length", std::ranges::find(info.states, "x", &models::StateInfo::name)->unit},
                       {"time", models::time_unit(info)}}},
                     {"end", motion.end},
                     {"deviation", plan.sketch ? MotionData(motion.deviation) : MotionData()},
                     {"asked_deviation", plan.deviation ? MotionData(*plan.deviation) : MotionData()},
                     {"landing_miss", plan.landing ? MotionData(motion.landing_miss) : MotionData()},
                     {"knots", motion.course->knots().size()},
                     {"replayed_until", motion.replayed_until},
                     {"times", shown_list(view.times)},
                     {"path",
                      {{"x", shown_list(view.places.col(0))},
                       {"y", shown_list(view.places.col(1))},
                       {"z", shown_list(view.places.col(2))}}},
                     {"sketch", MotionData()},
                     {"landing", MotionData()},
                     {"ground", plan.ground},
                     {"events", events_data(view, motion)},
                     {"coefficients", coefficients_data(plan, view)},
                     {"sequence", MotionData()},
                     {"ghost",
                      {{"force_max", ghost.declared.force_sizes.max},
                       {"torque_max", ghost.declared.torque_sizes.max},
                       {"times", shown_list(view.ghost_times)},
                       {"force", shown_list(view.ghost_force)},
                       {"torque", shown_list(view.ghost_torque)}}},
                     {"cost", cost_data(motion.cost)},
                     {"history", history_data(motion)},
                     {"plan", plan.text}};
  if (plan.sketch) {
    data["sketch"] = MotionData::array();
    for (const auto& point : plan.sketch->points().rowwise()) data["sketch"].push_back(shown_list(point));
  }
  if (plan.landing) data["landing"] = {plan.landing->x(), plan.landing->y()};
  if (motion.sequence) data["sequence"] = sequence_data(*plan.sequence, *motion.sequence);
  return data;
}

}  // namespace

std::string motion_html(const MotionPlan& plan, const MotionResult& motion, const GhostForce& ghost) {
  const std::string summary = fmt::format("{}: {}", to_string(motion.status), motion.message);
  const MotionData data = page_of(plan, motion, ghost);
  return identification::html_text(
      {.title = fmt::format("A planned motion of {}", plan.model->info().name),
       .summary = summary,
       .markup = "<main id=\"report\"></main>\n",
       .data = {{"motion", data.dump(-1, ' ', false, MotionData::error_handler_t::replace)}},
       .scripts = {page::kMotionPage}});
}

std::string motion_json(const MotionPlan& plan, const MotionResult& motion, const GhostForce& ghost) {
  MotionData object = {
      {"schema", "samara-motion/1"},
      {"status", to_string(motion.status)},
      {"message", motion.message},
      {"end", motion.end},
      {"knots", motion.course->knots().size()},
      {"replayed_until", motion.replayed_until},
      {"seconds", motion.seconds},
      {"semi_length", plan.semi_length()},
      {"ghost",
       {{"force_max", ghost.declared.force_sizes.max}, {"torque_max", ghost.declared.torque_sizes.max}}},
      {"cost", cost_data(motion.cost)}};
  if (plan.sketch) object["deviation"] = motion.deviation;
  if (plan.landing) object["landing_miss"] = motion.landing_miss;
  if (motion.sequence) object["sequence"] = sequence_data(*plan.sequence, *motion.sequence);
  if (motion.book) object["codebook"] = {{"windows", motion.book->windows}, {"share", motion.book->share()}};
  object["history"] = history_data(motion);
  return object.dump(-1, ' ', false, MotionData::error_handler_t::replace) + "\n";
}

}  // namespace samara::motion
