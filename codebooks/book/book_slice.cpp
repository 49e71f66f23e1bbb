#include "samara/codebooks/book/book_slice.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <iterator>
#include <memory>
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

/// Most pieces that cutting makes beyond those that there are. Every piece that another one crosses may fall into two
/// parts per coordinate, and each of these again: without a limit a small file would ask for any memory.
constexpr std::size_t kMostFurtherPieces = 10'000;

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
  using Values = std::shared_ptr<const std::vector<double>>;
  std::vector<double> lower, upper;
  std::vector<Values> lists;  ///< per coordinate, null of intervals; empty where no piece has lists

  bool is_list(std::size_t place) const { return !lists.empty() && lists[place]; }
  void set_list(std::size_t place, std::vector<double> values) {
    lower[place] = values.front();
    upper[place] = values.back();
    lists[place] = std::make_shared<const std::vector<double>>(std::move(values));
  }
};

bool have_lists(std::span<const Piece> pieces) {
  return std::ranges::any_of(pieces.front().outline().axes, &pgd::Axis::is_list);
}

FreeBox free_box(const Piece& piece, const std::vector<HeldCoordinate>& held, bool has_lists) {
  FreeBox box;
  for (std::size_t k = 0; k < piece.lower().size(); ++k) {
    if (std::ranges::find(held, k, &HeldCoordinate::place) != held.end()) continue;
    box.lower.push_back(piece.lower()[k]);
    box.upper.push_back(piece.upper()[k]);
    if (!has_lists) continue;
    box.lists.emplace_back();
    const pgd::Axis& axis = piece.groups().front().axes()[k];
    if (axis.is_list()) box.set_list(box.lists.size() - 1, {axis.nodes().begin(), axis.nodes().end()});
  }
  return box;
}

/// What of a box another one holds, but for borders; empty if that is nothing. Along a coordinate a box may be a single
/// value. What an interval and a list have in common is no box, and counts as nothing.
std::optional<FreeBox> common_box(const FreeBox& box, const FreeBox& other) {
  // Nearly all pairs of pieces end here: nothing is copied before.
  for (std::size_t k = 0; k < box.lower.size(); ++k) {
    if (box.is_list(k) != other.is_list(k)) return std::nullopt;
    const double lower = std::max(box.lower[k], other.lower[k]);
    const double upper = std::min(box.upper[k], other.upper[k]);
    const bool may_be_value = box.is_list(k) || box.lower[k] == box.upper[k];
    if (!(lower < upper || (may_be_value && lower == upper))) return std::nullopt;
  }
  FreeBox both = box;
  for (std::size_t k = 0; k < box.lower.size(); ++k) {
    if (!box.is_list(k)) {
      both.lower[k] = std::max(box.lower[k], other.lower[k]);
      both.upper[k] = std::min(box.upper[k], other.upper[k]);
    } else if (*box.lists[k] != *other.lists[k]) {
      std::vector<double> values;
      std::ranges::set_intersection(*box.lists[k], *other.lists[k], std::back_inserter(values));
      if (values.empty()) return std::nullopt;
      both.set_list(k, std::move(values));
    }
  }
  return both;
}

/// Appends what of a box lies outside a part of it, in boxes that have borders in common at most.
void append_outside(FreeBox left, const FreeBox& inside, std::vector<FreeBox>& parts) {
  for (std::size_t k = 0; k < left.lower.size(); ++k) {
    if (left.is_list(k)) {
      std::vector<double> values;
      std::ranges::set_difference(*left.lists[k], *inside.lists[k], std::back_inserter(values));
      if (!values.empty()) {
        parts.push_back(left);
        parts.back().set_list(k, std::move(values));
      }
      left.lists[k] = inside.lists[k];
    } else {
      for (const auto& [begin, end] :
           {std::pair(left.lower[k], inside.lower[k]), std::pair(inside.upper[k], left.upper[k])}) {
        if (!(begin < end)) continue;
        parts.push_back(left);
        parts.back().lower[k] = begin;
        parts.back().upper[k] = end;
      }
    }
    left.lower[k] = inside.lower[k];
    left.upper[k] = inside.upper[k];
  }
}

/// What of a box none of the others holds, in boxes that have borders in common at most.
/// @param most further boxes than one. @throws ArgumentError if there are more on the way
std::vector<FreeBox> rest_of(const FreeBox& box, std::span<const FreeBox> others, std::size_t most) {
  std::vector<FreeBox> parts = {box};
  for (const FreeBox& other : others) {
    const auto meets = [&](const FreeBox& part) { return common_box(part, other).has_value(); };
    if (std::ranges::none_of(parts, meets)) continue;
    std::vector<FreeBox> left;
    for (FreeBox& part : parts) {
      if (const std::optional<FreeBox> both = common_box(part, other)) {
        append_outside(std::move(part), *both, left);
      } else {
        left.push_back(std::move(part));
      }
      if (left.size() <= most + 1) continue;
      throw ArgumentError(
          fmt::format("pieces of the codebook overlap so that cutting them apart makes more than {} further "
                      "ones, at most so many were expected",
                      kMostFurtherPieces));
    }
    parts = std::move(left);
  }
  return parts;
}

