#include "samara/flow/books/field_flow.h"

#include <limits>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/base/errors.h"
#include "samara/codebooks/query/query.h"
#include "samara/flow/books/cell_mesh.h"
#include "samara/flow/books/planned_flow.h"

namespace samara::flow {

bool is_field_book(const codebooks::Codebook& book) {
  return book.model().name == kFieldBookModel;
}

StoredFlow flow_of(const codebooks::Codebook& book, const std::map<std::string, double>& at,
                   const std::string& path, const MeshReader& mesh_reader) {
  if (!is_field_book(book))
    throw ArgumentError(
        fmt::format("{} is no codebook of the fields of a flow ([book] kind = \"fields\")", path));
  const FlowPlan plan = parse_flow_plan(book.provenance().plan, path, mesh_reader);
  // Books of earlier versions do not say which mesh it was.
  if (const std::string& source = book.model().source; source != kPlanSource && source != book_source(plan))
    throw InputError(path, "holds flows about another mesh than that of the file which its plan names");
  if (book.space() != 0)
    throw InputError(path, "has no places as its first coordinate, expected those of a flow");
  std::vector<double> point;
  for (const codebooks::Coordinate& coordinate : book.parameters()) {
    if (coordinate.role == pgd::AxisRole::space) continue;
    const auto given = at.find(coordinate.name);
    if (given == at.end())
      throw ArgumentError(fmt::format("{} needs a value of {}, from {:.6g} to {:.6g}", path, coordinate.name,
                                      coordinate.lower, coordinate.upper));
    point.push_back(given->second);
  }
  for (const auto& [name, value] : at) {
    const auto index = static_cast<std::size_t>(book.coordinate_index(name));
    if (book.coordinates()[index].role == pgd::AxisRole::space)
      throw ArgumentError(fmt::format("{} has its flows at every {}: expected no value of it", path, name));
  }
  std::vector<std::string> names, expected;
  for (const codebooks::Coordinate& coordinate : std::span(book.coordinates()).subspan(1))
    names.push_back(coordinate.name);
  for (const codebooks::BoxEntry& entry : plan.box) expected.push_back(entry.name);
  if (names != expected)
    throw InputError(path,
                     fmt::format("has the coordinates {} beside its places, expected {}, the box of its plan",
                                 fmt::join(names, ", "), fmt::join(expected, ", ")));
  try {
    // As the builder did: a damaged plan may ask for more cells than an integer counts.
    check_case(flow_case_at(plan, corners_of(plan).first), plan.max_memory);
  } catch (const ArgumentError& error) {
    throw InputError(path, error.what());
  }
  const FlowCase flow = flow_case_at(plan, point);
  StoredFlow stored(grid_of(flow));
  const Eigen::Index nodes = stored.grid.cell_count();
  if (book.mesh() == nullptr || book.mesh()->node_count() != nodes)
    throw InputError(path, "holds fields on another grid than that of its plan");
  stored.open = open_cells(flow, stored.grid);
  FlowSummary& s = stored.summary;
  s.status = "of a codebook";
  s.title = book.title();
  s.plan = book.provenance().plan;
  s.generator = book.provenance().generator;
  s.reynolds = flow.reynolds;
  s.angle_of_attack = flow.angle_of_attack;
  s.intensity = flow.intensity;
  s.drag = s.lift = s.moment = s.drag_rms = s.lift_rms = s.strouhal = s.bubble_end =
      std::numeric_limits<double>::quiet_NaN();
  codebooks::Query query(book);
  Eigen::MatrixXd asked(book.coordinate_count(), nodes), answers(book.output_count(), nodes);
  asked.row(0) = Eigen::RowVectorXd::LinSpaced(nodes, 0.0, static_cast<double>(nodes - 1));
  for (std::size_t k = 0; k < point.size(); ++k)
    asked.row(static_cast<Eigen::Index>(k) + 1).setConstant(point[k]);
  query.batch(asked, answers);
  for (Eigen::Index o = 0; o < book.output_count(); ++o) {
    const std::string& name = book.outputs()[static_cast<std::size_t>(o)].name;
    const bool logarithm = name.starts_with("log10_");
    const std::string plain = logarithm ? name.substr(6) : name;
    const char* unit = plain == "p" ? "rho U^2" : plain == "k" ? "U^2" : plain == "epsilon" ? "U^3/l" : "U";
    Eigen::VectorXd values = answers.row(o).transpose();
    if (logarithm) values = Eigen::pow(10.0, values.array());
    stored.fields.push_back({plain, unit, field_in_order(stored.grid, values)});
  }
  return stored;
}

}  // namespace samara::flow
