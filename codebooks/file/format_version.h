#pragma once

/// Names in the codebook file, shared by its writer and its reader.
namespace samara::codebooks::format {

inline constexpr const char* kFormat = "samara-codebook";
inline constexpr int kMajor = 0;
inline constexpr int kMinor = 6;
inline constexpr const char* kSum = "sum_of_products";
inline constexpr const char* kTrain = "train";

}  // namespace samara::codebooks::format
