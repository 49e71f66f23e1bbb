#include "samara/motion/planning/book_tangents.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/book_model.h"
#include "samara/motion/sweeps/sweep.h"

namespace samara::motion {

namespace {

const codebooks::Codebook& of_the_model(const codebooks::Codebook& book, const models::ModelInfo& info) {
  if (book.model().name != info.name)
    throw ArgumentError(
        fmt::format("the codebook is of \"{}\", expected one of \"{}\"", book.model().name, info.name));
  if (model_text(codebooks::model_of(book).model().info()) != model_text(info))
    throw ArgumentError(fmt::format(
        "the codebook is of another model \"{}\", whose equations or parameters differ", info.name));
  return book;
}

/// All parameters of the plan's body, where these of its coefficients have other values.
std::vector<double> parameters_of(const MotionPlan& plan, const std::map<std::string, double>& changed) {
  std::map<std::string, double> fixed = plan.fixed;
  for (const SteeredCoefficient& c : plan.box) fixed[c.name] = c.natural;
  for (const auto& [name, value] : changed) fixed[name] = value;
  return models::ParametricModel(plan.model, fixed, {}).parameters({});
}

/// The model of the codebook and that of the plan have the same parameters at the same point, also those that follow
/// from others.
void require_same_constants(const codebooks::Codebook& book, const MotionPlan& plan,
                            const std::map<std::string, double>& changed) {
  const std::vector<models::ParameterInfo>& infos = plan.model->info().parameters;
  const std::vector<double> own = parameters_of(plan, changed);
  const models::ParametricModel model = codebooks::model_of(book);
  std::vector<double> q;
  for (std::size_t k = 1; k < book.coordinates().size(); ++k) {
    const auto found = std::ranges::find(infos, book.coordinates()[k].name, &models::ParameterInfo::name);
    q.push_back(found == infos.end() ? book.coordinates()[k].lower
                                     : own[static_cast<std::size_t>(found - infos.begin())]);
  }
  const std::vector<double> others = model.parameters(q);
  for (std::size_t j = 0; j < own.size(); ++j) {
    if (std::abs(own[j] - others[j]) <= 1e-9 * std::max(std::abs(own[j]), std::abs(others[j]))) continue;
    throw ArgumentError(
        fmt::format("the codebook has {} = {}, the body has {}", infos[j].name, others[j], own[j]));
  }
}

}  // namespace

BookTangents::BookTangents(const MotionPlan& plan)
    : book_(plan.codebook), map_(of_the_model(*book_, plan.model->info())) {
  const std::vector<models::ParameterInfo>& infos = plan.model->info().parameters;
  const std::vector<double> natural = parameters_of(plan, {});
  std::vector<std::string> names;
  for (const codebooks::Coordinate& c : map_.parameters()) {
    names.push_back(c.name);
    const auto found = std::ranges::find(infos, c.name, &models::ParameterInfo::name);
    const double value = natural[static_cast<std::size_t>(found - infos.begin())];
    parameters_.push_back(value);
    const auto steered = std::ranges::find(plan.box, c.name, &SteeredCoefficient::name);
    const bool is_steered = steered != plan.box.end();
    if ((is_steered ? steered->upper : value) < c.lower || (is_steered ? steered->lower : value) > c.upper)
      throw ArgumentError(fmt::format(
          "the codebook has {} from {} to {}, the plan {}", c.name, c.lower, c.upper,
          is_steered ? fmt::format("{} to {}", steered->lower, steered->upper) : fmt::format("{}", value)));
  }
  require_same_constants(*book_, plan, {});
  for (const SteeredCoefficient& c : plan.box) {
    const auto found = std::ranges::find(names, c.name);
    if (found == names.end())
      throw ArgumentError(
          fmt::format("the codebook has no coordinate {}, which may change in the plan", c.name));
    places_.push_back(found - names.begin());
    for (const double value : {c.lower, c.upper}) require_same_constants(*book_, plan, {{c.name, value}});
  }
  const double step = plan.search.step;
  steps_ = static_cast<long>(map_.window() / step * (1.0 + 1e-12));
  if (steps_ < 1)
    throw ArgumentError(fmt::format("the codebook ends at {}, expected a step of the plan, {}, or more",
                                    map_.window(), step));
}

bool BookTangents::set_coefficients(std::span<const double> values) {
  bool is_inside = true;
  for (std::size_t j = 0; j < values.size(); ++j) {
    const codebooks::Coordinate& c = map_.parameters()[static_cast<std::size_t>(places_[j])];
    is_inside = is_inside && values[j] >= c.lower && values[j] <= c.upper;
    parameters_[static_cast<std::size_t>(places_[j])] = values[j];
  }
  return is_inside;
}

bool BookTangents::transition(std::span<const double> start, double duration, Eigen::MatrixXd& by_start,
                              Eigen::MatrixXd& by_coefficients) {
  const codebooks::FlowMapResult result = map_.run(start, parameters_, std::array{duration}, true);
  if (result.status != codebooks::FlowMapStatus::done || !result.derivatives.front().allFinite())
    return false;
  const Eigen::MatrixXd& all = result.derivatives.front();
  const auto states = std::ssize(start);
  by_start = all.leftCols(states);
  by_coefficients.resize(states, std::ssize(places_));
  for (std::size_t j = 0; j < places_.size(); ++j)
    by_coefficients.col(static_cast<Eigen::Index>(j)) = all.col(states + places_[j]);
  return true;
}

}  // namespace samara::motion
