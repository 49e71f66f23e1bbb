#include "samara/identification/series/series_codebook.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <mutex>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/version.h"
#include "samara/codebooks/query/query.h"

namespace samara::identification {

namespace {

/// Begins the name of what a series belongs to: it is no solution of the model.
constexpr std::string_view kSeriesOf = "coefficients of ";

codebooks::OutputError error_of(const SeriesCoefficient& c, const Eigen::VectorXd& times) {
  codebooks::OutputError error;
  error.name = c.name;
  error.unit = c.unit;
  error.range = std::max(c.values.cwiseAbs().maxCoeff(), 1e-300);
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (Eigen::Index k = 0; k < c.values.size(); ++k) {
    const double own = c.standard_errors[k];
    if (std::isnan(own)) continue;
    sum += own;
    squares += own * own;
    ++count;
    if (own <= error.max_si && !error.worst.empty()) continue;
    error.max_si = own;
    error.worst = {times[k]};
  }
  error.max = error.max_si / error.range;
  error.p95 = error.max;
  error.mean = count > 0 ? sum / count / error.range : 0.0;
  error.rms = count > 0 ? std::sqrt(squares / std::max(1e-300, c.values.squaredNorm())) : 0.0;
  if (error.worst.empty()) error.worst = {times[0]};
  return error;
}

/// What stands for the error of the codebook: how well captures determine its values.
codebooks::Certificate certificate_of(const CoefficientSeries& series, const Eigen::VectorXd& times) {
  codebooks::Certificate certificate;
  certificate.integrator = "the standard errors of a fit to captures (nothing was integrated)";
  certificate.points = 1;
  certificate.times = static_cast<int>(times.size());
  bool all_known = true;
  for (const SeriesCoefficient& c : series.coefficients) {
    certificate.outputs.push_back(error_of(c, times));
    certificate.max_error = std::max(certificate.max_error, certificate.outputs.back().max);
    all_known = all_known && !c.standard_errors.array().isNaN().any();
  }
  certificate.tolerance = certificate.max_error;
  certificate.met = series.status == Termination::converged && all_known;
  return certificate;
}

class CodebookCourse final : public models::ParameterCourse {
 public:
  explicit CodebookCourse(const codebooks::Codebook& book)
      : query_(book), lower_(book.coordinates().front().lower), upper_(book.coordinates().front().upper) {
    for (const pgd::OutputLabel& output : book.outputs()) followed_.push_back(output.name);
  }

  const std::vector<std::string>& followed() const override { return followed_; }

  /// Beyond the ends: the value there.
  void values(double t, std::span<const double>, std::span<double> followed) const override {
    const double inside = std::clamp(t, lower_, upper_);
    const std::lock_guard lock(busy_);  // a query has scratch space
    query_.values({&inside, 1},
                  Eigen::Map<Eigen::VectorXd>(followed.data(), static_cast<Eigen::Index>(followed.size())));
  }

