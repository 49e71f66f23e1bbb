#include "samara/codebooks/composition/codebook_trajectories.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/composition/flow_map.h"
#include "samara/codebooks/composition/shared_queries.h"
#include "samara/models/integrators/trajectory_tools.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/trajectories/derived_outputs.h"
#include "samara/models/trajectories/interval.h"
#include "samara/models/trajectories/model_symmetry.h"
#include "samara/models/trajectories/reference_trajectories.h"

namespace samara::codebooks {

namespace {

/// Empty if the model is not known, or has other coordinates than the codebook.
std::optional<models::ParametricModel> equations_of(const Codebook& book) {
  if (!known_model(book.model())) return {};
  try {
    return model_of(book);
  } catch (const ArgumentError&) {
    return {};
  }
}

models::FamilyInfo describe(const Codebook& book, const std::optional<models::ParametricModel>& equations) {
  models::FamilyInfo info{.model = book.model().name, .source = "codebook", .fixed = book.model().fixed};
  const auto& coordinates = book.coordinates();
  info.end_time = book.time("a family of trajectories").upper;
  for (std::size_t k = 1; k < coordinates.size(); ++k) {
    const Coordinate& c = coordinates[k];
    info.coordinates.push_back({c.name, c.unit, c.role == pgd::AxisRole::initial, c.lower, c.upper});
  }
  for (const pgd::OutputLabel& output : book.outputs()) info.outputs.push_back({output.name, output.unit});
  if (equations) {
    models::describe_equations(*equations, info);
  } else if (const auto model = known_model(book.model())) {
    info.translations = models::translated_outputs(model->info(), info.outputs);
  }
  return info;
}

class CodebookSource final : public models::TrajectorySource {
 public:
  explicit CodebookSource(SharedQueries::Query query) : query_(std::move(query)) {}

  models::TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                     Eigen::MatrixXd* derivatives) override {
    try {
      if (derivatives) {
        query_->values(q, values, *derivatives);
      } else {
        query_->values(q, values);
      }
    } catch (const OutsideBoxError& error) {
      return {models::TrajectoryStatus::outside_box, error.what()};
    }
    return {};
  }

 private:
  SharedQueries::Query query_;
};

class CodebookTrajectories final : public models::TrajectoryFamily {
 public:
  explicit CodebookTrajectories(const Codebook& book)
      : equations_(equations_of(book)), info_(describe(book, equations_)), queries_(book) {}

  const models::FamilyInfo& info() const override { return info_; }
  const models::ParametricModel* equations() const override { return equations_ ? &*equations_ : nullptr; }

  using models::TrajectoryFamily::at;
  std::unique_ptr<models::TrajectorySource> at(const std::vector<double>& times,
                                               const std::vector<std::string>& outputs) const override {
    models::check_times(times);
    return std::make_unique<CodebookSource>(queries_.at(times, outputs));
  }

 private:
  std::optional<models::ParametricModel> equations_;
  models::FamilyInfo info_;
  SharedQueries queries_;
};

/// Where a number of the flow map's start comes from.
struct StartValue {
  std::optional<std::size_t> coordinate = {};  ///< of the family
  double held = 0.0;
};

class FlowMapSource final : public models::TrajectorySource {
 public:
  /// @param starts of all states  @param parameters,outputs places among the family's coordinates, the states
  FlowMapSource(const Codebook& book, const Codebook* second, const std::vector<double>& times,
                std::vector<StartValue> starts, std::vector<std::size_t> parameters,
                std::vector<Eigen::Index> outputs)
      : flow_map_(second != nullptr ? FlowMap(book, *second) : FlowMap(book)),
        times_(times),
        starts_(std::move(starts)),
        parameters_(std::move(parameters)),
        outputs_(std::move(outputs)),
        coordinates_(book.coordinates().size() - 1) {}

  models::TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                     Eigen::MatrixXd* derivatives) override {
    models::check_point(q, coordinates_);
    std::vector<double> start;
    std::vector<double> p;
    for (const StartValue& s : starts_) start.push_back(s.coordinate ? q[*s.coordinate] : s.held);
    for (const std::size_t k : parameters_) p.push_back(q[k]);
    try {
      const FlowMapResult result = flow_map_.run(start, p, times_, derivatives != nullptr);
      for (std::size_t o = 0; o < outputs_.size(); ++o) {
        values.col(static_cast<Eigen::Index>(o)) = result.states.col(outputs_[o]);
      }
      if (derivatives) spread(result, *derivatives);
      if (result.status == FlowMapStatus::done) return {};
      const bool has_rows = !times_.empty() && !std::isnan(result.states(0, 0));
      return {models::TrajectoryStatus::outside_box, result.message, has_rows ? result.reached : -1.0};
    } catch (const OutsideBoxError& error) {
      return {models::TrajectoryStatus::outside_box, error.what()};
    }
  }

