#include "samara/codebooks/book/book_slice.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/box.h"
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

/// Whether the piece answers at the held values: at the border of two of them the lower one does.
bool answers(const Codebook& book, const Piece& piece, const std::vector<HeldCoordinate>& held) {
  return std::ranges::all_of(held, [&](const HeldCoordinate& h) {
    const double lower = piece.lower()[h.place], upper = piece.upper()[h.place];
    const bool is_lowest = lower == book.coordinates()[h.place].lower;
    return (h.value > lower || (is_lowest && h.value == lower)) && h.value <= upper;
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

}  // namespace

Codebook slice(const Codebook& book, const std::map<std::string, double>& held) {
  if (held.empty()) return book;
  const std::vector<HeldCoordinate> coordinates = checked(book, held);
  std::vector<Piece> pieces;
  for (const Piece& piece : book.pieces()) {
    if (answers(book, piece, coordinates)) pieces.push_back(restricted_piece(book, piece, coordinates));
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