/// An axis of elements between two of its points, where it holds the same functions, or some values of a list.
pgd::Axis part_of(const pgd::Axis& axis, const FreeBox& part, std::size_t place) {
  const pgd::Axis::Label label{axis.name(), axis.unit(), axis.role(), axis.transform()};
  if (part.is_list(place)) {
    const std::vector<double>& values = *part.lists[place];
    return pgd::Axis::discrete(label, Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values)));
  }
  std::vector<double> borders = {part.lower[place]};
  for (const double border : axis.borders()) {
    if (border > part.lower[place] && border < part.upper[place]) borders.push_back(border);
  }
  borders.push_back(part.upper[place]);
  const Eigen::Map<const Eigen::VectorXd> ends(borders.data(), std::ssize(borders));
  return pgd::Axis::of_elements(label, axis.basis(), ends, axis.degree());
}

bool is_cut(const pgd::Axis& axis, const FreeBox& part, std::size_t place) {
  if (part.is_list(place)) return axis.size() != std::ssize(*part.lists[place]);
  return axis.lower() != part.lower[place] || axis.upper() != part.upper[place];
}

/// Nodes of a mesh stay together, and so does a period.
bool may_be_cut(const pgd::Axis& axis, const FreeBox& part, std::size_t place) {
  return part.is_list(place) ? axis.basis() == pgd::Basis::discrete : axis.has_elements();
}

/// The same functions on a part of their box.
FieldGroup part_of(const FieldGroup& group, const FreeBox& part) {
  std::vector<pgd::Axis> axes = group.axes();
  for (std::size_t k = 0; k < axes.size(); ++k)
    if (is_cut(axes[k], part, k)) axes[k] = part_of(axes[k], part, k);
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

/// Appends the parts of a piece. It stays whole where it has a front, or an axis would have to be cut that cannot be.
void append_parts(Piece piece, const std::vector<FreeBox>& parts, std::vector<Piece>& pieces) {
  const std::vector<pgd::Axis>& axes = piece.groups().front().axes();
  bool is_whole = true, has_parts = piece.front() == nullptr;
  for (const FreeBox& part : parts) {
    for (std::size_t k = 0; k < axes.size(); ++k) {
      if (!is_cut(axes[k], part, k)) continue;
      is_whole = false;
      has_parts = has_parts && may_be_cut(axes[k], part, k);
    }
  }
  if (is_whole || !has_parts) {
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

/// The pieces without the held coordinates, cut to what no earlier one holds. None where no piece holds the values.
std::vector<Piece> cut_pieces(const Codebook& book, const std::vector<HeldCoordinate>& held) {
  std::vector<std::optional<double>> values(book.coordinates().size());
  for (const HeldCoordinate& h : held) values[h.place] = h.value;
  const bool has_lists = have_lists(book.pieces());
  struct Cut {
    const Piece* piece = nullptr;
    std::vector<FreeBox> parts;
  };
  std::vector<Cut> cuts;
  std::vector<FreeBox> before;
  std::size_t most = kMostFurtherPieces;
  for (const Piece& piece : book.pieces()) {
    if (!holds(piece, values, !has_lists)) continue;
    FreeBox box = free_box(piece, held, has_lists);
    std::vector<FreeBox> parts = rest_of(box, before, most);
    before.push_back(std::move(box));
    if (parts.empty()) continue;
    most -= parts.size() - 1;
    cuts.push_back({&piece, std::move(parts)});
  }
  std::vector<Piece> pieces;
  for (const Cut& cut : cuts)
    append_parts(cut.piece->front() != nullptr ? restricted_at_front(book, *cut.piece, held)
                                               : restricted_piece(book, *cut.piece, held),
                 cut.parts, pieces);
  return pieces;
}

}  // namespace

Codebook slice(const Codebook& book, const std::map<std::string, double>& held) {
  if (held.empty()) return book;
  const std::vector<HeldCoordinate> coordinates = checked(book, held);
  std::vector<Piece> pieces = cut_pieces(book, coordinates);
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

bool pieces_overlap(std::span<const Piece> pieces) {
  if (pieces.size() < 2) return false;
  const bool has_lists = have_lists(pieces);
  std::vector<FreeBox> before;
  for (const Piece& piece : pieces) {
    FreeBox box = free_box(piece, {}, has_lists);
    const auto meets = [&](const FreeBox& other) { return common_box(box, other).has_value(); };
    if (std::ranges::any_of(before, meets)) return true;
    before.push_back(std::move(box));
  }
  return false;
}

Codebook with_pieces_apart(const Codebook& book) {
  if (!pieces_overlap(book.pieces())) return book;
  Codebook apart(book.model(), cut_pieces(book, {}), book.build(), book.provenance(), book.certificate(),
                 book.title());
  return book.mesh() != nullptr ? apart.with_mesh(*book.mesh()) : apart;
}

std::vector<Piece> pieces_at(const Codebook& book, double time) {
  book.time("the pieces at a time");
  return cut_pieces(book, {{0, time}});
}

}  // namespace samara::codebooks
