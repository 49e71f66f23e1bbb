#include "samara/codebooks/book/book_slice.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/argument_checks.h"
#include "samara/pgd/fields/field.h"

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

/// Whether one piece ends along a coordinate where the other begins, and they have more than borders in common along
/// the others.
bool is_below(const Piece& one, const Piece& other, std::size_t coordinate) {
  for (std::size_t k = 0; k < one.lower().size(); ++k) {
    const double lower = std::max(one.lower()[k], other.lower()[k]);
    const double upper = std::min(one.upper()[k], other.upper()[k]);
    const bool is_one_value = one.lower()[k] == one.upper()[k] && lower == upper;
    if (k != coordinate && !(lower < upper || is_one_value)) return false;
  }
  return one.lower()[coordinate] < other.lower()[coordinate] &&
         one.upper()[coordinate] >= other.lower()[coordinate];
}

/// Whether the piece answers at the held values: at the border of two of them the lower one does.
bool answers(const Codebook& book, const Piece& piece, const std::vector<HeldCoordinate>& held) {
  return std::ranges::all_of(held, [&](const HeldCoordinate& h) {
    const double lower = piece.lower()[h.place], upper = piece.upper()[h.place];
    if (h.value != lower) return h.value > lower && h.value <= upper;
    return std::ranges::none_of(book.pieces(),
                                [&](const Piece& other) { return is_below(other, piece, h.place); });
  });
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
  std::vector<Piece> pieces;
  for (const Piece& piece : book.pieces()) {
    if (!answers(book, piece, coordinates)) continue;
    pieces.push_back(piece.front() != nullptr ? restricted_at_front(book, piece, coordinates)
                                              : restricted_piece(book, piece, coordinates));
  }
  if (pieces.empty()) throw OutsideBoxError("the slice lies in a gap between the pieces of the codebook");
  ModelDescription model = book.model();
  for (const HeldCoordinate& h : coordinates) {
    model.fixed[book.coordinates()[h.place].name] = h.value;
    model.fixed_units[book.coordinates()[h.place].name] = book.coordinates()[h.place].unit;
  }
  Codebook sliced(std::move(model), std::move(pieces), book.build(), book.provenance(), {}, book.title());
  return book.mesh() != nullptr && sliced.space() ? sliced.with_mesh(*book.mesh()) : sliced;
}

}  // namespace samara::codebooks
