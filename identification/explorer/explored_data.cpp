#include "samara/identification/explorer/explored_data.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/attitude_length.h"
#include "samara/codebooks/certify/builder_end.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/figures/book_figures.h"
#include "samara/models/bodies/body_pose.h"
#include "samara/models/bodies/shown_body.h"

namespace samara::identification {

namespace {

using Json = nlohmann::ordered_json;
using codebooks::Codebook;

std::vector<double> list_of(const Eigen::VectorXd& values) {
  return {values.begin(), values.end()};
}

Json axis_json(const pgd::Axis& axis) {
  Json json = {{"basis", to_string(axis.basis())},
               {"transform", to_string(axis.transform())},
               {"lower", axis.lower()},
               {"upper", axis.upper()},
               {"nodes", list_of(axis.nodes())}};
  if (axis.has_elements()) {
    json["borders"] = list_of(axis.borders());
    json["reference"] = list_of(axis.element_basis().nodes());
  }
  return json;
}

/// Rows of the wanted outputs of a group, and their places among all that are wanted.
struct GroupChoice {
  std::vector<Eigen::Index> rows;
  std::vector<int> places;
};

GroupChoice choice_of(const std::vector<pgd::OutputLabel>& labels, const Codebook& book,
                      const std::vector<int>& outputs) {
  GroupChoice choice;
  for (std::size_t row = 0; row < labels.size(); ++row) {
    const auto found = std::ranges::find_if(
        outputs, [&](int o) { return book.outputs()[static_cast<std::size_t>(o)].name == labels[row].name; });
    if (found == outputs.end()) continue;
    choice.rows.push_back(static_cast<Eigen::Index>(row));
    choice.places.push_back(static_cast<int>(found - outputs.begin()));
  }
  return choice;
}

Json sum_json(const pgd::SeparatedField& sum, const GroupChoice& choice, NumberStore& numbers) {
  const Eigen::MatrixXd weights = sum.weights()(choice.rows, Eigen::all);
  Json json = {{"outputs", choice.places},
               {"terms", sum.rank()},
               {"weights", numbers.put(weights.data(), weights.size())},
               {"factors", Json::array()},
               {"sizes", Json::array()}};
  for (const Eigen::MatrixXd& factor : sum.factors()) {
    json["factors"].push_back(numbers.put(factor.data(), factor.size()));
    json["sizes"].push_back(factor.rows());
  }
  return json;
}

Json train_json(const pgd::TrainField& field, const GroupChoice& choice, NumberStore& numbers) {
  Json json = {{"outputs", choice.places}, {"cores", Json::array()}};
  for (const pgd::TrainCore& core : field.train().cores) {
    const bool is_first = json["cores"].empty();
    const Eigen::MatrixXd rows =
        is_first ? core.left_unfolding()(choice.rows, Eigen::all) : Eigen::MatrixXd();
    json["cores"].push_back({{"left", core.left},
                             {"size", is_first ? static_cast<int>(rows.rows()) : core.size},
                             {"right", core.right},
                             {"data", is_first ? numbers.put(rows.data(), rows.size())
                                               : numbers.put(core.data.data(), core.data.size())}});
  }
  return json;
}

Json piece_json(const codebooks::Piece& piece, const Codebook& book, const std::vector<int>& outputs,
                NumberStore& numbers) {
  Json json = {
      {"lower", piece.lower()}, {"upper", piece.upper()}, {"axes", Json::array()}, {"groups", Json::array()}};
  for (const pgd::Axis& axis : piece.groups().front().axes()) json["axes"].push_back(axis_json(axis));
  for (const codebooks::FieldGroup& group : piece.groups()) {
    const GroupChoice choice = choice_of(group.outputs(), book, outputs);
    if (choice.rows.empty()) continue;
    json["groups"].push_back(group.sum() != nullptr ? sum_json(*group.sum(), choice, numbers)
                                                    : train_json(*group.train(), choice, numbers));
  }
  return json;
}

Json certificate_json(const Codebook& book, const std::vector<int>& outputs) {
  if (!book.certificate()) return nullptr;
  const codebooks::Certificate& c = *book.certificate();
  Json json = {{"met", c.met},
               {"verdict", codebooks::verdict(book.build(), c)},
               {"tolerance", c.tolerance},
               {"max", c.max_error},
               {"points", c.points},
               {"times", c.times},
               {"failed", c.failed_points},
               {"integrator", c.integrator},
               {"outputs", Json::array()}};
  for (const int o : outputs) {
    const auto& label = book.outputs()[static_cast<std::size_t>(o)];
    const auto error = std::ranges::find(c.outputs, label.name, &codebooks::OutputError::name);
    if (error == c.outputs.end()) {
      json["outputs"].push_back(nullptr);
      continue;
    }
    json["outputs"].push_back({{"range", error->range},
                               {"max", error->max},
                               {"p95", error->p95},
                               {"max_si", error->max_si},
                               {"worst", error->worst}});
  }
  return json;
}

/// Places of the model's pose among the wanted outputs.
Json pose_json(const Codebook& book, const std::vector<int>& outputs) {
  const auto model = codebooks::known_model(book.model());
  if (!model) return nullptr;
  const auto states = models::pose_states_of(model->info());
  if (!states) return nullptr;
  static constexpr const char* kKinds[] = {"line", "plane", "point", "space"};
  Json json = {{"kind", kKinds[static_cast<int>(states->kind)]},
               {"unit", states->unit},
               {"downward", states->is_downward},
               {"places", Json::array()}};
  for (const std::string& name : states->names) {
    const auto found = std::ranges::find_if(
        outputs, [&](int o) { return book.outputs()[static_cast<std::size_t>(o)].name == name; });
    if (found == outputs.end()) return nullptr;
    json["places"].push_back(found - outputs.begin());
  }
  return json;
}

/// Of the model at a point, where its parameters say it.
std::optional<models::TriangleMesh> body_of(const Codebook& book, const Eigen::VectorXd& q) {
  if (!codebooks::known_model(book.model())) return std::nullopt;
  try {
    return models::shown_body(codebooks::model_of(book), {q.data(), static_cast<std::size_t>(q.size())});
  } catch (const ArgumentError&) {
    return std::nullopt;  // it leaves out what its model needs
  }
}

/// Coordinates that change the body.
std::vector<std::string> shape_of(const Codebook& book, const models::TriangleMesh& body) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < book.parameters().size(); ++k) {
    Eigen::VectorXd q = codebooks::middle_of_box(book);
    q[static_cast<Eigen::Index>(k)] = book.parameters()[k].upper;
    const auto other = body_of(book, q);
    if (!other || other->vertices.cols() != body.vertices.cols() || other->vertices != body.vertices)
      names.push_back(book.parameters()[k].name);
  }
  return names;
}

