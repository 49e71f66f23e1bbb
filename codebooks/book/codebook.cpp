#include "samara/codebooks/book/codebook.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/models/checks/check_physics.h"
#include "samara/models/laws/registry.h"

namespace samara::codebooks {

namespace {

const std::vector<pgd::Axis>& axes_of(const Piece& piece) {
  if (piece.groups().empty()) throw ArgumentError("a piece of the codebook has no field group");
  return piece.groups().front().axes();
}

bool same_axis(const pgd::Axis& a, const pgd::Axis& b) {
  return a.name() == b.name() && a.unit() == b.unit() && a.role() == b.role() && a.basis() == b.basis() &&
         a.transform() == b.transform() && a.lower() == b.lower() && a.upper() == b.upper() &&
         a.size() == b.size() && a.nodes() == b.nodes() && a.weights() == b.weights();
}

void check_groups(const Piece& piece) {
  const std::vector<pgd::Axis>& axes = axes_of(piece);
  for (const FieldGroup& group : piece.groups()) {
    const bool same =
        std::equal(axes.begin(), axes.end(), group.axes().begin(), group.axes().end(), same_axis);
    if (!same) throw ArgumentError("the groups of a piece of the codebook must have the same axes");
  }
}

/// Whether a front's interval is all of an axis that is no time and lets points lie between its nodes.
void check_front_axis(const std::vector<pgd::Axis>& axes, int place, double lower, double upper) {
  if (static_cast<std::size_t>(place) >= axes.size()) {
    throw ArgumentError(
        fmt::format("a front names the axis {}, expected one of 0 to {}", place, axes.size() - 1));
  }
  const pgd::Axis& axis = axes[static_cast<std::size_t>(place)];
  if (axis.role() == pgd::AxisRole::time || axis.role() == pgd::AxisRole::space || !axis.has_elements())
    throw ArgumentError(fmt::format(
        "a front has to do with the axis \"{}\", expected a parameter with elements", axis.name()));
  if (axis.lower() != lower || axis.upper() != upper) {
    throw ArgumentError(fmt::format("a front knows the axis \"{}\" from {} to {}, expected {} to {}",
                                    axis.name(), lower, upper, axis.lower(), axis.upper()));
  }
}

void check_front(const std::vector<pgd::Axis>& axes, const FrontMap& front) {
  check_front_axis(axes, front.coordinate(), front.lower(), front.upper());
  for (const FrontMap::Other& other : front.others())
    check_front_axis(axes, other.coordinate, other.lower, other.upper);
}

std::vector<Coordinate> coordinates_of(const PieceOutline& piece, bool needs_time) {
  std::vector<Coordinate> coordinates;
  for (const pgd::Axis& axis : piece.axes) {
    coordinates.push_back({axis.name(), axis.unit(), axis.role(), axis.lower(), axis.upper()});
  }
  const bool has_time = coordinates.front().role == pgd::AxisRole::time;
  if (needs_time && !has_time) {
    throw ArgumentError(fmt::format("the first axis of a codebook is \"{}\" with role {}, expected time",
                                    coordinates.front().name, to_string(coordinates.front().role)));
  }
  const auto is_time = [](const Coordinate& c) { return c.role == pgd::AxisRole::time; };
  if (std::any_of(coordinates.begin() + 1, coordinates.end(), is_time))
    throw ArgumentError("an axis of a codebook after the first one is time; time was expected first");
  return coordinates;
}

/// Pieces in the order of their lower corners, so that the first of those that share a border is the lower
/// one.
void sort_pieces(std::vector<Piece>& pieces) {
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const Piece& a, const Piece& b) { return a.lower() < b.lower(); });
}

std::vector<pgd::OutputLabel> outputs_of(const PieceOutline& piece) {
  std::vector<pgd::OutputLabel> outputs;
  for (const GroupOutline& group : piece.groups) {
    outputs.insert(outputs.end(), group.outputs.begin(), group.outputs.end());
  }
  return outputs;
}

void check_distinct(const std::vector<pgd::OutputLabel>& outputs) {
  std::set<std::string> names;
  for (const pgd::OutputLabel& output : outputs) {
    if (!names.insert(output.name).second)
      throw ArgumentError(fmt::format("the codebook has two outputs \"{}\"", output.name));
  }
}

