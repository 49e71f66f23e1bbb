#pragma once

#include "samara/codebooks/book/codebook.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/hdf5_writer.h"

/// How what is said of a codebook stands in its file: /model, /build and /provenance. Reading throws InputError, naming
/// the attribute, for one that is missing or cannot be.
namespace samara::codebooks {

void write_model(io::Hdf5Writer& file, const ModelDescription& model);
ModelDescription read_model(const io::Hdf5Reader& file);

void write_build(io::Hdf5Writer& file, const BuildRecord& build);
BuildRecord read_build(const io::Hdf5Reader& file);

void write_provenance(io::Hdf5Writer& file, const Provenance& provenance);
Provenance read_provenance(const io::Hdf5Reader& file);

}  // namespace samara::codebooks
