#include "samara/codebooks/book/book_slice.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/argument_checks.h"
#include "samara/codebooks/book/piece_finder.h"
#include "samara/pgd/fields/field.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::codebooks {

namespace {

struct HeldCoordinate {
  std::size_t place = 0;
  double value = 0.0;
};

std::vector<HeldCoordinate> checked(const Codebook& book, const std::map<std::string, double>& held) {
  std::vector<HeldCoordinate> coordinates;
  for (const auto& [name, value] : held) {
    const auto place = static_cast<std::size_t>(book.coordinate_index(name));
    if (book.has_time() && place == 0)
      throw ArgumentError(
          fmt::format("a slice holds \"{}\", the time; a query at that time was expected", name));
    require_inside(std::span(book.coordinates()).subspan(place, 1), std::span(&value, 1));
    coordinates.push_back({place, value});
  }
  if (coordinates.size() >= book.parameters().size())
    throw ArgumentError("a slice holds all coordinates but time; a query at the point was expected");
  return coordinates;
}

/// The box of a piece without the held coordinates.
struct FreeBox {
  std::vector<double> lower, upper;
  std::vector<std::vector<double>> lists;  ///< values of those axes that are lists
};

FreeBox free_box(const Piece& piece, const std::vector<HeldCoordinate>& held, bool has_lists) {
  FreeBox box;
  for (std::size_t k = 0; k < piece.lower().size(); ++k) {
    if (std::ranges::find(held, k, &HeldCoordinate::place) != held.end()) continue;
    box.lower.push_back(piece.lower()[k]);
    box.upper.push_back(piece.upper()[k]);
    if (!has_lists) continue;
    const pgd::Axis& axis = piece.groups().front().axes()[k];
    if (axis.is_list()) box.lists.emplace_back(axis.nodes().begin(), axis.nodes().end());
  }
  return box;
}

/// What of a box another one holds, but for borders; empty if that is nothing. Along a coordinate a box may be a single
/// value. What boxes of different lists have in common is no box, and counts as nothing.
std::optional<FreeBox> common_box(const FreeBox& box, const FreeBox& other) {
  // Nearly all pairs of pieces end here: nothing is copied before.
  for (std::size_t k = 0; k < box.lower.size(); ++k) {
    const double lower = std::max(box.lower[k], other.lower[k]);
    const double upper = std::min(box.upper[k], other.upper[k]);
    const bool is_value = box.lower[k] == box.upper[k] && lower == upper;
    if (!(lower < upper || is_value)) return std::nullopt;
  }
  if (box.lists != other.lists) return std::nullopt;
  FreeBox both = box;
  for (std::size_t k = 0; k < box.lower.size(); ++k) {
    both.lower[k] = std::max(box.lower[k], other.lower[k]);
    both.upper[k] = std::min(box.upper[k], other.upper[k]);
  }
  return both;
}

/// Appends what of a box none of the others holds, in boxes that have borders in common at most.
void append_rest(const FreeBox& box, std::span<const FreeBox> others, std::vector<FreeBox>& rest) {
  for (std::size_t i = 0; i < others.size(); ++i) {
    const std::optional<FreeBox> both = common_box(box, others[i]);
    if (!both) continue;
    // What lies below and above the other one is for those after it.
    FreeBox left = box;
    for (std::size_t k = 0; k < box.lower.size(); ++k) {
      const auto append_part = [&](double begin, double end) {
        if (!(begin < end)) return;
        FreeBox part = left;
        part.lower[k] = begin;
        part.upper[k] = end;
        append_rest(part, others.subspan(i + 1), rest);
      };
      append_part(left.lower[k], both->lower[k]);
      append_part(both->upper[k], left.upper[k]);
      left.lower[k] = both->lower[k];
      left.upper[k] = both->upper[k];
    }
    return;
  }
  rest.push_back(box);
}

/// An axis of elements between two of its points: it holds the same functions there.
pgd::Axis part_of(const pgd::Axis& axis, double lower, double upper) {
  std::vector<double> borders = {lower};
  for (const double border : axis.borders()) {
    if (border > lower && border < upper) borders.push_back(border);
  }
  borders.push_back(upper);
  const pgd::Axis::Label label{axis.name(), axis.unit(), axis.role(), axis.transform()};
  const Eigen::Map<const Eigen::VectorXd> ends(borders.data(), std::ssize(borders));
  return pgd::Axis::of_elements(label, axis.basis(), ends, axis.degree());
}

bool is_cut(const pgd::Axis& axis, const FreeBox& part, std::size_t place) {
  return axis.lower() != part.lower[place] || axis.upper() != part.upper[place];
}

/// The same functions on a part of their box, which is cut along axes of elements.
FieldGroup part_of(const FieldGroup& group, const FreeBox& part) {
  std::vector<pgd::Axis> axes = group.axes();
  for (std::size_t k = 0; k < axes.size(); ++k)
    if (is_cut(axes[k], part, k)) axes[k] = part_of(axes[k], part.lower[k], part.upper[k]);
  if (const pgd::TrainField* train = group.train())
    return pgd::TrainField(axes, train->outputs(), pgd::carried_over(train->train(), train->axes(), axes));
  const pgd::SeparatedField& sum = *group.sum();
  std::vector<Eigen::MatrixXd> factors = sum.factors();
  for (std::size_t k = 0; k < axes.size(); ++k) {
    if (is_cut(sum.axes()[k], part, k))
      factors[k] = pgd::interpolation_matrix(sum.axes()[k], axes[k].nodes()) * factors[k];
  }
  return pgd::SeparatedField(std::move(axes), sum.outputs(), std::move(factors), sum.weights());
}

/// Appends the parts of a piece. It stays whole where it has a front, or an axis would have to be cut that is not made
/// of elements.
void append_parts(Piece piece, const std::vector<FreeBox>& parts, std::vector<Piece>& pieces) {
  const std::vector<pgd::Axis>& axes = piece.groups().front().axes();
  bool is_whole = true, may_be_cut = piece.front() == nullptr;
  for (const FreeBox& part : parts) {
    for (std::size_t k = 0; k < axes.size(); ++k) {
      if (!is_cut(axes[k], part, k)) continue;
      is_whole = false;
      may_be_cut = may_be_cut && axes[k].has_elements();
    }
  }
  if (is_whole || !may_be_cut) {
    pieces.push_back(std::move(piece));
    return;
  }
  for (const FreeBox& part : parts) {
    Piece::Groups groups;
    for (const FieldGroup& group : piece.groups()) groups.push_back(part_of(group, part));
    pieces.emplace_back(std::move(groups));
  }
}

Piece restricted_piece(const Codebook& book, const Piece& piece, const std::vector<HeldCoordinate>& held) {
  Piece::Groups groups;
  for (FieldGroup group : piece.groups()) {
    for (const HeldCoordinate& h : held)
      group = pgd::restricted(group, book.coordinates()[h.place].name, h.value);
    groups.push_back(std::move(group));
  }
  return groups;
}

/// A piece with a front, without the held coordinates. Where the counted one is held it stands still on its axis only
/// if all do that the front depends on.
Piece restricted_at_front(const Codebook& book, const Piece& piece, std::vector<HeldCoordinate> held) {
  FrontMap front = *piece.front();
  std::vector<double> point(piece.lower());
  for (const HeldCoordinate& h : held) point[h.place] = h.value;
  const auto held_at = [&](int coordinate) {
    return std::ranges::find(held, static_cast<std::size_t>(coordinate), &HeldCoordinate::place);
  };
  const auto name = [&](int place) { return book.coordinates()[static_cast<std::size_t>(place)].name; };
  if (const auto counted = held_at(front.coordinate()); counted != held.end()) {
    for (const FrontMap::Other& other : front.others()) {
      if (held_at(other.coordinate) != held.end()) continue;
      throw ArgumentError(
          fmt::format("a slice holds \"{}\", which the codebook counts from a front that moves with \"{}\"; "
                      "\"{}\" was expected to be held, too",
                      name(front.coordinate()), name(other.coordinate), name(other.coordinate)));
    }
    counted->value = front.to_axis(point.data());
    return restricted_piece(book, piece, held);
  }
  const Piece restricted = restricted_piece(book, piece, held);
  std::ranges::sort(held, std::greater(), &HeldCoordinate::place);
  for (const HeldCoordinate& h : held) front = front.restricted(static_cast<int>(h.place), h.value);
  return {restricted.groups(), std::move(front)};
}

}  // namespace

