#pragma once

#include "samara/codebooks/book/certificate.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/hdf5_writer.h"

/// How the certificate of a codebook stands in its file: /certificate.
namespace samara::codebooks {

void write_certificate(io::Hdf5Writer& file, const Certificate& certificate);

/// Its outputs come in the order of their names.
/// @throws InputError, naming the attribute, for one that is missing or cannot be
Certificate read_certificate(const io::Hdf5Reader& file);

}  // namespace samara::codebooks