 private:
  /// Derivatives by all states and the parameters to the places of the family's coordinates.
  void spread(const FlowMapResult& result, Eigen::MatrixXd& derivatives) const {
    const auto width = static_cast<Eigen::Index>(outputs_.size());
    for (std::size_t row = 0; row < result.derivatives.size(); ++row) {
      for (Eigen::Index o = 0; o < width; ++o) {
        const auto from = result.derivatives[row].row(outputs_[static_cast<std::size_t>(o)]);
        const auto put = [&](std::size_t coordinate, std::size_t column) {
          derivatives(static_cast<Eigen::Index>(row), o + width * static_cast<Eigen::Index>(coordinate)) =
              from[static_cast<Eigen::Index>(column)];
        };
        for (std::size_t i = 0; i < starts_.size(); ++i) {
          if (starts_[i].coordinate) put(*starts_[i].coordinate, i);
        }
        for (std::size_t k = 0; k < parameters_.size(); ++k) put(parameters_[k], starts_.size() + k);
      }
    }
  }

  FlowMap flow_map_;
  std::vector<double> times_;
  std::vector<StartValue> starts_;
  std::vector<std::size_t> parameters_;
  std::vector<Eigen::Index> outputs_;
  std::size_t coordinates_;
};

class FlowMapTrajectories final : public models::TrajectoryFamily {
 public:
  FlowMapTrajectories(const Codebook& book, const Codebook* second)
      : book_(book), second_(second), equations_(model_of(book)), info_(describe(book, equations_)) {
    const FlowMap refuses_what_it_must = second != nullptr ? FlowMap(book, *second) : FlowMap(book);
    info_.source = "flow map of a codebook";
    info_.end_time = std::numeric_limits<double>::infinity();
    info_.outputs.clear();
    for (const models::StateInfo& state : equations_->model().info().states) {
      info_.outputs.push_back({state.name, state.unit});
      starts_.push_back(
          {models::position(info_.coordinates, state.name + "(0)"), models::held_start(state, info_.fixed)});
    }
    for (std::size_t k = 0; k < info_.coordinates.size(); ++k) {
      if (!info_.coordinates[k].is_initial) parameters_.push_back(k);
    }
  }

  const models::FamilyInfo& info() const override { return info_; }
  const models::ParametricModel* equations() const override { return &*equations_; }

  using models::TrajectoryFamily::at;
  std::unique_ptr<models::TrajectorySource> at(const std::vector<double>& times,
                                               const std::vector<std::string>& outputs) const override {
    models::check_times(times);
    std::vector<Eigen::Index> places;
    for (const std::string& output : outputs) {
      const auto found = std::ranges::find(info_.outputs, output, &models::FamilyOutput::name);
      if (found == info_.outputs.end()) {
        throw ArgumentError(fmt::format("model \"{}\" has no state \"{}\"", info_.model, output));
      }
      places.push_back(found - info_.outputs.begin());
    }
    return std::make_unique<FlowMapSource>(book_, second_, times, starts_, parameters_, std::move(places));
  }

 private:
  const Codebook& book_;
  const Codebook* second_;
  std::optional<models::ParametricModel> equations_;
  models::FamilyInfo info_;
  std::vector<StartValue> starts_;
  std::vector<std::size_t> parameters_;
};

}  // namespace

std::unique_ptr<models::TrajectoryFamily> codebook_trajectories(const Codebook& book) {
  return models::with_derived_outputs(std::make_unique<CodebookTrajectories>(book));
}

std::unique_ptr<models::TrajectoryFamily> flow_map_trajectories(const Codebook& book,
                                                                const Codebook* second) {
  return models::with_derived_outputs(std::make_unique<FlowMapTrajectories>(book, second));
}

std::unique_ptr<models::TrajectoryFamily> reference_trajectories(const Codebook& book,
                                                                 const models::IntegrateOptions& options) {
  const auto model = model_of(book).shared_model();
  std::map<std::string, models::Interval> box;
  for (const Coordinate& c : book.coordinates()) {
    if (c.role != pgd::AxisRole::time) box[c.name] = {c.lower, c.upper};
  }
  return models::reference_trajectories(model, book.model().fixed, box, options);
}

}  // namespace samara::codebooks
