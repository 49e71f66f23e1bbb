#include "samara/flow/books/field_book.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/codebooks/book/certificate_points.h"
#include "samara/codebooks/book/provenance.h"
#include "samara/codebooks/build/sampling_builder.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/certify/point_errors.h"
#include "samara/codebooks/query/query.h"
#include "samara/flow/books/cell_mesh.h"
#include "samara/flow/books/field_flow.h"
#include "samara/flow/books/leja_grid.h"
#include "samara/flow/books/planned_flow.h"
#include "samara/pgd/fields/train_field.h"

namespace samara::flow {

namespace {

/// Of all places at a point, which the tolerance is asked of.
constexpr double kShareOfPlaces = 0.95;
/// Of the tolerance: what truncated modes may differ by.
constexpr double kTruncated = 0.05;

/// Differences below these do not matter, whatever an output's range.
double field_floor(const std::string& output) {
  return output == "k" ? 0.01 : 0.1;
}

codebooks::Plan plan_of_book(const FlowPlan& plan) {
  codebooks::Plan book;
  book.title = plan.title;
  book.text = checkpointed_text(plan);
  book.box = plan.box;
  book.relative = plan.relative;
  book.builder.kind = "sampling";
  book.builder.seed = plan.seed;
  for (const pgd::OutputLabel& output : field_outputs(plan.flow))
    book.absolute[output.name] = field_floor(output.name);
  return book;
}

/// All outputs in all cells: outputs x nodes.
Eigen::MatrixXd fields_of(const FlowResult& result, const FlowCase& flow) {
  const std::vector<CentreField> centres = centre_fields(result);
  const auto field = [&](const std::string& name) -> const Field& {
    return std::ranges::find(centres, name, &CentreField::name)->values;
  };
  const std::vector<pgd::OutputLabel> outputs = field_outputs(flow);
  Eigen::MatrixXd values(static_cast<Eigen::Index>(outputs.size()), result.grid.cell_count());
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const std::string& name = outputs[o].name;
    const bool logarithm = name.starts_with("log10_");
    Field chosen = field(logarithm ? name.substr(6) : name);
    if (logarithm || name == "p") continue_into_body(result.grid, result.body, chosen);
    if (logarithm) {
      for (double& value : chosen) value = std::log10(value);
    }
    values.row(static_cast<Eigen::Index>(o)) = cells_in_order(result.grid, chosen).transpose();
  }
  return values;
}

/// That a share of the numbers are at most.
double quantile(Eigen::VectorXd values, double share) {
  const auto place = static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(values.size()))) - 1;
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[place];
}

/// Errors of two answers (outputs x places) by output, over the scales: what a share of the places keep below.
Eigen::VectorXd place_errors(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::VectorXd errors(a.rows());
  for (Eigen::Index o = 0; o < a.rows(); ++o)
    errors[o] = quantile((a.row(o) - b.row(o)).cwiseAbs().transpose(), kShareOfPlaces);
  return errors;
}

/// A build on its way.
class FieldBuilder {
 public:
  FieldBuilder(const FlowPlan& plan, const codebooks::BuildOptions& options)
      : plan_(plan),
        book_plan_(plan_of_book(plan)),
        options_(options),
        outputs_(field_outputs(plan.flow)),
        nodes_(Eigen::VectorXd::LinSpaced(grid_of(plan.flow).cell_count(), 0.0,
                                          static_cast<double>(grid_of(plan.flow).cell_count() - 1))),
        calls_(codebooks::calls_of(book_plan_, source(), options)),
        grid_(plan.box.size()) {}

  codebooks::BuildResult run() {
    const auto begin = std::chrono::steady_clock::now();
    growth_ = grown();
    codebooks::BuildRecord record = record_of();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    codebooks::Codebook book(description(), {codebooks::Piece(groups())}, record,
                             codebooks::made_now(plan_.text, took.count()), {}, plan_.title);
    book = book.with_mesh(cell_mesh(grid_of(plan_.flow)));
    codebooks::Certificate certificate = certify(book);
    certificate.met = certificate.met && growth_.status == Termination::converged;
    const bool met = certificate.met, incomplete = certificate.failed_points > 0;
    const int compared = certificate.points - certificate.failed_points;
    std::string message = record.message;
    if (compared > 0) {
      message += fmt::format("; {:.0f} % of all places are within {:.3g} at {} points, tolerance {:.3g}",
                             100.0 * kShareOfPlaces, certificate.max_error, compared, certificate.tolerance);
    }
    if (incomplete) {
      message += fmt::format("; {} of {} points of the certificate have no flow: {}",
                             certificate.failed_points, certificate.points, certificate.failure);
    }
    return {book.with_certificate(std::move(certificate)), met, message, incomplete};
  }

