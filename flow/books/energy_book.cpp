#include "samara/flow/books/energy_book.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/provenance.h"
#include "samara/codebooks/build/described.h"
#include "samara/codebooks/build/sampling_builder.h"
#include "samara/codebooks/certify/measure.h"
#include "samara/codebooks/query/query.h"
#include "samara/flow/books/leja_grid.h"
#include "samara/flow/books/planned_flow.h"
#include "samara/pgd/fields/train_field.h"

namespace samara::flow {

namespace {

/// Differences below these do not matter, whatever an output's range: a lift that is 0 everywhere has none.
constexpr double kLoadFloor = 0.1, kStrouhalFloor = 0.02, kLengthFloor = 0.5, kEnergyFloor = 0.01;

double floor_of(const std::string& output) {
  if (output == "strouhal") return kStrouhalFloor;
  if (output == "bubble_end") return kLengthFloor;
  return output == "k_near" || output == "epsilon_near" ? kEnergyFloor : kLoadFloor;
}

/// Mean of a field over the fluid within half a length of the body.
double mean_near(const FlowResult& result, const FlowCase& flow, const Field& field) {
  constexpr double kNear = 0.5;
  const PlacedShape body(flow.shape, Eigen::Vector3d::Zero(), flow.angle_of_attack);
  const MacGrid& grid = result.grid;
  double sum = 0.0, volume = 0.0;
  for (int k = 0; k < grid.cells[2]; ++k) {
    for (int j = 0; j < grid.cells[1]; ++j) {
      for (int i = 0; i < grid.cells[0]; ++i) {
        const auto c = static_cast<std::size_t>(grid.at(i, j, k));
        const double open = result.body.inverse_cell[c] > 0.0 ? result.body.cell[c] : 0.0;
        if (open == 0.0 || body.distance(grid.centre(i, j, k)) > kNear) continue;
        sum += open * field[c];
        volume += open;
      }
    }
  }
  return volume > 0.0 ? sum / volume : 0.0;
}

codebooks::Plan energy_plan(const FlowPlan& plan) {
  codebooks::Plan book;
  book.title = plan.title;
  book.text = checkpointed_text(plan);
  book.box = plan.box;
  book.relative = plan.relative;
  book.builder.kind = "sampling";
  book.builder.seed = plan.seed;
  codebooks::PlannedCommand command;
  command.run = {"samara", "flow"};
  command.inputs = {{"angle_of_attack", "rad"}, {"log10_reynolds", "1"}};
  command.outputs = energy_outputs(plan.flow);
  command.batch = 1;
  book.command = command;
  for (const codebooks::CommandQuantity& output : command.outputs)
    book.absolute[output.name] = floor_of(output.name);
  const auto is_free = [&](const std::string& name) {
    return std::any_of(plan.box.begin(), plan.box.end(),
                       [&](const auto& entry) { return entry.name == name; });
  };
  if (!is_free("angle_of_attack")) book.fixed["angle_of_attack"] = plan.flow.angle_of_attack;
  if (!is_free("log10_reynolds")) book.fixed["log10_reynolds"] = std::log10(plan.flow.reynolds);
  return book;
}

/// Ranges of the outputs over the flows that there are, or the floors.
Eigen::VectorXd scales_of(const LejaGrid& grid, const std::vector<pgd::OutputLabel>& outputs) {
  Eigen::VectorXd low = grid.columns().begin()->second, high = low;
  for (const auto& [numbers, column] : grid.columns()) {
    low = low.cwiseMin(column).eval();
    high = high.cwiseMax(column).eval();
  }
  Eigen::VectorXd scales = high - low;
  for (Eigen::Index o = 0; o < scales.size(); ++o)
    scales[o] = std::max(scales[o], floor_of(outputs[static_cast<std::size_t>(o)].name));
  return scales;
}

/// The polynomials of the grid, all of them.
pgd::TrainField field_of(const LejaGrid& grid, const FlowPlan& plan,
                         const std::vector<pgd::OutputLabel>& outputs) {
  std::vector<pgd::Axis> axes;
  for (std::size_t k = 0; k < plan.box.size(); ++k) {
    const codebooks::BoxEntry& entry = plan.box[k];
    axes.push_back(pgd::Axis::chebyshev({entry.name, entry.name == "angle_of_attack" ? "rad" : "1"},
                                        entry.lower, entry.upper, grid.counts()[k]));
  }
  return {std::move(axes), outputs, pgd::to_train(grid.on_chebyshev_points(), grid.counts(), 0.0)};
}

}  // namespace

std::vector<codebooks::CommandQuantity> energy_outputs(const FlowCase& flow) {
  std::vector<codebooks::CommandQuantity> outputs = {{"C_D", "1"},     {"C_L", "1"},      {"C_M", "1"},
                                                     {"C_L_rms", "1"}, {"strouhal", "1"}, {"bubble_end", "1"},
                                                     {"k_near", "1"}};
  if (flow.turbulence != TurbulenceModel::none) outputs.push_back({"epsilon_near", "1"});
  return outputs;
}

Eigen::VectorXd energy_of(const FlowResult& result, const FlowCase& flow) {
  Field k = result.k_resolved;
  for (std::size_t c = 0; c < result.k_modelled.size(); ++c) k[c] += result.k_modelled[c];
  Eigen::VectorXd values(static_cast<Eigen::Index>(energy_outputs(flow).size()));
  values.head<7>() << result.drag.value, result.lift, result.moment, result.lift_rms, result.strouhal,
      result.bubble_end, mean_near(result, flow, k);
  if (flow.turbulence != TurbulenceModel::none) values(7) = mean_near(result, flow, result.epsilon);
  return values;
}

Eigen::VectorXd solve_energy(const FlowPlan& plan, const std::vector<double>& point,
                             const ProgressCallback& progress,
                             const std::function<void(const std::string&)>& warning) {
  return energy_of(solve_at(plan, point, progress, warning), flow_case_at(plan, point));
}

namespace {

/// The flows of the plan, of which none is solved twice.
codebooks::CallMemory flow_calls(const FlowPlan& plan, const codebooks::BuildOptions& options) {
  // A command is told what is fixed as well: the angle, then the Reynolds number.
  const auto function = [plan, progress = options.progress, warning = options.warning](
                            const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      std::vector<double> point;
      for (const codebooks::BoxEntry& entry : plan.box)
        point.push_back(points(entry.name == "angle_of_attack" ? 0 : 1, j));
      values.col(j) = solve_energy(plan, point, progress, warning);
    }
  };
  const codebooks::Plan book_plan = energy_plan(plan);
  return codebooks::calls_of(book_plan, codebooks::command_source(book_plan, function), options);
}

/// @throws NoResultError if a flow is not found
Eigen::MatrixXd solved(codebooks::CallMemory& calls, const Eigen::MatrixXd& points) {
  codebooks::CalledAnswers answers = calls(points, {});
  calls.save();
  if (!answers.failure.empty()) throw NoResultError(answers.failure);
  return std::move(answers.values);
}

codebooks::BuildResult built(const FlowPlan& plan, const codebooks::BuildOptions& options) {
  const codebooks::Plan book_plan = energy_plan(plan);
  const auto begin = std::chrono::steady_clock::now();
  codebooks::CallMemory calls = flow_calls(plan, options);
  const std::vector<pgd::OutputLabel>& outputs = calls.source().outputs;

  LejaGrid grid(plan.box.size());
  const auto solve = [&](const std::vector<double>& unit) -> Eigen::VectorXd {
    Eigen::VectorXd point(static_cast<Eigen::Index>(unit.size()));
    for (std::size_t k = 0; k < unit.size(); ++k)
      point[static_cast<Eigen::Index>(k)] = in_interval(plan.box[k].lower, plan.box[k].upper, unit[k]);
    return solved(calls, point);
  };
  const auto apart = [&](const Eigen::VectorXd& foretold, const Eigen::VectorXd& found) {
    return (foretold - found).cwiseAbs().cwiseQuotient(scales_of(grid, outputs)).maxCoeff();
  };
  const GridGrowth growth = grow(grid, solve, apart, kForetold * plan.relative, plan.max_calls);

  codebooks::BuildRecord record;
  record.builder = "sampling";
  record.strategy = "grid";
  record.status = growth.status;
  record.evaluations = static_cast<double>(growth.solved);
  record.grid_size = static_cast<double>(grid.size());
  record.rounds = 1;
  record.message = growth.text(grid, plan.max_calls);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  const codebooks::Codebook book(codebooks::describe(book_plan),
                                 {codebooks::Piece{{field_of(grid, plan, outputs)}}}, record,
                                 codebooks::made_now(plan.text, took.count()), {}, plan.title);
  codebooks::CertifyOptions certify;
  certify.points = options.certificate_points.value_or(plan.certificate_points);
  certify.seed = book_plan.certificate_seed();
  certify.tolerance = plan.relative;
  certify.absolute = book_plan.absolute;
  certify.climbs = 0;  // the plan says how many flows the certificate may solve
  certify.progress = options.progress;
  codebooks::Certificate certificate =
      codebooks::measure(book, calls, certify, codebooks::Extent::all_points).certificate;
  calls.save();
  certificate.met = certificate.met && growth.status == Termination::converged;
  const std::string message =
      fmt::format("{}; largest error {:.3g} at {} points, tolerance {:.3g}", record.message,
                  certificate.max_error, certificate.points, certificate.tolerance);
  const bool met = certificate.met, incomplete = certificate.failed_points > 0;
  return {book.with_certificate(std::move(certificate)), met, message, incomplete};
}

}  // namespace

