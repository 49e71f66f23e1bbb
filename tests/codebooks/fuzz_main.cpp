/// Usage: codebook_fuzz COUNT [SEED [FOLDER]]
///
/// Reads COUNT mutated codebook files, of several kinds in turn. Ends with 1 if one of them crashed or hung
/// the reader, or gave another answer without a word. Some of those are written to FOLDER, to look into.
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

#include "../io/temporary_directory.h"
#include "file_fuzz.h"
#include "sample_books.h"

#ifdef __SANITIZE_ADDRESS__
// HDF5 1.10 loses memory when it meets damaged metadata.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libhdf5";
}
#endif

namespace {

samara::codebooks::Codebook certified() {
  const samara::codebooks::Codebook book(sample_model(), four_pieces().pieces(), sample_build(),
                                         sample_provenance());
  samara::codebooks::Certificate certificate = sample_certificate(book);
  certificate.norm_defect = {2e-4, 3e-5};
  return book.with_certificate(certificate);
}

/// In a file of more than 1 MiB: pieces are read when they are asked for.
samara::codebooks::Codebook large() {
  std::vector<samara::codebooks::Piece> pieces;
  for (unsigned k = 0; k < 3; ++k) pieces.push_back(random_piece({1.0 * k, 1.0 + k, 0.5, 2.0}, k, 1200));
  return samara::codebooks::Codebook(sample_model(), pieces, sample_build(), sample_provenance());
}

}  // namespace

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 500;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  const samara::codebooks::Codebook books[] = {certified(),   golden_trains(), golden_command(),
                                               golden_mesh(), golden_front(),  large()};
  const int large_count = count / 20;
  int failures = 0;
  for (int k = 0; k < 5; ++k) {
    const int small_count = count - large_count;
    const int share = k == 4 ? large_count : small_count / 4 + (k < small_count % 4 ? 1 : 0);
    const file_fuzz::Report report = file_fuzz::fuzz(books[k], share, seed + static_cast<std::uint64_t>(k));
    std::printf(
        "%d mutated, %d with checksums repaired: %d refused, %d the same, %d other codebooks, %d "
        "failures%s%s\n",
        report.mutated, report.repaired, report.refused, report.same, report.other, report.failures,
        report.first_failure.empty() ? "" : ": ", report.first_failure.c_str());
    for (std::size_t i = 0; argc > 3 && i < report.failed_files.size(); ++i)
      put_content(std::filesystem::path(argv[3]) / fmt::format("{}_{}.h5", k, i), report.failed_files[i]);
    failures += report.failures;
  }
  return failures == 0 ? 0 : 1;
}