 private:
  mutable std::mutex busy_;
  mutable codebooks::Query query_;
  double lower_, upper_;
  std::vector<std::string> followed_;
};

/// @throws ArgumentError unless each value of the output is one the parameter may have.
void check_output(const codebooks::Codebook& book, const models::ModelInfo& model, std::size_t output) {
  const pgd::OutputLabel& label = book.outputs()[output];
  std::vector<std::string> known;
  for (const models::ParameterInfo& p : model.parameters) known.push_back(p.name);
  const auto parameter = std::ranges::find(model.parameters, label.name, &models::ParameterInfo::name);
  if (parameter == model.parameters.end()) {
    throw ArgumentError(fmt::format("the series has \"{}\", which is no parameter of \"{}\"{}", label.name,
                                    model.name, suggestion(label.name, known)));
  }
  if (parameter->unit != label.unit) {
    throw ArgumentError(fmt::format("the series has \"{}\" in {}; the {} of model \"{}\" was expected",
                                    label.name, label.unit, parameter->unit, model.name));
  }
  codebooks::Query query(book, {.outputs = {label.name}});
  Eigen::VectorXd value(1);
  for (const codebooks::Piece& piece : book.pieces()) {
    const codebooks::PieceOutline outline = piece.outline();
    for (const double t : outline.axes.front().nodes()) {
      query.values({&t, 1}, value);
      if (models::in_meaning(*parameter, value[0])) continue;
      throw ArgumentError(fmt::format("the series has {} = {} at {}; a value {} was expected", label.name,
                                      value[0], t, models::meaning_text(*parameter)));
    }
  }
}

}  // namespace

codebooks::Codebook series_codebook(const CoefficientSeries& series) {
  if (series.status == Termination::failed || series.coefficients.empty()) {
    throw ArgumentError(fmt::format("a series that could not be fitted has no codebook: {}", series.message));
  }
  const Eigen::VectorXd times = series.instants.array() - series.instants[0];
  const auto count = static_cast<Eigen::Index>(series.coefficients.size());
  Eigen::MatrixXd factors(times.size(), count);
  std::vector<pgd::OutputLabel> outputs;
  std::string names;
  for (Eigen::Index c = 0; c < count; ++c) {
    const SeriesCoefficient& coefficient = series.coefficients[static_cast<std::size_t>(c)];
    factors.col(c) = coefficient.values;
    outputs.push_back({coefficient.name, coefficient.unit});
    names += (names.empty() ? "" : ", ") + coefficient.name;
  }
  const pgd::Axis t =
      pgd::Axis::p1({.name = "t", .unit = series.time_unit, .role = pgd::AxisRole::time}, times);
  const pgd::SeparatedField field({t}, outputs, {factors}, Eigen::MatrixXd::Identity(count, count));

  codebooks::ModelDescription description{
      .name = series_name(series.model),
      .title = fmt::format("{} of {} along captured motion", names, series.model),
      .equations = fmt::format("{} as functions of the time since the first frame, straight lines between "
                               "instants",
                               names),
      .frames = "those of the model",
      .source = fmt::format("a fit to {} of captures: {}", series.joined ? "joined spans" : "sliding spans",
                            series.message),
      .fixed = series.replay,
      .fixed_units = series.replay_units};
  codebooks::BuildRecord build{.builder = "fit",
                               .strategy = "series",
                               .status = series.status,
                               .message = series.message,
                               .evaluations = static_cast<double>(series.fit.evaluations),
                               .grid_size = static_cast<double>(times.size()),
                               .iterations = series.fit.iterations};
  codebooks::Provenance provenance;
  provenance.generator = fmt::format("samara {}", version());
  provenance.created = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  provenance.build_seconds = series.fit.seconds;
  return codebooks::Codebook(std::move(description), {codebooks::Piece::Groups{field}}, std::move(build),
                             std::move(provenance), certificate_of(series, times));
}

std::string series_name(const std::string& model) {
  return std::string(kSeriesOf) + model;
}

std::shared_ptr<const models::ParameterCourse> codebook_course(const codebooks::Codebook& book,
                                                               const models::ModelInfo& model) {
  if (!book.has_time() || book.coordinate_count() != 1) {
    throw ArgumentError(
        fmt::format("the codebook of \"{}\" is over {} coordinates; a series over time alone "
                    "was expected",
                    book.model().name, book.coordinate_count()));
  }
  const std::string& name = book.model().name;
  if (name.starts_with(kSeriesOf) && name.substr(kSeriesOf.size()) != model.name) {
    throw ArgumentError(
        fmt::format("the series holds the {}; those of \"{}\" were expected", name, model.name));
  }
  for (std::size_t k = 0; k < book.outputs().size(); ++k) check_output(book, model, k);
  return std::make_shared<CodebookCourse>(book);
}

}  // namespace samara::identification
