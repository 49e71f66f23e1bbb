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

/// Whether the pieces hold the whole box but for borders. Along a coordinate it may be a single value.
bool is_covered(const std::vector<double>& lower, const std::vector<double>& upper,
                std::span<const Piece> pieces) {
  std::vector<double> from(lower), to(upper);
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    bool meets = true;
    for (std::size_t k = 0; meets && k < lower.size(); ++k) {
      from[k] = std::max(lower[k], pieces[p].lower()[k]);
      to[k] = std::min(upper[k], pieces[p].upper()[k]);
      meets = from[k] < to[k] || (lower[k] == upper[k] && from[k] == to[k]);
    }
    if (!meets) continue;
    // What this piece leaves below and above it is for those after it.
    std::vector<double> low(lower), high(upper);
    for (std::size_t k = 0; k < lower.size(); ++k) {
      const auto is_left = [&](double begin, double end) {
        if (!(begin < end)) return false;
        std::vector<double> part_low(low), part_high(high);
        part_low[k] = begin;
        part_high[k] = end;
        return !is_covered(part_low, part_high, pieces.subspan(p + 1));
      };
      if (is_left(low[k], from[k]) || is_left(to[k], high[k])) return false;
      low[k] = from[k];
      high[k] = to[k];
    }
    return true;
  }
  return false;
}

/// Whether queries at the held values come to the piece: at the border of several the first one answers.
bool answers(const Codebook& book, std::size_t number, const std::vector<HeldCoordinate>& held) {
  std::vector<double> lower = book.pieces()[number].lower(), upper = book.pieces()[number].upper();
  bool is_at_border = false;
  for (const HeldCoordinate& h : held) {
    if (!(h.value >= lower[h.place] && h.value <= upper[h.place])) return false;
    is_at_border = is_at_border || h.value == lower[h.place] || h.value == upper[h.place];
    lower[h.place] = upper[h.place] = h.value;
  }
  return !is_at_border || !is_covered(lower, upper, std::span(book.pieces()).first(number));
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
  for (std::size_t number = 0; number < book.pieces().size(); ++number) {
    if (!answers(book, number, coordinates)) continue;
    const Piece& piece = book.pieces()[number];
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