codebooks::BuildResult build_energy_book(const FlowPlan& plan, const codebooks::BuildOptions& options) {
  check_book(plan);
  return run_build(options, [&](const codebooks::BuildOptions& guarded) { return built(plan, guarded); });
}

Eigen::VectorXd discretisation(const FlowPlan& plan, const codebooks::Codebook& book,
                               const codebooks::BuildOptions& options) {
  codebooks::BuildOptions finer_options = options;
  finer_options.checkpoint = finer_checkpoint(options.checkpoint);
  codebooks::CallMemory finer_calls = flow_calls(finer_plan(plan), finer_options);
  const auto [lower, upper] = corners_of(plan);
  Eigen::MatrixXd corners(static_cast<Eigen::Index>(lower.size()), 2);
  for (std::size_t k = 0; k < lower.size(); ++k)
    corners.row(static_cast<Eigen::Index>(k)) << lower[k], upper[k];
  const Eigen::MatrixXd fine = solved(finer_calls, corners);
  Eigen::MatrixXd coarse(book.output_count(), 2);
  codebooks::Query(book).batch(corners, coarse);
  Eigen::VectorXd change(book.output_count());
  for (Eigen::Index o = 0; o < change.size(); ++o) {
    const double range = std::abs(coarse(o, 0) - coarse(o, 1));
    const double scale = std::max(range, floor_of(book.outputs()[static_cast<std::size_t>(o)].name));
    change(o) = (fine.row(o) - coarse.row(o)).cwiseAbs().maxCoeff() / scale;
  }
  return change;
}

codebooks::Codebook with_discretisation(const codebooks::Codebook& book, const Eigen::VectorXd& change) {
  codebooks::BuildRecord record = book.build();
  record.message += "; twice the cells change, as shares of the range between both ends of the box,";
  for (Eigen::Index o = 0; o < change.size(); ++o)
    record.message += fmt::format("{} {} by {:.3g}", o == 0 ? "" : ",",
                                  book.outputs()[static_cast<std::size_t>(o)].name, change(o));
  codebooks::Codebook said(book.model(), book.pieces(), std::move(record), book.provenance(),
                           book.certificate(), book.title());
  return book.mesh() == nullptr ? said : said.with_mesh(*book.mesh());
}

}  // namespace samara::flow
