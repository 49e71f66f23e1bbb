#include "built.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "samara/base/errors.h"

namespace samara::benchmarks {

namespace {

int rank_of(const codebooks::FieldGroup& group) {
  if (const pgd::TrainField* train = group.train()) {
    int largest = 0;
    for (const int rank : train->train().ranks()) largest = std::max(largest, rank);
    return largest;
  }
  return group.sum()->rank();
}

}  // namespace

Built build_and_measure(const codebooks::Plan& plan, int certificate_points) {
  Built built;
  try {
    codebooks::BuildOptions options;
    options.certificate_points = certificate_points;
    const codebooks::BuildResult result = codebooks::build(plan, options);
    const codebooks::Codebook& book = result.book;
    built.certificate_max = book.certificate()->max_error;
    built.reached = book.coordinates().front().upper / plan.end;
    built.time = book.provenance().build_seconds;
    built.evaluation_fraction = book.build().evaluations / book.build().grid_size;
    built.met = result.met;
    built.status = to_string(book.build().status);
    built.message = book.build().message;
    std::set<std::vector<double>> corners;
    double nodes = 0.0, nodes_14 = 0.0;
    for (const codebooks::Piece& piece : book.pieces()) {
      std::vector<double> corner;
      double own = 1.0, of_14 = 1.0;
      for (std::size_t k = 1; k < piece.groups().front().axes().size(); ++k) {
        const pgd::Axis& axis = piece.groups().front().axes()[k];
        corner.push_back(axis.lower());
        own *= axis.size();
        of_14 *= 14.0;
      }
      corners.insert(corner);
      nodes += own;
      nodes_14 += of_14;
      for (const codebooks::FieldGroup& group : piece.groups())
        built.rank = std::max(built.rank, rank_of(group));
    }
    built.evaluation_fraction_14 = built.evaluation_fraction * nodes / nodes_14;
    built.cells = static_cast<int>(corners.size());
  } catch (const Error& error) {
    built.certificate_max = std::nan("");
    built.status = "no_result";
    built.message = error.what();
  }
  return built;
}

}  // namespace samara::benchmarks
