#include "file_fuzz.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

#include <fmt/format.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "../io/temporary_directory.h"
#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/place_query.h"
#include "samara/codebooks/query/query.h"

// The library's own checksums.
extern "C" std::uint32_t H5_checksum_fletcher32(const void* data, std::size_t size);
extern "C" std::uint32_t H5_checksum_metadata(const void* data, std::size_t size, std::uint32_t initial);

namespace file_fuzz {

namespace {

using namespace samara::codebooks;

std::uint32_t word_at(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t k = 4; k-- > 0;) word = word << 8 | static_cast<unsigned char>(bytes[at + k]);
  return word;
}

void put_word(std::string& bytes, std::size_t at, std::uint32_t word) {
  for (std::size_t k = 0; k < 4; ++k, word >>= 8) bytes[at + k] = static_cast<char>(word & 0xff);
}

/// Bytes that a checksum of four bytes after them guards.
struct Guarded {
  std::size_t begin = 0;
  std::size_t size = 0;
  bool is_data = false;  ///< of a chunk, not of metadata

  std::uint32_t checksum(const std::string& bytes) const {
    return is_data ? H5_checksum_fletcher32(bytes.data() + begin, size)
                   : H5_checksum_metadata(bytes.data() + begin, size, 0);
  }
};

/// Metadata: after a signature, the length whose checksum is right.
std::vector<Guarded> guarded_metadata(const std::string& bytes) {
  constexpr std::array kSignatures = {"OHDR", "OCHK", "BTHD", "BTIN", "BTLF", "FRHP", "FHIB",
                                      "FAHD", "FADB", "EAHD", "EAIB", "EASB", "EADB"};
  std::vector<Guarded> blocks = {{0, 44, false}};  // the superblock
  for (const char* signature : kSignatures) {
    for (std::size_t at = bytes.find(signature); at != std::string::npos;
         at = bytes.find(signature, at + 1)) {
      for (std::size_t size = 8; size < 4096 && at + size + 4 <= bytes.size(); ++size) {
        const Guarded block{at, size, false};
        if (block.checksum(bytes) != word_at(bytes, at + size)) continue;
        blocks.push_back(block);
        break;
      }
    }
  }
  return blocks;
}

herr_t add_chunks(hid_t file, const char* name, const H5O_info_t* info, void* kept) {
  if (info->type != H5O_TYPE_DATASET) return 0;
  const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
  const hid_t creation = H5Dget_create_plist(dataset);
  const hid_t space = H5Dget_space(dataset);
  hsize_t count = 0;
  if (H5Pget_layout(creation) == H5D_CHUNKED) H5Dget_num_chunks(dataset, space, &count);
  for (hsize_t i = 0; i < count; ++i) {
    std::array<hsize_t, 8> offset = {};
    unsigned mask = 0;
    haddr_t address = 0;
    hsize_t size = 0;
    H5Dget_chunk_info(dataset, space, i, offset.data(), &mask, &address, &size);
    static_cast<std::vector<Guarded>*>(kept)->push_back({address, size - 4, true});
  }
  H5Sclose(space);
  H5Pclose(creation);
  H5Dclose(dataset);
  return 0;
}

std::vector<Guarded> guarded_data(const std::filesystem::path& path) {
  std::vector<Guarded> chunks;
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  H5Ovisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, add_chunks, &chunks);
  H5Fclose(file);
  return chunks;
}

class Mutations {
 public:
  Mutations(std::string whole, std::vector<Guarded> blocks, std::uint64_t seed)
      : whole_(std::move(whole)), blocks_(std::move(blocks)), seed_(seed) {}

  static bool is_repaired(int index) { return index % 2 == 1; }

  std::string operator()(int index) const {
    std::mt19937_64 random(seed_ + 1000003 * static_cast<std::uint64_t>(index));
    const auto below = [&](std::size_t limit) { return static_cast<std::size_t>(random() % limit); };
    std::string bytes = whole_;
    if (!is_repaired(index) && below(8) == 0) {
      bytes.resize(below(bytes.size()));
      return bytes;
    }
    if (!is_repaired(index)) {
      change(bytes, 0, bytes.size(), below);
      return bytes;
    }
    // Several blocks, now and then: damage that fits together.
    for (std::size_t n = 1 + (below(4) == 0 ? below(4) : 0); n-- > 0;) {
      const Guarded& block = blocks_[below(blocks_.size())];
      change(bytes, block.begin, block.size, below);
      put_word(bytes, block.begin + block.size, block.checksum(bytes));
    }
    return bytes;
  }