template <class Items>
int index_of(const Items& items, const std::string& name, const char* what) {
  std::vector<std::string> names;
  for (const auto& item : items) names.push_back(item.name);
  const auto it = std::find(names.begin(), names.end(), name);
  if (it == names.end()) {
    throw ArgumentError(fmt::format("the codebook has no {} \"{}\"{}", what, name, suggestion(name, names)));
  }
  return static_cast<int>(it - names.begin());
}

}  // namespace

struct Piece::Content {
  std::once_flag once;
  std::atomic<bool> is_read = false;
  Groups groups;
  std::vector<double> lower, upper;
  std::optional<FrontMap> front;
  std::mutex busy;  ///< the two functions are on their way out
  std::function<Groups()> read;
  std::function<PieceOutline()> outline;
};

Piece::Piece(Groups groups) : content_(std::make_shared<Content>()) {
  if (!groups.empty()) {
    for (const pgd::Axis& axis : groups.front().axes()) {
      content_->lower.push_back(axis.lower());
      content_->upper.push_back(axis.upper());
    }
  }
  content_->groups = std::move(groups);
  content_->is_read = true;
}

Piece::Piece(Groups groups, FrontMap front) : Piece(std::move(groups)) {
  check_front(axes_of(*this), front);
  content_->front = std::move(front);
}

Piece::Piece(std::vector<double> lower, std::vector<double> upper, std::function<Groups()> read,
             std::function<PieceOutline()> outline)
    : content_(std::make_shared<Content>()) {
  content_->lower = std::move(lower);
  content_->upper = std::move(upper);
  content_->read = std::move(read);
  content_->outline = std::move(outline);
}

const Piece::Groups& Piece::groups() const {
  if (!content_->is_read) {
    std::call_once(content_->once, [&] {
      content_->groups = content_->read();
      const std::lock_guard lock(content_->busy);
      content_->read = {};
      content_->outline = {};
      content_->is_read = true;
    });
  }
  return content_->groups;
}

PieceOutline Piece::outline() const {
  std::function<PieceOutline()> of_file;
  {
    const std::lock_guard lock(content_->busy);
    of_file = content_->outline;
  }
  if (of_file) return of_file();
  PieceOutline result{axes_of(*this), {}};
  for (const FieldGroup& group : groups()) result.groups.push_back(outline_of(group));
  return result;
}

bool Piece::is_read() const {
  return content_->is_read;
}
const std::vector<double>& Piece::lower() const {
  return content_->lower;
}
const std::vector<double>& Piece::upper() const {
  return content_->upper;
}
const FrontMap* Piece::front() const {
  return content_->front ? &*content_->front : nullptr;
}

std::shared_ptr<const models::Model> known_model(const ModelDescription& description) {
  return description.of_text ? description.of_text : models::find_model_or_null(description.name);
}

Codebook::Codebook(ModelDescription model, std::vector<Piece> pieces, BuildRecord build,
                   Provenance provenance, std::optional<Certificate> certificate, std::string title)
    : model_(std::move(model)),
      pieces_(std::move(pieces)),
      build_(std::move(build)),
      provenance_(std::move(provenance)),
      certificate_(std::move(certificate)),
      title_(std::move(title)) {
  if (pieces_.empty()) throw ArgumentError("a codebook needs at least one piece");
  for (const Piece& piece : pieces_) {
    if (piece.is_read()) check_groups(piece);
    if (piece.front() != nullptr && pieces_.size() > 1)
      throw ArgumentError("a coordinate is counted from a front, expected one piece alone, not several");
  }
  sort_pieces(pieces_);
  const PieceOutline first = pieces_.front().outline();
  coordinates_ = coordinates_of(first, known_model(model_) != nullptr);
  outputs_ = outputs_of(first);
  check_distinct(outputs_);
  for (const Piece& piece : pieces_) {
    if (piece.is_read()) check_piece(piece);
    if (piece.lower().size() != coordinates_.size())
      throw ArgumentError("pieces of a codebook must have the same coordinates in the same order");
    for (std::size_t k = 0; k < coordinates_.size(); ++k) {
      coordinates_[k].lower = std::min(coordinates_[k].lower, piece.lower()[k]);
      coordinates_[k].upper = std::max(coordinates_[k].upper, piece.upper()[k]);
    }
  }
}