  /// outputs x nodes. @throws NoResultError where there is no flow
  Eigen::MatrixXd fields_at(const std::vector<double>& point) {
    const Eigen::Map<const Eigen::VectorXd> column(point.data(), static_cast<Eigen::Index>(point.size()));
    const codebooks::CalledAnswers answer = calls_(column, {nodes_.begin(), nodes_.end()});
    calls_.save();
    if (!answer.failure.empty()) throw NoResultError(answer.failure);
    return answer.values.reshaped(std::ssize(outputs_), nodes_.size());
  }

 private:
  codebooks::SampledSource source() {
    codebooks::SampledSource source;
    for (const codebooks::BoxEntry& entry : plan_.box)
      source.coordinates.push_back({entry.name, entry.name == "angle_of_attack" ? "rad" : "1"});
    source.outputs = outputs_;
    source.answers_name = "flow";
    // The nodes stand where a trajectory has its times.
    source.time_unit = "1";
    source.answers = [this](const Eigen::MatrixXd& points, const std::vector<double>&) {
      codebooks::SampledAnswers answers;
      answers.values.resize(nodes_.size() * std::ssize(outputs_), points.cols());
      for (Eigen::Index j = 0; j < points.cols(); ++j) {
        const std::vector<double> point(points.col(j).begin(), points.col(j).end());
        try {
          const FlowResult result = solve_at(plan_, point, options_.progress, options_.warning);
          answers.values.col(j) = fields_of(result, flow_case_at(plan_, point)).reshaped();
        } catch (const NoResultError& error) {
          answers.failure = error.what();
          answers.values.conservativeResize(Eigen::NoChange, j);
          break;
        }
      }
      return answers;
    };
    return source;
  }

  std::vector<double> in_box(const std::vector<double>& unit) const {
    std::vector<double> point;
    for (std::size_t k = 0; k < unit.size(); ++k)
      point.push_back(in_interval(plan_.box[k].lower, plan_.box[k].upper, unit[k]));
    return point;
  }

  Eigen::VectorXd scales() const {
    Eigen::VectorXd lowest, highest;
    for (const auto& [numbers, column] : grid_.columns()) {
      const auto fields = column.reshaped(std::ssize(outputs_), nodes_.size());
      const Eigen::VectorXd low = fields.rowwise().minCoeff(), high = fields.rowwise().maxCoeff();
      lowest = lowest.size() == 0 ? low : lowest.cwiseMin(low).eval();
      highest = highest.size() == 0 ? high : highest.cwiseMax(high).eval();
    }
    Eigen::VectorXd scales = highest - lowest;
    for (Eigen::Index o = 0; o < scales.size(); ++o)
      scales[o] = std::max(scales[o], field_floor(outputs_[static_cast<std::size_t>(o)].name));
    return scales;
  }

  GridGrowth grown() {
    const auto solve = [&](const std::vector<double>& unit) -> Eigen::VectorXd {
      return fields_at(in_box(unit)).reshaped();
    };
    const auto apart = [&](const Eigen::VectorXd& foretold, const Eigen::VectorXd& found) {
      const auto fields = [&](const Eigen::VectorXd& column) {
        return Eigen::MatrixXd(column.reshaped(std::ssize(outputs_), nodes_.size()));
      };
      return place_errors(fields(foretold), fields(found)).cwiseQuotient(scales()).maxCoeff();
    };
    return grow(grid_, solve, apart, kForetold * plan_.relative, plan_.max_calls);
  }

  codebooks::BuildRecord record_of() const {
    codebooks::BuildRecord record;
    record.builder = "sampling";
    record.strategy = "modes";
    record.status = growth_.status;
    record.evaluations =
        static_cast<double>(growth_.solved + options_.certificate_points.value_or(plan_.certificate_points));
    record.grid_size = static_cast<double>(grid_.size());
    record.rounds = 1;
    record.message = growth_.text(grid_, plan_.max_calls);
    return record;
  }

  codebooks::ModelDescription description() const {
    codebooks::ModelDescription model;
    model.name = kFieldBookModel;
    model.title = "mean fields of the flow about a body";
    model.equations = "those of samara flow (docs/flow.md)";
    model.frames = "x along the stream, y up, from the body's centre, in body lengths";
    model.source = book_source(plan_);
    const auto is_free = [&](const char* name) {
      return std::ranges::count(plan_.box, name, &codebooks::BoxEntry::name) > 0;
    };
    if (!is_free("angle_of_attack")) {
      model.fixed["angle_of_attack"] = plan_.flow.angle_of_attack;
      model.fixed_units["angle_of_attack"] = "rad";
    }
    if (!is_free("log10_reynolds")) {
      model.fixed["log10_reynolds"] = std::log10(plan_.flow.reynolds);
      model.fixed_units["log10_reynolds"] = "1";
    }
    return model;
  }

