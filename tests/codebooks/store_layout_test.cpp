// Chunks without a size, guarded by checksums that are right: HDF5 itself would divide by them.
#include <cstdint>

#include "damaged_codebook.h"

using namespace damaged_codebook;
using Catch::Matchers::Contains;

extern "C" std::uint32_t H5_checksum_metadata(const void* data, std::size_t size, std::uint32_t initial);

namespace {

/// The first block of an object's header, up to its checksum, and its message of chunked layout (version 4).
struct Header {
  std::size_t begin = 0, layout = std::string::npos, end = 0;
};

Header header_at(const std::string& bytes, std::size_t begin) {
  const auto byte = [&](std::size_t at) {
    return static_cast<std::size_t>(static_cast<unsigned char>(bytes.at(at)));
  };
  const std::size_t flags = byte(begin + 5), width = std::size_t{1} << (flags & 3);
  std::size_t at = begin + 6 + ((flags & 0x20) != 0 ? 16 : 0) + ((flags & 0x10) != 0 ? 4 : 0);
  std::size_t size = 0;
  for (std::size_t k = width; k-- > 0;) size = size << 8 | byte(at + k);
  at += width;
  Header header{begin, std::string::npos, at + size};
  while (at + 4 <= header.end) {
    if (byte(at) == 8 && byte(at + 4) == 4 && byte(at + 5) == 2) header.layout = at + 4;
    at += 4 + byte(at + 1) + (byte(at + 2) << 8);
  }
  return header;
}

void repair(std::string& bytes, const Header& header) {
  std::uint32_t sum = H5_checksum_metadata(bytes.data() + header.begin, header.end - header.begin, 0);
  for (std::size_t k = 0; k < 4; ++k, sum >>= 8) bytes[header.end + k] = static_cast<char>(sum & 0xff);
}

}  // namespace

TEST_CASE("chunks without dimensions, or of no size, are refused in every dataset") {
  const TemporaryDirectory directory;
  save(certified(), directory / "whole.h5");
  const std::string whole = content(directory / "whole.h5");
  int datasets = 0;
  for (std::size_t at = whole.find("OHDR"); at != std::string::npos; at = whole.find("OHDR", at + 1)) {
    const Header header = header_at(whole, at);
    if (header.layout == std::string::npos) continue;
    ++datasets;
    // The number of sizes; the first size.
    for (const std::size_t place : {header.layout + 3, header.layout + 5}) {
      std::string bytes = whole;
      bytes[place] = 0;
      repair(bytes, header);
      put_content(directory / "book.h5", bytes);
      CHECK_THAT(load_error(directory / "book.h5"), Contains("cannot be opened"));
    }
  }
  CHECK(datasets > 10);
}
