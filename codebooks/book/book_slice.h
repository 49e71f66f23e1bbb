#pragma once

#include <map>
#include <string>

#include "samara/codebooks/book/codebook.h"

namespace samara::codebooks {

/// The codebook with some of its coordinates held: those that go are restricted exactly, factor by factor,
/// and stand among ModelDescription::fixed of the result. Where several pieces hold the values, the first one
/// answers, as in queries: those after it are cut, exactly, to what no earlier one holds. So the pieces of a slice have
/// borders in common at most, and at these the lower one answers, as in every codebook; there it may be another one
/// than in queries. A piece stays whole, and may answer in place of an earlier one, where it has a front, where an axis
/// would have to be cut that is not made of elements, or where both have lists of different values.
/// Pieces that do not hold a value, or that no query comes to, go.
///
/// The slice has no certificate: that of the whole says how few points of its box are wrong, not where.
/// @param held coordinates and their values, SI; not time, and not all
/// @throws ArgumentError for an unknown name, for one that is counted from a front that still moves, for time, a
/// value that is not finite, and if nothing is left free; OutsideBoxError for a value outside the box
Codebook slice(const Codebook& book, const std::map<std::string, double>& held);

}  // namespace samara::codebooks