 private:
  template <class Below>
  static void change(std::string& bytes, std::size_t begin, std::size_t size, const Below& below) {
    const std::size_t at = begin + below(size);
    const std::size_t length = std::min(begin + size - at, 1 + below(8));
    switch (below(5)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(below(256));
        break;
      case 2:
        bytes.replace(at, length, length, below(2) == 0 ? '\0' : '\xff');
        break;
      case 3: {
        const std::size_t from = begin + below(size - length + 1);
        bytes.replace(at, length, std::string(bytes, from, length));
        break;
      }
      default:
        for (std::size_t k = 0; k < length; ++k) bytes[at + k] = static_cast<char>(below(256));
    }
  }

  std::string whole_;
  std::vector<Guarded> blocks_;
  std::uint64_t seed_;
};

/// Asks a codebook at corners and in the middle of its box; typed errors are answers.
void ask(const Codebook& book) {
  try {
    Query query(book);
    Eigen::VectorXd values(book.output_count());
    Eigen::MatrixXd gradient(book.output_count(), book.coordinate_count());
    for (const double place : {0.0, 0.5, 1.0}) {
      std::vector<double> x;
      for (const Coordinate& c : book.coordinates()) x.push_back(c.lower + place * (c.upper - c.lower));
      query.values(x, values, gradient);
    }
    if (book.mesh() == nullptr) return;
    PlaceQuery in_mesh(book);
    std::vector<double> x;
    for (const Coordinate& c : in_mesh.coordinates()) x.push_back(0.5 * (c.lower + c.upper));
    in_mesh.values(x, values);
  } catch (const samara::Error&) {
  }
}

/// What becomes of a file: refused, same, other, or a failure 'x'.
char verdict(const std::filesystem::path& path, const std::filesystem::path& again,
             const std::string& whole) {
  try {
    const Codebook book = load(path);
    ask(book);
    save(book, again);
    return content(again) == whole ? 's' : 'o';
  } catch (const samara::InputError&) {
    return 'r';
  } catch (const std::exception&) {
    return 'x';
  }
}

/// Reads the files first .. last - 1 in a child. @returns its verdicts, as far as it came
std::string verdicts(const Mutations& mutations, int first, int last, const std::filesystem::path& folder,
                     const std::string& whole) {
  std::array<int, 2> ends = {};
  if (::pipe(ends.data()) != 0) return {};
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
#ifndef __SANITIZE_ADDRESS__
    const rlimit memory = {rlim_t{1} << 32, rlim_t{1} << 32};
    ::setrlimit(RLIMIT_AS, &memory);
#endif
    const rlimit no_core = {0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    for (int i = first; i < last; ++i) {
      put_content(folder / "mutated.h5", mutations(i));
      ::alarm(10);
      const char found = verdict(folder / "mutated.h5", folder / "again.h5", whole);
      if (::write(ends[1], &found, 1) != 1) ::_exit(1);
    }
    ::_exit(0);
  }
  ::close(ends[1]);
  std::string found;
  char one = 0;
  while (::read(ends[0], &one, 1) == 1) found += one;
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  return found;
}

}  // namespace

Report fuzz(const Codebook& book, int count, std::uint64_t seed) {
  const TemporaryDirectory directory;
  save(book, directory / "whole.h5");
  const std::string whole = content(directory / "whole.h5");
  std::vector<Guarded> blocks = guarded_metadata(whole);
  for (const Guarded& chunk : guarded_data(directory / "whole.h5")) blocks.push_back(chunk);
  const Mutations mutations(whole, blocks, seed);
  Report report;
  constexpr int kPerChild = 50;
  for (int first = 0; first < count;) {
    const int last = std::min(count, first + kPerChild);
    std::string found = verdicts(mutations, first, last, directory.path(), whole);
    // A child that ended early was ended by the file that it had in hand.
    if (static_cast<int>(found.size()) < last - first) found += 'x';
    for (const char verdict : found) {
      const bool repaired = Mutations::is_repaired(first);
      report.refused += verdict == 'r' ? 1 : 0;
      report.same += verdict == 's' ? 1 : 0;
      report.other += verdict == 'o' && repaired ? 1 : 0;
      report.repaired += repaired ? 1 : 0;
      if (verdict == 'x' || (verdict == 'o' && !repaired)) {
        ++report.failures;
        if (report.failed_files.size() < 10) report.failed_files.push_back(mutations(first));
        if (report.first_failure.empty()) {
          report.first_failure =
              fmt::format("mutation {} of seed {}: {}", first, seed,
                          verdict == 'x' ? "a crash, a hang or another error" : "another codebook");
        }
      }
      ++report.mutated;
      ++first;
    }
  }
  return report;
}

}  // namespace file_fuzz