Codebook slice(const Codebook& book, const std::map<std::string, double>& held) {
  if (held.empty()) return book;
  const std::vector<HeldCoordinate> coordinates = checked(book, held);
  std::vector<std::optional<double>> values(book.coordinates().size());
  for (const HeldCoordinate& h : coordinates) values[h.place] = h.value;
  const bool has_lists = std::ranges::any_of(book.pieces().front().outline().axes, &pgd::Axis::is_list);
  std::vector<Piece> pieces;
  std::vector<FreeBox> before;
  for (const Piece& piece : book.pieces()) {
    if (!holds(piece, values, !has_lists)) continue;
    const FreeBox box = free_box(piece, coordinates, has_lists);
    std::vector<FreeBox> parts;
    append_rest(box, before, parts);
    before.push_back(box);
    if (parts.empty()) continue;
    append_parts(piece.front() != nullptr ? restricted_at_front(book, piece, coordinates)
                                          : restricted_piece(book, piece, coordinates),
                 parts, pieces);
  }
  if (pieces.empty()) {
    throw OutsideBoxError(
        "the slice lies in a gap between the pieces of the codebook or the values of a discrete axis");
  }
  ModelDescription model = book.model();
  for (const HeldCoordinate& h : coordinates) {
    model.fixed[book.coordinates()[h.place].name] = h.value;
    model.fixed_units[book.coordinates()[h.place].name] = book.coordinates()[h.place].unit;
  }
  Codebook sliced(std::move(model), std::move(pieces), book.build(), book.provenance(), {}, book.title());
  return book.mesh() != nullptr && sliced.space() ? sliced.with_mesh(*book.mesh()) : sliced;
}

}  // namespace samara::codebooks
