#include "samara/codebooks/file/save.h"

#include <fmt/format.h>

#include "samara/base/version.h"
#include "samara/codebooks/file/certificate_format.h"
#include "samara/codebooks/file/description_format.h"
#include "samara/codebooks/file/file_format.h"
#include "samara/codebooks/file/mesh_format.h"
#include "samara/codebooks/file/piece_format.h"
#include "samara/io/hdf5_writer.h"

namespace samara::codebooks {

void save(const Codebook& book, const std::filesystem::path& path) {
  io::Hdf5Writer file(path);
  file.write_text_attribute("/", "format", format::kFormat);
  file.write_text_attribute("/", "format_version", fmt::format("{}.{}", format::kMajor, format::kMinor));
  file.write_text_attribute("/", "generator", fmt::format("samara {}", version()));
  file.write_text_attribute("/", "model", book.model().name);
  file.write_text_attribute("/", "title", book.title());
  for (std::size_t k = 0; k < book.pieces().size(); ++k)
    write_piece(file, fmt::format("/pieces/{}", k), book.pieces()[k]);
  if (book.mesh() != nullptr) write_mesh(file, *book.mesh());
  if (book.certificate()) write_certificate(file, *book.certificate());
  write_model(file, book.model());
  write_build(file, book.build());
  write_provenance(file, book.provenance());
  file.commit();
}

}  // namespace samara::codebooks