Json body_json(const models::TriangleMesh& mesh, NumberStore& numbers) {
  return {
      {"vertices", numbers.put(mesh.vertices.data(), mesh.vertices.size())},
      {"triangles", std::vector<int>(mesh.triangles.data(), mesh.triangles.data() + mesh.triangles.size())}};
}

}  // namespace

nlohmann::ordered_json NumberStore::put(const double* values, Eigen::Index count) {
  const Json place = {values_.size(), count};
  values_.insert(values_.end(), values, values + count);
  return place;
}

std::vector<int> outputs_to_show(const Codebook& book, const std::vector<std::string>& wanted) {
  std::vector<int> outputs;
  for (int o = 0; o < book.output_count(); ++o) {
    const std::string& name = book.outputs()[static_cast<std::size_t>(o)].name;
    if (wanted.empty() || std::ranges::count(wanted, name) > 0) outputs.push_back(o);
  }
  // The numbers of a quaternion have a length together.
  std::vector<int> all(static_cast<std::size_t>(book.output_count()));
  std::iota(all.begin(), all.end(), 0);
  const auto attitude = codebooks::quaternion_places(book, all);
  const auto is_wanted = [&](int place) { return std::ranges::count(outputs, place) > 0; };
  if (attitude && std::ranges::any_of(*attitude, is_wanted)) {
    outputs.insert(outputs.end(), attitude->begin(), attitude->end());
    std::ranges::sort(outputs);
    outputs.erase(std::unique(outputs.begin(), outputs.end()), outputs.end());
  }
  return outputs;
}

double factor_bytes(const Codebook& book, const std::vector<int>& outputs) {
  double numbers = 0.0;
  for (const codebooks::Piece& piece : book.pieces()) {
    for (const codebooks::GroupOutline& group : piece.outline().groups) {
      const auto wanted = std::ssize(choice_of(group.outputs, book, outputs).rows);
      if (wanted == 0) continue;
      const int rank = group.ranks.empty() ? 0 : group.ranks.front();
      numbers += static_cast<double>(group.entries) -
                 static_cast<double>(rank) * static_cast<double>(std::ssize(group.outputs) - wanted);
    }
  }
  return 8.0 * numbers;
}

nlohmann::ordered_json explored_book(const ExploredBook& explored, const std::vector<int>& outputs,
                                     const std::optional<models::TriangleMesh>& body, NumberStore& numbers) {
  const Codebook& book = explored.book;
  if (const codebooks::FrontMap* front = book.front()) {
    throw ArgumentError(fmt::format(
        "{}: \"{}\" is counted from a front in this codebook, which the explorer cannot follow; a "
        "codebook of a box without one was expected",
        explored.file, book.coordinates()[static_cast<std::size_t>(front->coordinate())].name));
  }
  Json json = {{"file", explored.file},
               {"model", book.model().name},
               {"hasTime", book.has_time()},
               {"coordinates", Json::array()},
               {"outputs", Json::array()},
               {"converged", book.build().status == Termination::converged},
               {"message", book.build().message},
               {"certificate", certificate_json(book, outputs)},
               {"attitude", nullptr},
               {"pose", pose_json(book, outputs)},
               {"body", nullptr},
               {"fixed", book.model().fixed},
               {"pieces", Json::array()}};
  for (const codebooks::Coordinate& c : book.coordinates())
    json["coordinates"].push_back(
        {{"name", c.name}, {"unit", c.unit}, {"lower", c.lower}, {"upper", c.upper}});
  for (const int o : outputs) {
    const pgd::OutputLabel& label = book.outputs()[static_cast<std::size_t>(o)];
    json["outputs"].push_back({{"name", label.name}, {"unit", label.unit}});
  }
  if (const auto attitude = codebooks::AttitudeLength::of(book, outputs))
    json["attitude"] = {{"places", attitude->places()}, {"length", attitude->length()}};
  const auto mesh = body ? body : body_of(book, codebooks::middle_of_box(book));
  if (mesh && !json["pose"].is_null()) {
    json["body"] = body_json(*mesh, numbers);
    json["body"]["changes"] = body ? std::vector<std::string>() : shape_of(book, *mesh);
  }
  for (const codebooks::Piece& piece : book.pieces())
    json["pieces"].push_back(piece_json(piece, book, outputs, numbers));
  return json;
}

}  // namespace samara::identification
