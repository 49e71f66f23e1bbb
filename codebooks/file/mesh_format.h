#pragma once

#include "samara/codebooks/book/space_mesh.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/hdf5_writer.h"

/// How the mesh of a codebook stands in its file.
namespace samara::codebooks {

void write_mesh(io::Hdf5Writer& file, const SpaceMesh& mesh);

/// @throws InputError, naming the object, for one that is no mesh
SpaceMesh read_mesh(const io::Hdf5Reader& file);

}  // namespace samara::codebooks
