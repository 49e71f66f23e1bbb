#pragma once

#include <map>
#include <string>

#include "samara/codebooks/book/codebook.h"

namespace samara::codebooks {

/// The codebook with some of its coordinates held: those that go are restricted exactly, factor by factor,
/// and stand among ModelDescription::fixed of the result. Of pieces that meet at a held value the first one
/// answers, as in queries; one that goes beyond those before it stays whole, and may answer in their place. Pieces
/// that do not hold a value, or that no query comes to, go.
///
/// The slice has no certificate: that of the whole says how few points of its box are wrong, not where.
/// @param held coordinates and their values, SI; not time, and not all
/// @throws ArgumentError for an unknown name, for one that is counted from a front that still moves, for time, a
/// value that is not finite, and if nothing is left free; OutsideBoxError for a value outside the box
Codebook slice(const Codebook& book, const std::map<std::string, double>& held);

}  // namespace samara::codebooks