void Codebook::check_piece(const Piece& piece) const {
  check_groups(piece);
  const std::vector<pgd::Axis>& axes = axes_of(piece);
  if (has_time() && !axes.front().has_elements()) {
    throw ArgumentError(fmt::format("the time axis of a codebook is {}, expected one made of elements",
                                    to_string(axes.front().basis())));
  }
  const bool same_coordinates =
      std::equal(coordinates_.begin(), coordinates_.end(), axes.begin(), axes.end(),
                 [](const Coordinate& c, const pgd::Axis& a) {
                   return c.name == a.name() && c.unit == a.unit() && c.role == a.role();
                 });
  if (!same_coordinates)
    throw ArgumentError("pieces of a codebook must have the same coordinates in the same order");
  const auto labels = outputs_of(piece.outline());
  const bool same_outputs =
      std::equal(labels.begin(), labels.end(), outputs_.begin(), outputs_.end(),
                 [](const auto& a, const auto& b) { return a.name == b.name && a.unit == b.unit; });
  if (!same_outputs) throw ArgumentError("pieces of a codebook must have the same outputs in the same order");
}

int Codebook::coordinate_index(const std::string& name) const {
  return index_of(coordinates_, name, "coordinate");
}
int Codebook::output_index(const std::string& name) const {
  const auto has = [&](const std::vector<pgd::OutputLabel>& labels) {
    return std::ranges::find(labels, name, &pgd::OutputLabel::name) != labels.end();
  };
  if (!has(outputs_) && has(derived_outputs(*this))) {
    std::vector<std::string> stored;
    for (const pgd::OutputLabel& output : outputs_) stored.push_back(output.name);
    throw ArgumentError(
        fmt::format("the output \"{}\" is derived by the model, one that is stored was expected: {}", name,
                    join(stored)));
  }
  return index_of(outputs_, name, "output");
}

const Coordinate& Codebook::time(const char* what) const {
  if (has_time()) return coordinates_.front();
  throw ArgumentError(fmt::format("{} needs time, which this codebook does not have", what));
}

std::optional<int> Codebook::space() const {
  const auto is_space = [](const Coordinate& c) { return c.role == pgd::AxisRole::space; };
  if (std::ranges::count_if(coordinates_, is_space) != 1) return {};
  return static_cast<int>(std::ranges::find_if(coordinates_, is_space) - coordinates_.begin());
}

Codebook Codebook::with_mesh(SpaceMesh mesh) const {
  const std::optional<int> place = space();
  if (!place)
    throw ArgumentError("a mesh was given for a codebook that has no coordinate of space, or several");
  const pgd::Axis axis = pieces_.front().outline().axes[static_cast<std::size_t>(*place)];
  if (!axis.is_list() || axis.size() != mesh.node_count()) {
    throw ArgumentError(fmt::format("a mesh of {} nodes was given for the axis \"{}\", which {} {} nodes",
                                    mesh.node_count(), axis.name(),
                                    axis.is_list() ? "lists" : "interpolates between", axis.size()));
  }
  for (const Coordinate& c : coordinates_) {
    if (std::ranges::count(mesh.directions(), c.name) == 0) continue;
    throw ArgumentError(
        fmt::format("a direction of the mesh and a coordinate of the codebook have the name \"{}\"", c.name));
  }
  Codebook copy = *this;
  copy.mesh_ = std::make_shared<const SpaceMesh>(std::move(mesh));
  return copy;
}

Codebook Codebook::with_certificate(Certificate certificate) const {
  Codebook copy = *this;
  copy.certificate_ = std::move(certificate);
  return copy;
}

std::vector<pgd::OutputLabel> derived_outputs(const Codebook& book) {
  const auto model = known_model(book.model());
  std::vector<pgd::OutputLabel> labels;
  if (!model) return labels;
  for (const models::StateInfo& state : model->info().states) {
    if (std::ranges::find(book.outputs(), state.name, &pgd::OutputLabel::name) == book.outputs().end())
      return labels;
  }
  for (const models::OutputInfo& output : model->info().outputs) labels.push_back({output.name, output.unit});
  return labels;
}

}  // namespace samara::codebooks
