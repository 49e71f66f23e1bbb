#pragma once

#include <string>
#include <vector>

#include "samara/codebooks/book/front_map.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/hdf5_writer.h"
#include "samara/pgd/axes/axis.h"

namespace samara::codebooks {

/// Writes from where a coordinate is counted under the group `path`. @param axes of the piece
void write_front(io::Hdf5Writer& file, const std::string& path, const FrontMap& front,
                 const std::vector<pgd::Axis>& axes);

/// @throws InputError naming the object that is missing or cannot be; ArgumentError as FrontMap
FrontMap read_front(const io::Hdf5Reader& file, const std::string& path, const std::vector<pgd::Axis>& axes);

}  // namespace samara::codebooks
