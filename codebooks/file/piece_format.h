#pragma once

#include <string>

#include "samara/codebooks/book/codebook.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/hdf5_writer.h"

namespace samara::codebooks {

/// Writes a piece, its axes and groups, under the group `path`. Doubles are kept to the last bit.
void write_piece(io::Hdf5Writer& file, const std::string& path, const Piece& piece);

/// @throws InputError naming the object that is missing or cannot be.
Piece read_piece(const io::Hdf5Reader& file, const std::string& path);

/// What the piece is, by its axes and the shapes of its datasets, of which none is read.
/// @throws InputError naming the object that is missing or cannot be.
PieceOutline read_outline(const io::Hdf5Reader& file, const std::string& path);

/// Number of children of a group, which must be named 0, 1, 2, ..
/// @throws InputError if one is missing or there is none.
int numbered_children(const io::Hdf5Reader& file, const std::string& group);

}  // namespace samara::codebooks
