#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <hdf5.h>

#include "samara/io/hdf5_library.h"

/// Reading of single datasets and attributes with all checks; internal to io/. To be called within a Session.
namespace samara::io::hdf5 {

/// An open file, and what its checks and messages need.
struct File {
  Handle handle;
  std::string name;
  std::uint64_t bytes = 0;
  /// The object whose attributes were read last, kept open: one tends to be asked for many.
  mutable Handle owner = {};
  mutable std::string owner_path = {};

  [[noreturn]] void fail(const std::string& object, const std::string& sentence) const;
};

/// An open dataset or attribute with its type and extent.
struct Source {
  Handle object;
  Handle type;
  std::vector<hsize_t> dimensions;  // none for a scalar
  std::string what;                 // "dataset /x", for messages
  bool is_attribute = false;

  /// Number of elements; check_size() says that it does not overflow.
  hsize_t elements() const;
};

enum class Presence { there, missing, unreadable };

/// Whether there is such an object, by hard links all the way.
Presence presence(const File& file, const std::string& path);

/// @throws InputError if it is missing or damaged
Handle open_object(const File& file, const std::string& path, const std::string& what);
/// The same, remembered in the file until another is asked for.
const Handle& open_owner(const File& file, const std::string& path);
Source open_dataset(const File& file, const std::string& path);
Source open_attribute(const File& file, const std::string& object, const std::string& name);

/// @throws InputError if the elements are not doubles or single floats (in attributes also integers), or not
/// all stored in the file. To be called before memory is taken for them.
void check_doubles(const File& file, const Source& source);

/// The elements as doubles, row-major. @throws InputError if they are damaged.
void read_doubles(const File& file, const Source& source, std::span<double> values);

/// Strings of a fixed size. @throws InputError if they are something else, not all stored, or damaged.
std::vector<std::string> read_strings(const File& file, const Source& source);

}  // namespace samara::io::hdf5
