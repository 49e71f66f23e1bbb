#include "samara/io/hdf5_dataset.h"

#include <algorithm>
#include <string_view>

#include "samara/base/errors.h"

namespace samara::io::hdf5 {

namespace {

/// What a dataset may unpack to: deflate, the strongest of the filters in use, shortens at most 1032 times.
std::uint64_t largest_size(const File& file) {
  constexpr std::uint64_t kStrongestPacking = 1040;
  return file.bytes * kStrongestPacking;
}

/// Refuses sizes that the file cannot hold, before any memory is taken for them.
void check_size(const File& file, const Source& source) {
  constexpr hsize_t kMostElements = hsize_t{1} << 31;
  const std::uint64_t limit = largest_size(file);
  std::uint64_t bytes = H5Tget_size(source.type.get());
  if (bytes == 0) file.fail(source.what, "has elements of no size");
  hsize_t elements = 1;
  const bool is_empty =
      std::find(source.dimensions.begin(), source.dimensions.end(), 0u) != source.dimensions.end();
  for (const hsize_t size : source.dimensions) {
    if (is_empty) break;
    if (size > kMostElements / elements || size > limit / bytes) {
      file.fail(source.what, "its size is beyond what the file can hold");
    }
    elements *= size;
    bytes *= size;
  }
  if (bytes > limit) file.fail(source.what, "its size is beyond what the file can hold");
}

/// Missing chunks would silently read as zeros.
void check_chunks(const File& file, const Source& source, hid_t creation) {
  std::vector<hsize_t> chunk(source.dimensions.size());
  H5Pget_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
  std::uint64_t bytes = H5Tget_size(source.type.get());
  hsize_t expected = 1;
  for (std::size_t k = 0; k < chunk.size(); ++k) {
    if (chunk[k] == 0 || chunk[k] > largest_size(file) / bytes) {
      file.fail(source.what, "its chunks are larger than the file can hold");
    }
    bytes *= chunk[k];
    expected *= (source.dimensions[k] + chunk[k] - 1) / chunk[k];
  }
  const Handle space(H5Dget_space(source.object.get()), H5Sclose);
  hsize_t stored = 0;
  if (H5Dget_num_chunks(source.object.get(), space.get(), &stored) < 0) {
    file.fail(source.what, "cannot be read: " + last_reason());
  }
  if (stored != expected) {
    file.fail(source.what, "is incomplete: " + std::to_string(stored) + " of " + std::to_string(expected) +
                               " chunks are stored");
  }
}

/// The library unpacks a chunk and takes for granted that it is as long as its elements. Shuffling knows
/// their size as well, and chunks whose filters were left out are none of ours.
void check_filters(const File& file, const Source& source, hid_t creation) {
  const int filters = H5Pget_nfilters(creation);
  for (int i = 0; i < filters; ++i) {
    unsigned flags = 0;
    std::size_t count = 1;
    unsigned element = 0;
    if (H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &count, &element, 0, nullptr, nullptr) !=
        H5Z_FILTER_SHUFFLE)
      continue;
    if (element != H5Tget_size(source.type.get()))
      file.fail(source.what, "its filters are for elements of another size");
  }
  const Handle space(H5Dget_space(source.object.get()), H5Sclose);
  hsize_t chunks = 0;
  H5Dget_num_chunks(source.object.get(), space.get(), &chunks);
  std::vector<hsize_t> offset(source.dimensions.size());
  for (hsize_t i = 0; i < chunks; ++i) {
    unsigned left_out = 0;
    haddr_t address = 0;
    hsize_t size = 0;
    if (H5Dget_chunk_info(source.object.get(), space.get(), i, offset.data(), &left_out, &address, &size) < 0)
      file.fail(source.what, "cannot be read: " + last_reason());
    if (left_out != 0) file.fail(source.what, "has a chunk whose filters were left out");
  }
}

/// All elements must stand in this file.
void check_stored(const File& file, const Source& source) {
  if (source.is_attribute || source.elements() == 0) return;
  const Handle creation(H5Dget_create_plist(source.object.get()), H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(creation.get());
  if (layout == H5D_CHUNKED) {
    check_chunks(file, source, creation.get());
    check_filters(file, source, creation.get());
    return;
  }
  if (layout == H5D_CONTIGUOUS) {
    const std::uint64_t bytes = source.elements() * H5Tget_size(source.type.get());
    if (H5Pget_external_count(creation.get()) != 0) file.fail(source.what, "is stored outside the file");
    if (H5Dget_storage_size(source.object.get()) < bytes) file.fail(source.what, "is incomplete");
    return;
  }
  if (layout != H5D_COMPACT) file.fail(source.what, "has an unknown layout");
  // The library copies as many bytes as the size says from as many as are stored.
  if (H5Dget_storage_size(source.object.get()) < source.elements() * H5Tget_size(source.type.get()))
    file.fail(source.what, "is incomplete");
}

void read_raw(const File& file, const Source& source, hid_t memory_type, void* values) {
  const herr_t status =
      source.is_attribute ? H5Aread(source.object.get(), memory_type, values)
                          : H5Dread(source.object.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
  if (status < 0) file.fail(source.what, "cannot be read: " + last_reason());
}

/// Fills in type and extent of an open object.
void describe(const File& file, Source& source) {
  if (!source.object.valid()) file.fail(source.what, "cannot be opened: " + last_reason());
  const hid_t id = source.object.get();
  source.type = Handle(source.is_attribute ? H5Aget_type(id) : H5Dget_type(id), H5Tclose);
  const Handle space(source.is_attribute ? H5Aget_space(id) : H5Dget_space(id), H5Sclose);
  if (!source.type.valid() || !space.valid()) file.fail(source.what, "cannot be opened: " + last_reason());
  if (H5Sget_simple_extent_type(space.get()) == H5S_NULL) file.fail(source.what, "holds nothing");
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0) file.fail(source.what, "cannot be opened: " + last_reason());
  source.dimensions.resize(static_cast<std::size_t>(rank));
  if (rank > 0) H5Sget_simple_extent_dims(space.get(), source.dimensions.data(), nullptr);
  check_size(file, source);
}

}  // namespace

void File::fail(const std::string& object, const std::string& sentence) const {
  throw InputError(name, object + ": " + sentence);
}

hsize_t Source::elements() const {
  hsize_t count = 1;
  for (const hsize_t size : dimensions) count *= size;
  return count;
}

Presence presence(const File& file, const std::string& path) {
  std::string at;
  for (const std::string& name : components(path)) {
    at += "/" + name;
    const htri_t found = H5Lexists(file.handle.get(), at.c_str(), H5P_DEFAULT);
    if (found == 0) return Presence::missing;
    H5L_info_t link;
    if (found < 0 || H5Lget_info(file.handle.get(), at.c_str(), &link, H5P_DEFAULT) < 0)
      return Presence::unreadable;
    if (link.type != H5L_TYPE_HARD) return Presence::missing;
  }
  return Presence::there;
}

Handle open_object(const File& file, const std::string& path, const std::string& what) {
  const Presence found = presence(file, path);
  if (found == Presence::missing) file.fail(what, "is missing");
  Handle object;
  if (found == Presence::there)
    object = Handle(H5Oopen(file.handle.get(), path.c_str(), H5P_DEFAULT), H5Oclose);
  if (!object.valid()) file.fail(what, "cannot be opened: " + last_reason());
  return object;
}

const Handle& open_owner(const File& file, const std::string& path) {
  if (!file.owner.valid() || file.owner_path != path) {
    file.owner = open_object(file, path, path);
    file.owner_path = path;
  }
  return file.owner;
}

Source open_dataset(const File& file, const std::string& path) {
  Source source;
  source.what = "dataset " + path;
  source.object = open_object(file, path, source.what);
  if (H5Iget_type(source.object.get()) != H5I_DATASET)
    file.fail(source.what, "expected a dataset, found a group");
  describe(file, source);
  return source;
}

Source open_attribute(const File& file, const std::string& path, const std::string& name) {
  Source source;
  source.what = "attribute \"" + name + "\" of " + path;
  source.is_attribute = true;
  const Handle& owner = open_owner(file, path);
  const htri_t found = H5Aexists(owner.get(), name.c_str());
  if (found < 0) file.fail(source.what, "cannot be opened: " + last_reason());
  if (found == 0) file.fail(source.what, "is missing");
  source.object = Handle(H5Aopen(owner.get(), name.c_str(), H5P_DEFAULT), H5Aclose);
  describe(file, source);
  return source;
}

void check_doubles(const File& file, const Source& source) {
  const H5T_class_t kind = H5Tget_class(source.type.get());
  const bool whole_allowed = source.is_attribute;
  if (kind != H5T_FLOAT && !(whole_allowed && kind == H5T_INTEGER))
    file.fail(source.what, "expected doubles");
  if (H5Tget_size(source.type.get()) > sizeof(double))
    file.fail(source.what, "expected numbers of at most 64 bits");
  check_stored(file, source);
}

void read_doubles(const File& file, const Source& source, std::span<double> values) {
  if (!values.empty()) read_raw(file, source, H5T_NATIVE_DOUBLE, values.data());
}

std::vector<std::string> read_strings(const File& file, const Source& source) {
  if (H5Tget_class(source.type.get()) != H5T_STRING) file.fail(source.what, "expected text");
  // Damage to the heap that holds strings of variable length goes unnoticed, until it crashes the library.
  if (H5Tis_variable_str(source.type.get()) != 0) {
    file.fail(source.what,
              "expected text of a fixed size, found variable length (h5py: write bytes, not str)");
  }
  if (source.elements() == 0) return {};
  check_stored(file, source);
  const std::size_t width = H5Tget_size(source.type.get());
  std::vector<char> packed(width * source.elements());
  read_raw(file, source, source.type.get(), packed.data());
  const bool space_padded = H5Tget_strpad(source.type.get()) == H5T_STR_SPACEPAD;
  std::vector<std::string> texts;
  texts.reserve(source.elements());
  for (std::size_t at = 0; at < packed.size(); at += width) {
    std::string_view text(packed.data() + at, width);
    text = text.substr(0, text.find('\0'));
    if (space_padded) text = text.substr(0, text.find_last_not_of(' ') + 1);
    texts.emplace_back(text);
  }
  return texts;
}

}  // namespace samara::io::hdf5
