#include "samara/codebooks/fields/field_codebook.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/provenance.h"
#include "samara/codebooks/fields/direct_reference.h"
#include "samara/models/fields/field_model.h"
#include "samara/models/laws/registry.h"

namespace samara::codebooks {

namespace {

/// Root mean square of its largest term.
double size_of_field(const pgd::SeparatedField& field) {
  const double size = field.rank() == 0 ? 0.0 : field.weights().cwiseAbs().maxCoeff();
  return size > 0.0 ? size : 1.0;
}

void check_problem_name(const std::string& name) {
  if (name.empty() || name == kCommandModel || models::find_model_or_null(name) ||
      models::find_field_model(name) != nullptr) {
    throw ArgumentError(
        fmt::format("the problem has the name \"{}\", expected one that no model has, and not empty", name));
  }
}

}  // namespace

Piece field_piece(const pgd::ParametricProblem& problem, const pgd::SeparatedTensor& unknown,
                  const pgd::OutputLabel& output) {
  pgd::SeparatedTensor whole = problem.complete(unknown);
  std::vector<pgd::Axis> axes = problem.axes();
  const auto time = std::ranges::find(axes, pgd::AxisRole::time, &pgd::Axis::role) - axes.begin();
  if (time < std::ssize(axes)) {
    std::rotate(axes.begin(), axes.begin() + time, axes.begin() + time + 1);
    std::rotate(whole.factors.begin(), whole.factors.begin() + time, whole.factors.begin() + time + 1);
  }
  return Piece::Groups{
      pgd::SeparatedField(std::move(axes), {output}, std::move(whole.factors), whole.weights.transpose())};
}

BuildRecord enrichment_record(const pgd::EnrichResult& result) {
  BuildRecord record;
  record.builder = "pgd";
  record.strategy = "enrichment";
  record.status = result.termination;
  record.message = result.message;
  for (const pgd::TermRecord& term : result.history)
    record.iterations = std::max(record.iterations, term.fixed_point_iterations);
  record.rounds = 1;
  return record;
}

Codebook make_codebook(const pgd::ParametricProblem& problem, const pgd::EnrichResult& result,
                       const FieldRequest& request) {
  check_problem_name(request.problem.name);
  if (std::ranges::count(problem.axes(), pgd::AxisRole::space, &pgd::Axis::role) != 1)
    throw ArgumentError("the problem has no axis of space, or several; a field over one was expected");
  Piece piece = field_piece(problem, result.solution, request.output);
  const double scale = size_of_field(*piece.groups().front().sum());
  Codebook book(request.problem, {std::move(piece)}, enrichment_record(result), made_now({}, result.seconds));
  if (request.mesh) book = book.with_mesh(*request.mesh);
  const FieldReference reference = request.reference ? *request.reference : direct_reference(problem, scale);
  Certificate certificate = certify(book, reference, request.certify);
  certificate.met = certificate.met && book.build().status == Termination::converged;
  return book.with_certificate(std::move(certificate));
}

}  // namespace samara::codebooks