  /// Every output by itself: its modes, of which those are left out that matter less than the tolerance.
  codebooks::Piece::Groups groups() const {
    std::vector<pgd::Axis> axes = {cell_axis(grid_of(plan_.flow))};
    for (std::size_t k = 0; k < plan_.box.size(); ++k) {
      const codebooks::BoxEntry& entry = plan_.box[k];
      axes.push_back(pgd::Axis::chebyshev({entry.name, entry.name == "angle_of_attack" ? "rad" : "1"},
                                          entry.lower, entry.upper, grid_.counts()[k]));
    }
    const Eigen::MatrixXd snapshots = grid_.on_chebyshev_points();  // (outputs nodes) x grid
    const Eigen::VectorXd scale = scales();
    codebooks::Piece::Groups groups;
    for (Eigen::Index o = 0; o < std::ssize(outputs_); ++o) {
      const Eigen::MatrixXd values =
          snapshots(Eigen::seqN(o, nodes_.size(), std::ssize(outputs_)), Eigen::all);
      const double allowed =
          kTruncated * plan_.relative * scale[o] * std::sqrt(static_cast<double>(values.size()));
      pgd::TensorTrain train = pgd::to_train(values, grid_.counts(), allowed);
      pgd::TrainCore one(1, 1, 1);
      one.data.setOnes();
      train.cores.insert(train.cores.begin(), std::move(one));
      groups.emplace_back(pgd::TrainField(axes, {outputs_[static_cast<std::size_t>(o)]}, std::move(train)));
    }
    return groups;
  }

  codebooks::Certificate certify(const codebooks::Codebook& book) {
    codebooks::CertifyOptions certify;
    certify.points = options_.certificate_points.value_or(plan_.certificate_points);
    certify.seed = book_plan_.certificate_seed();
    certify.tolerance = plan_.relative;
    certify.absolute = book_plan_.absolute;
    codebooks::ComparedPoints points{codebooks::certificate_points(book, certify.points, certify.seed), {}};
    codebooks::Query query(book);
    Eigen::MatrixXd asked(book.coordinate_count(), nodes_.size()),
        answers(book.output_count(), nodes_.size());
    asked.row(0) = nodes_.transpose();
    std::vector<Anywhere> anywhere(outputs_.size());
    for (Eigen::Index i = 0; i < points.q.cols(); ++i) {
      const std::vector<double> point(points.q.col(i).begin() + 1, points.q.col(i).end());
      Eigen::MatrixXd found;
      try {
        found = fields_at(point);
      } catch (const NoResultError& error) {
        // Of a book that misses its tolerance anyway no more flows are solved: later points count as failed, too.
        points.errors.emplace_back().failure = error.what();
        break;
      }
      for (std::size_t k = 0; k < point.size(); ++k)
        asked.row(static_cast<Eigen::Index>(k) + 1).setConstant(point[k]);
      query.batch(asked, answers);
      codebooks::PointErrors errors = codebooks::compared_rows(answers.transpose(), found.transpose());
      for (std::size_t o = 0; o < outputs_.size(); ++o)
        anywhere[o].take(errors.max_error[static_cast<Eigen::Index>(o)], errors.worst_time[o], point);
      errors.max_error = place_errors(answers, found);
      points.errors.push_back(std::move(errors));
    }
    codebooks::Certificate certificate = codebooks::certificate_of(points, {}, book, certify, {});
    certificate.places = static_cast<int>(nodes_.size());
    certificate.integrator = fmt::format(
        "flows that the builder did not see, on the same grid; an error is what {:.0f} % of the places at a "
        "point keep below",
        100.0 * kShareOfPlaces);
    if (certificate.failed_points == certificate.points) return certificate;
    certificate.integrator += "; the largest anywhere, over the range, are";
    for (std::size_t o = 0; o < outputs_.size(); ++o) {
      codebooks::OutputError& output = certificate.outputs[o];
      certificate.integrator +=
          fmt::format("{} {} {:.3g}", o == 0 ? "" : ",", output.name, anywhere[o].error / output.range);
      output.worst = anywhere[o].where;
    }
    return certificate;
  }

  /// The largest error of an output, and where it is.
  struct Anywhere {
    double error = -1.0;
    std::vector<double> where;

    void take(double candidate, int node, const std::vector<double>& point) {
      if (candidate <= error) return;
      error = candidate;
      where = {static_cast<double>(node)};
      where.insert(where.end(), point.begin(), point.end());
    }
  };

