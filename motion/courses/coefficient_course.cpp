#include "samara/motion/courses/coefficient_course.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"
#include "samara/base/smoothstep.h"
#include "samara/base/version.h"
#include "samara/identification/series/series_codebook.h"

namespace samara::motion {

namespace {

double share_of(const CourseKnot& knot, double t) {
  return t >= knot.t + knot.ramp ? 1.0 : smoothstep((t - knot.t) / knot.ramp);
}

void check_values(const std::vector<double>& values, std::size_t count) {
  if (values.size() != count) {
    throw ArgumentError(fmt::format(
        "a knot of a course has {} values, expected one for each of {} coefficients", values.size(), count));
  }
  for (const double value : values) {
    if (!std::isfinite(value))
      throw ArgumentError(fmt::format("a course has the value {}, expected a number", value));
  }
}

const models::ParameterInfo& parameter_of(const models::ModelInfo& model, const std::string& name) {
  const auto found = std::ranges::find(model.parameters, name, &models::ParameterInfo::name);
  if (found != model.parameters.end()) return *found;
  std::vector<std::string> known;
  for (const models::ParameterInfo& parameter : model.parameters) known.push_back(parameter.name);
  throw ArgumentError(fmt::format("the course has \"{}\", which is no parameter of \"{}\"{}", name,
                                  model.name, suggestion(name, known)));
}

/// Units of parameters and initial values.
std::map<std::string, std::string> units_of(const models::ModelInfo& model,
                                            const std::map<std::string, double>& values) {
  std::map<std::string, std::string> units;
  for (const models::ParameterInfo& parameter : model.parameters) {
    if (values.contains(parameter.name)) units[parameter.name] = parameter.unit;
  }
  for (const models::StateInfo& state : model.states) {
    if (values.contains(state.name + "(0)")) units[state.name + "(0)"] = state.unit;
  }
  return units;
}

/// That nothing was approximated.
codebooks::Certificate exact_certificate(const std::vector<pgd::OutputLabel>& outputs,
                                         const Eigen::MatrixXd& values, int times) {
  codebooks::Certificate certificate;
  certificate.integrator = "none: a course that was planned, and which the basis holds exactly";
  certificate.points = 1;
  certificate.times = times;
  certificate.met = true;
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    codebooks::OutputError error;
    error.name = outputs[k].name;
    error.unit = outputs[k].unit;
    error.range = std::max(1e-300, values.col(static_cast<Eigen::Index>(k)).cwiseAbs().maxCoeff());
    error.worst = {0.0};
    certificate.outputs.push_back(error);
  }
  return certificate;
}

}  // namespace

CoefficientCourse::CoefficientCourse(std::vector<std::string> names, std::vector<double> first,
                                     std::vector<CourseKnot> knots)
    : names_(std::move(names)), first_(std::move(first)), knots_(std::move(knots)) {
  if (names_.empty()) throw ArgumentError("a course has no coefficients, expected one or more");
  for (const std::string& name : names_) {
    if (std::ranges::count(names_, name) > 1) {
      throw ArgumentError(fmt::format("a course has \"{}\" twice, expected it once", name));
    }
  }
  check_values(first_, names_.size());
  double last = 0.0;
  std::vector<double> reached = first_;
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    const CourseKnot& knot = knots_[k];
    check_values(knot.values, names_.size());
    require_positive(knot.ramp, "ramp of a knot");
    if (!(knot.t >= last) || (k > 0 && knot.t == last) || !std::isfinite(knot.t)) {
      throw ArgumentError(fmt::format(
          "a knot of a course is at {} after {}, expected them to increase from 0 on", knot.t, last));
    }
    last = knot.t;
    if (k > 0) {
      const CourseKnot& before = knots_[k - 1];
      const double share = share_of(before, knot.t);
      for (std::size_t j = 0; j < reached.size(); ++j) reached[j] = gone(reached[j], before.values[j], share);
    }
    from_.push_back(reached);
  }
}

void CoefficientCourse::values(double t, std::span<const double>, std::span<double> followed) const {
  const auto next = std::ranges::upper_bound(knots_, t, {}, &CourseKnot::t);
  if (next == knots_.begin()) {
    std::ranges::copy(first_, followed.begin());
    return;
  }
  const auto k = static_cast<std::size_t>(next - knots_.begin()) - 1;
  const double share = share_of(knots_[k], t);
  for (std::size_t j = 0; j < followed.size(); ++j)
    followed[j] = gone(from_[k][j], knots_[k].values[j], share);
}

std::vector<double> CoefficientCourse::instants(double end) const {
  std::vector<double> all = {0.0, end};
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    const double until = knots_[k].t + knots_[k].ramp;
    all.push_back(knots_[k].t);
    if (k + 1 == knots_.size() || until < knots_[k + 1].t) all.push_back(until);
  }
  std::ranges::sort(all);
  std::erase_if(all, [&](double t) { return t > end; });
  // Ends of ramps that round-off puts beside the next knot.
  const double apart = 1e-12 * end;
  std::vector<double> instants;
  for (const double t : all) {
    if (instants.empty() || t - instants.back() > apart) instants.push_back(t);
  }
  if (instants.back() != end) instants.back() = end;
  return instants;
}

codebooks::Codebook course_codebook(const CoefficientCourse& course, const models::ModelInfo& model,
                                    const std::map<std::string, double>& fixed, double end) {
  require_positive(end, "end of a course");
  const auto count = static_cast<Eigen::Index>(course.followed().size());
  constexpr int kCubic = 3;
  const std::vector<double> borders = course.instants(end);
  const pgd::Axis t =
      pgd::Axis::legendre({.name = "t", .unit = models::time_unit(model), .role = pgd::AxisRole::time},
                          Eigen::Map<const Eigen::VectorXd>(borders.data(), std::ssize(borders)), kCubic);
  Eigen::MatrixXd values(t.size(), count);
  std::vector<double> row(course.followed().size());
  for (Eigen::Index k = 0; k < values.rows(); ++k) {
    course.values(t.nodes()[k], {}, row);
    values.row(k) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), count);
  }
  std::vector<pgd::OutputLabel> outputs;
  std::string names;
  for (const std::string& name : course.followed()) {
    outputs.push_back({name, parameter_of(model, name).unit});
    names += (names.empty() ? "" : ", ") + name;
  }
  const pgd::SeparatedField field({t}, outputs, {values}, Eigen::MatrixXd::Identity(count, count));
  codebooks::ModelDescription description{
      .name = identification::series_name(model.name),
      .title = fmt::format("{} of {} along a planned motion", names, model.name),
      .equations = fmt::format("{} as functions of time, at rest but for smoothsteps at {} knots", names,
                               course.knots().size()),
      .frames = "those of the model",
      .source = "a plan of motion",
      .fixed = fixed,
      .fixed_units = units_of(model, fixed)};
  codebooks::BuildRecord build{.builder = "plan",
                               .strategy = "course",
                               .status = Termination::converged,
                               .message = fmt::format("{} knots", course.knots().size()),
                               .grid_size = static_cast<double>(t.size())};
  codebooks::Provenance provenance;
  provenance.generator = fmt::format("samara {}", version());
  return codebooks::Codebook(std::move(description), {codebooks::Piece::Groups{field}}, std::move(build),
                             std::move(provenance), exact_certificate(outputs, values, t.size()));
}

}  // namespace samara::motion
