#pragma once

#include <optional>

#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/certify/certify_field.h"
#include "samara/pgd/linear/enrichment.h"
#include "samara/pgd/linear/parametric_problem.h"

/// From the separated solution of a linear problem to a certified codebook that is saved, opened and queried like
/// any other: space, boundary and initial values are coordinates.
///
///   const EnrichResult result = enrich(heat.assemble(), options);
///   FieldRequest request{.output = {"u", "K"}};
///   request.problem.name = "wall";
///   request.certify.tolerance = 1e-3;
///   save(make_codebook(heat, result, request), "wall.h5");
namespace samara::codebooks {

struct FieldRequest {
  pgd::OutputLabel output = {};        ///< what the solution is
  ModelDescription problem = {};       ///< for readers: name (that of no model), title, equations, source
  std::optional<SpaceMesh> mesh = {};  ///< where the nodes of an imported axis are
  std::optional<FieldReference> reference = {};  ///< empty: direct_reference(problem)
  CertifyOptions certify = {};
};

/// The codebook of a solution: time first, the other axes in the order of the problem.
/// Its certificate is met if the enrichment came to its end and no error is beyond the tolerance.
/// @param result of enrich(problem.assemble(), ..)
/// @throws ArgumentError if the solution is not one of the problem, the name is empty or that of a model, the
/// problem has no axis of space or more than one, or as direct_reference(), certify() and Codebook::with_mesh()
Codebook make_codebook(const pgd::ParametricProblem& problem, const pgd::EnrichResult& result,
                       const FieldRequest& request);

/// The solution as the one field group of a codebook.
/// @param unknown of the assembled problem
Piece field_piece(const pgd::ParametricProblem& problem, const pgd::SeparatedTensor& unknown,
                  const pgd::OutputLabel& output);

/// How an enrichment went, as builds say it.
BuildRecord enrichment_record(const pgd::EnrichResult& result);

}  // namespace samara::codebooks
