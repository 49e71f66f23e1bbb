#include "samara/codebooks/codebook.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

namespace samara::codebooks {

namespace {

const std::vector<pgd::Axis>& axes_of(const Piece& piece) {
  if (piece.groups.empty()) throw ArgumentError("a piece of the codebook has no field group");
  return piece.groups.front().axes();
}

/// Smallest box around all pieces; every group of every piece must have the same coordinates in the same
/// order.
std::vector<Coordinate> common_coordinates(const std::vector<Piece>& pieces) {
  std::vector<Coordinate> coordinates;
  for (const pgd::Axis& axis : axes_of(pieces.front())) {
    coordinates.push_back({axis.name(), axis.unit(), axis.role(), axis.lower(), axis.upper()});
  }
  if (coordinates.front().role != pgd::AxisRole::time) {
    throw ArgumentError(fmt::format("the first axis of a codebook is \"{}\" with role {}, expected time",
                                    coordinates.front().name, to_string(coordinates.front().role)));
  }
  for (const Piece& piece : pieces) {
    for (const pgd::SeparatedField& group : piece.groups) {
      const bool same =
          std::equal(coordinates.begin(), coordinates.end(), group.axes().begin(), group.axes().end(),
                     [](const Coordinate& c, const pgd::Axis& a) { return c.name == a.name(); });
      if (!same) throw ArgumentError("pieces of a codebook must have the same coordinates in the same order");
      for (std::size_t k = 0; k < coordinates.size(); ++k) {
        coordinates[k].lower = std::min(coordinates[k].lower, group.axes()[k].lower());
        coordinates[k].upper = std::max(coordinates[k].upper, group.axes()[k].upper());
      }
    }
  }
  return coordinates;
}

std::vector<pgd::OutputLabel> outputs_of(const Piece& piece) {
  std::vector<pgd::OutputLabel> outputs;
  for (const pgd::SeparatedField& group : piece.groups) {
    outputs.insert(outputs.end(), group.outputs().begin(), group.outputs().end());
  }
  return outputs;
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

Codebook::Codebook(ModelDescription model, std::vector<Piece> pieces, BuildRecord build,
                   Provenance provenance, std::optional<Certificate> certificate, std::string title)
    : model_(std::move(model)),
      pieces_(std::move(pieces)),
      build_(std::move(build)),
      provenance_(std::move(provenance)),
      certificate_(std::move(certificate)),
      title_(std::move(title)) {
  if (pieces_.empty()) throw ArgumentError("a codebook needs at least one piece");
  coordinates_ = common_coordinates(pieces_);
  outputs_ = outputs_of(pieces_.front());
  for (const Piece& piece : pieces_) {
    const auto labels = outputs_of(piece);
    const bool same = std::equal(labels.begin(), labels.end(), outputs_.begin(), outputs_.end(),
                                 [](const auto& a, const auto& b) { return a.name == b.name; });
    if (!same) throw ArgumentError("pieces of a codebook must have the same outputs in the same order");
  }
}

int Codebook::coordinate_index(const std::string& name) const {
  return index_of(coordinates_, name, "coordinate");
}
int Codebook::output_index(const std::string& name) const {
  return index_of(outputs_, name, "output");
}

Codebook Codebook::with_certificate(Certificate certificate) const {
  Codebook copy = *this;
  copy.certificate_ = std::move(certificate);
  return copy;
}

}  // namespace samara::codebooks
