#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "samara/codebooks/book/codebook.h"

namespace samara::codebooks {

/// The codebook with some of its coordinates held: the result is without them, exactly (factors are evaluated there),
/// and has them among ModelDescription::fixed.
///
/// Pieces that do not hold a value, or that no query comes to, go. Where several hold the values, the first one
/// answers, as in queries: those after it are cut, exactly, to what no earlier one holds. So the pieces of a slice
/// have borders in common at most, and at these the lower one answers, as in every codebook; there it may be another
/// one than in queries. A piece stays whole, and may answer in place of an earlier one, where it has a front, or
/// where a period or the nodes of a mesh would have to be cut. With nothing held it is the codebook itself, whose
/// pieces may overlap.
///
/// The slice has no certificate: that of the whole says how few points of its box are wrong, not where.
/// @param held coordinates and their values, SI; not time, and not all
/// @throws ArgumentError for an unknown name, for one that is counted from a front that still moves, for time, a
/// value that is not finite, if nothing is left free, and if cutting makes more than 10,000 further pieces;
/// OutsideBoxError for a value outside the box
Codebook slice(const Codebook& book, const std::map<std::string, double>& held);

/// Whether some of the pieces hold the same points, borders aside. @param pieces over the same coordinates
bool pieces_overlap(std::span<const Piece> pieces);

/// The codebook with its pieces cut like those of a slice; the codebook itself where none overlap.
/// @throws ArgumentError if cutting makes more than 10,000 further pieces
Codebook with_pieces_apart(const Codebook& book);

/// What of the codebook answers at a time: its pieces without the time, cut like those of a slice.
/// @throws ArgumentError as with_pieces_apart(), and if the codebook has no time
std::vector<Piece> pieces_at(const Codebook& book, double time);

}  // namespace samara::codebooks