  const FlowPlan& plan_;
  codebooks::Plan book_plan_;
  const codebooks::BuildOptions& options_;
  std::vector<pgd::OutputLabel> outputs_;
  Eigen::VectorXd nodes_;
  codebooks::CallMemory calls_;
  LejaGrid grid_;
  GridGrowth growth_;
};

/// Means of a finer grid of half the spacing over the cells of a coarser one, by nodes.
Eigen::VectorXd coarsened(const MacGrid& coarse, const MacGrid& fine, const Eigen::VectorXd& values) {
  Eigen::VectorXd means = Eigen::VectorXd::Zero(coarse.cell_count());
  const auto node = [](const MacGrid& grid, int i, int j, int k) {
    return i + Eigen::Index{grid.cells[0]} * (j + Eigen::Index{grid.cells[1]} * k);
  };
  const bool in_space = coarse.dimensions == 3;
  for (std::size_t d = 0; d < (in_space ? 3U : 2U); ++d)
    require(fine.cells[d] == 2 * coarse.cells[d], "cells", fine.cells[d],
            fmt::format("{}, twice those of the coarser grid", 2 * coarse.cells[d]), "a finer flow");
  const double share = in_space ? 0.125 : 0.25;
  for (int k = 0; k < fine.cells[2]; ++k) {
    for (int j = 0; j < fine.cells[1]; ++j) {
      for (int i = 0; i < fine.cells[0]; ++i)
        means[node(coarse, i / 2, j / 2, in_space ? k / 2 : 0)] += share * values[node(fine, i, j, k)];
    }
  }
  return means;
}

}  // namespace

std::vector<pgd::OutputLabel> field_outputs(const FlowCase& flow) {
  std::vector<pgd::OutputLabel> outputs = {{"u"}, {"v"}};
  if (flow.shape.dimensions == 3) outputs.push_back({"w"});
  outputs.push_back({"p"});
  if (flow.turbulence == TurbulenceModel::none) {
    outputs.push_back({"k"});
  } else {
    outputs.push_back({"log10_k"});
    outputs.push_back({"log10_epsilon"});
  }
  return outputs;
}

codebooks::BuildResult build_field_book(const FlowPlan& plan, const codebooks::BuildOptions& options) {
  check_book(plan);
  return run_build(options,
                   [&](const codebooks::BuildOptions& guarded) { return FieldBuilder(plan, guarded).run(); });
}

Eigen::VectorXd field_discretisation(const FlowPlan& plan, const codebooks::Codebook& book,
                                     const codebooks::BuildOptions& options) {
  const FlowPlan finer = finer_plan(plan);
  codebooks::BuildOptions finer_options = options;
  finer_options.checkpoint = finer_checkpoint(options.checkpoint);
  FieldBuilder finer_flows(finer, finer_options);
  const MacGrid coarse_grid = grid_of(plan.flow), fine_grid = grid_of(finer.flow);
  const Eigen::Index nodes = coarse_grid.cell_count();
  codebooks::Query query(book);
  Eigen::MatrixXd asked(book.coordinate_count(), nodes);
  asked.row(0) = Eigen::RowVectorXd::LinSpaced(nodes, 0.0, static_cast<double>(nodes - 1));
  std::vector<Eigen::MatrixXd> coarse, fine;
  const auto [lower, upper] = corners_of(plan);
  for (const auto& corner : {lower, upper}) {
    for (std::size_t k = 0; k < corner.size(); ++k)
      asked.row(static_cast<Eigen::Index>(k) + 1).setConstant(corner[k]);
    coarse.emplace_back(book.output_count(), nodes);
    query.batch(asked, coarse.back());
    const Eigen::MatrixXd found = finer_flows.fields_at(corner);
    Eigen::MatrixXd& mean = fine.emplace_back(found.rows(), nodes);
    for (Eigen::Index o = 0; o < found.rows(); ++o)
      mean.row(o) = coarsened(coarse_grid, fine_grid, found.row(o).transpose()).transpose();
  }
  Eigen::VectorXd change(book.output_count());
  for (Eigen::Index o = 0; o < change.size(); ++o) {
    const double low = std::min(coarse[0].row(o).minCoeff(), coarse[1].row(o).minCoeff());
    const double high = std::max(coarse[0].row(o).maxCoeff(), coarse[1].row(o).maxCoeff());
    const double scale = std::max(high - low, field_floor(book.outputs()[static_cast<std::size_t>(o)].name));
    const auto rms = [&](std::size_t end) {
      return std::sqrt((fine[end].row(o) - coarse[end].row(o)).squaredNorm() / static_cast<double>(nodes));
    };
    change[o] = std::max(rms(0), rms(1)) / scale;
  }
  return change;
}

}  // namespace samara::flow
