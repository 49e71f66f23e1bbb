#pragma once

#include <map>
#include <string>

#include "samara/codebooks/book/codebook.h"
#include "samara/flow/files/flow_file.h"

/// Single flows out of a codebook of fields (field_book.h).
namespace samara::flow {

/// The name of the model of a codebook of fields.
inline constexpr const char* kFieldBookModel = "flow_fields";

bool is_field_book(const codebooks::Codebook& book);

/// The flow that a field codebook has at a point of its box, for what takes flows: pictures, models that fly in them.
/// Loads are not in it (NaN).
/// @param at angle_of_attack [rad], log10_reynolds: all that the box has
/// @param path of the codebook, relative to which a mesh of its plan is looked for
/// @throws ArgumentError for another codebook or other names; OutsideBoxError; InputError for a plan that is none,
/// or whose mesh has changed
StoredFlow flow_of(const codebooks::Codebook& book, const std::map<std::string, double>& at,
                   const std::string& path, const MeshReader& mesh_reader = {});

}  // namespace samara::flow
