#pragma once

/// The codebook file (docs/codebook_file.md): its version, raised by whatever changes what files hold, and names that
/// its writer and its reader share. How its parts stand there: pieces, axes and fields in piece_format.h, the mesh in
/// mesh_format.h, a front in front_format.h, the certificate in certificate_format.h, model, build and provenance in
/// description_format.h; save.h and load.h put them together. A raised version needs another golden
/// file (tests/codebooks/golden); the flat file for other programs (flat_file.h) is a format of its own.
namespace samara::codebooks::format {

inline constexpr const char* kFormat = "samara-codebook";
inline constexpr int kMajor = 0;
inline constexpr int kMinor = 7;
inline constexpr const char* kSum = "sum_of_products";
inline constexpr const char* kTrain = "train";

}  // namespace samara::codebooks::format
