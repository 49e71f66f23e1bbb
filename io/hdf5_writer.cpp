#include "samara/io/hdf5_writer.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>

#include <hdf5_hl.h>

#include "samara/base/errors.h"
#include "samara/io/atomic_file.h"
#include "samara/io/hdf5_library.h"

namespace samara::io {

using hdf5::Handle;
using hdf5::Session;

namespace {

Handle property_list(hid_t kind) {
  return Handle(H5Pcreate(kind), H5Pclose);
}

/// Times would make two files with the same content differ. Attributes stay with their object: the heap into
/// which the library puts more than eight of them is slow to read.
Handle untimed(hid_t kind) {
  constexpr unsigned kMostAttributes = 64, kLeastInHeap = 48;
  Handle list = property_list(kind);
  H5Pset_obj_track_times(list.get(), false);
  H5Pset_attr_phase_change(list.get(), kMostAttributes, kLeastInHeap);
  return list;
}

/// The bytes of a file that the library builds in memory: it does not survive a disk that is full (a file
/// whose flush failed cannot be closed, and crashes the process when it ends), so no disk is shown to it.
class Image {
 public:
  /// Makes files that are opened with this list be built here.
  void attach(const Handle& access) {
    constexpr std::size_t kIncrement = 1 << 20;
    H5Pset_fapl_core(access.get(), kIncrement, false);
    H5FD_file_image_callbacks_t callbacks{allocate, copy_bytes, resize, release, copy_self, free_self, this};
    H5Pset_file_image_callbacks(access.get(), &callbacks);
  }

  /// The file, once it is closed. (H5Fget_file_image() of an open file has a wrong checksum in its
  /// superblock.)
  std::string_view file() const {
    // The memory is longer than the file. Where the file ends stands in its superblock (version 2, 3).
    constexpr std::size_t kEndOfFile = 28;
    std::uint64_t end = 0;
    const std::string_view bytes(closed_.get(), closed_ ? size_ : 0);
    if (bytes.size() < kEndOfFile + sizeof end) return {};
    for (std::size_t i = sizeof end; i-- > 0;)
      end = 256 * end + static_cast<unsigned char>(bytes[kEndOfFile + i]);
    return bytes.substr(0, static_cast<std::size_t>(end));
  }

 private:
  struct Free {
    void operator()(char* memory) const { std::free(memory); }
  };
  using Memory = std::unique_ptr<char, Free>;

  static void* allocate(std::size_t size, H5FD_file_image_op_t, void*) { return std::malloc(size); }
  static void* copy_bytes(void* to, const void* from, std::size_t size, H5FD_file_image_op_t, void*) {
    return std::memcpy(to, from, size);
  }
  static void* resize(void* memory, std::size_t size, H5FD_file_image_op_t, void* self) {
    void* const moved = std::realloc(memory, size);
    if (moved != nullptr) static_cast<Image*>(self)->size_ = size;
    return moved;
  }
  static herr_t release(void* memory, H5FD_file_image_op_t operation, void* self) {
    Memory owned(static_cast<char*>(memory));
    if (operation == H5FD_FILE_IMAGE_OP_FILE_CLOSE) static_cast<Image*>(self)->closed_ = std::move(owned);
    return 0;
  }
  static void* copy_self(void* self) { return self; }
  static herr_t free_self(void*) { return 0; }

  Memory closed_;
  std::size_t size_ = 0;
};

/// @param name tells the library's open files apart; nothing is created there
Handle create_file(const std::filesystem::path& name, Image& image) {
  const Handle access = property_list(H5P_FILE_ACCESS);
  image.attach(access);
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
  const Handle creation = untimed(H5P_FILE_CREATE);
  return Handle(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose);
}

/// The extent of an array; none stands for a scalar.
Handle dataspace(std::span<const hsize_t> dimensions) {
  if (dimensions.empty()) return Handle(H5Screate(H5S_SCALAR), H5Sclose);
  return Handle(H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr), H5Sclose);
}

Handle string_type(std::size_t size, bool ascii) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), size);
  H5Tset_strpad(type.get(), H5T_STR_NULLTERM);
  H5Tset_cset(type.get(), ascii ? H5T_CSET_ASCII : H5T_CSET_UTF8);
  return type;
}

bool is_ascii(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

/// How a dataset is stored. Chunks are whole rows of at most 512 KiB where rows are shorter than that.
Handle storage(std::span<const hsize_t> dimensions, std::size_t element_size) {
  Handle list = untimed(H5P_DATASET_CREATE);
  if (std::find(dimensions.begin(), dimensions.end(), hsize_t{0}) != dimensions.end()) return list;
  constexpr hsize_t kChunkBytes = 512 * 1024;
  hsize_t room = std::max<hsize_t>(kChunkBytes / element_size, 1);
  std::vector<hsize_t> chunk(dimensions.begin(), dimensions.end());
  for (std::size_t k = chunk.size(); k-- > 0;) {
    chunk[k] = std::min(chunk[k], room);
    room = std::max<hsize_t>(room / chunk[k], 1);
  }
  constexpr unsigned kDeflateLevel = 6;
  H5Pset_chunk(list.get(), static_cast<int>(chunk.size()), chunk.data());
  H5Pset_shuffle(list.get());
  H5Pset_deflate(list.get(), kDeflateLevel);
  H5Pset_fletcher32(list.get());  // last, so that it guards what stands on the disk
  return list;
}

std::string parent(const std::string& path) {
  return path.substr(0, path.rfind('/'));
}

}  // namespace

struct Hdf5Writer::Impl {
  PendingFile pending;
  Image image;
  Handle file;  // closed before the image goes

  explicit Impl(const std::filesystem::path& path) : pending(path) {
    const Session session;
    file = create_file(pending.path(), image);
    if (!file.valid()) fail("/", hdf5::last_reason());
  }
  ~Impl() {
    if (!file.valid()) return;
    const Session session;
    file.close();
  }

  [[noreturn]] void fail(const std::string& object, const std::string& reason) const {
    throw ArgumentError("cannot write " + object + " of \"" + pending.final_path().string() +
                        "\": " + reason);
  }

  void check(bool success, const std::string& object) const {
    if (!success) fail(object, hdf5::last_reason());
  }

  bool exists(const std::string& path) const { return H5Lexists(file.get(), path.c_str(), H5P_DEFAULT) > 0; }

  void ensure_group(const std::string& path) const {
    std::string at;
    for (const std::string& name : hdf5::components(path)) {
      at += "/" + name;
      if (exists(at)) {
        const Handle object = open(at);
        if (H5Iget_type(object.get()) != H5I_GROUP) fail(path, at + " is not a group");
        continue;
      }
      const Handle creation = untimed(H5P_GROUP_CREATE);
      const Handle group(H5Gcreate2(file.get(), at.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                         H5Gclose);
      check(group.valid(), at);
    }
  }

  Handle open(const std::string& path) const {
    Handle object(H5Oopen(file.get(), path.c_str(), H5P_DEFAULT), H5Oclose);
    if (!object.valid()) fail(path, "there is no such object");
    return object;
  }

  Handle open_dataset(const std::string& path) const {
    Handle object = open(path);
    if (H5Iget_type(object.get()) != H5I_DATASET) fail(path, "it is not a dataset");
    return object;
  }

  void write_attribute(const std::string& path, const std::string& name, std::span<const hsize_t> dimensions,
                       hid_t file_type, hid_t memory_type, const void* values) const {
    const Handle object = open(path);
    const std::string what = "attribute \"" + name + "\" of " + path;
    if (name.empty()) fail(what, "the name is empty");
    if (H5Aexists(object.get(), name.c_str()) > 0) fail(what, "it exists already");
    const Handle space = dataspace(dimensions);
    const Handle attribute(
        H5Acreate2(object.get(), name.c_str(), file_type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(attribute.valid() && H5Awrite(attribute.get(), memory_type, values) >= 0, what);
  }

  void write_dataset(const std::string& path, std::span<const hsize_t> dimensions, hid_t file_type,
                     hid_t memory_type, const void* values) const {
    if (path == "/") fail(path, "the root is a group");
    ensure_group(parent(path));
    if (exists(path)) fail(path, "it exists already");
    const Handle space = dataspace(dimensions);
    const Handle creation = storage(dimensions, H5Tget_size(file_type));
    const Handle dataset(H5Dcreate2(file.get(), path.c_str(), file_type, space.get(), H5P_DEFAULT,
                                    creation.get(), H5P_DEFAULT),
                         H5Dclose);
    check(dataset.valid(), path);
    if (H5Sget_simple_extent_npoints(space.get()) == 0) return;
    check(H5Dwrite(dataset.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0, path);
  }
};

Hdf5Writer::Hdf5Writer(const std::filesystem::path& path) : impl_(std::make_unique<Impl>(path)) {}
Hdf5Writer::~Hdf5Writer() = default;
Hdf5Writer::Hdf5Writer(Hdf5Writer&&) noexcept = default;
Hdf5Writer& Hdf5Writer::operator=(Hdf5Writer&&) noexcept = default;

Hdf5Writer::Impl& Hdf5Writer::open_file() const {
  if (!impl_) throw ArgumentError("an Hdf5Writer was used after commit() or after it was moved from");
  return *impl_;
}

void Hdf5Writer::create_group(const std::string& path) {
  const Impl& impl = open_file();
  const Session session;
  impl.ensure_group(path);
}

void Hdf5Writer::write_text_attribute(const std::string& object, const std::string& name,
                                      std::string_view value) {
  const Impl& impl = open_file();
  const std::string text(value);
  if (text.find('\0') != std::string::npos)
    impl.fail("attribute \"" + name + "\" of " + object, "a zero byte in it");
  const Session session;
  const Handle type = string_type(text.size() + 1, is_ascii(text));
  impl.write_attribute(hdf5::absolute(object), name, {}, type.get(), type.get(), text.c_str());
}

void Hdf5Writer::write_integer_attribute(const std::string& object, const std::string& name,
                                         std::int64_t value) {
  const Impl& impl = open_file();
  const Session session;
  impl.write_attribute(hdf5::absolute(object), name, {}, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}

void Hdf5Writer::write_number_attribute(const std::string& object, const std::string& name, double value) {
  const Impl& impl = open_file();
  const Session session;
  impl.write_attribute(hdf5::absolute(object), name, {}, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5Writer::write_numbers_attribute(const std::string& object, const std::string& name,
                                         std::span<const double> values) {
  const Impl& impl = open_file();
  const Session session;
  const std::array<hsize_t, 1> size = {values.size()};
  const double none = 0.0;  // the library wants a pointer also where there is nothing
  impl.write_attribute(hdf5::absolute(object), name, size, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                       values.empty() ? &none : values.data());
}

void Hdf5Writer::write_vector(const std::string& path, const Eigen::Ref<const Eigen::VectorXd>& values) {
  const Impl& impl = open_file();
  const Session session;
  const std::array<hsize_t, 1> size = {static_cast<hsize_t>(values.size())};
  impl.write_dataset(hdf5::absolute(path), size, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data());
}

void Hdf5Writer::write_matrix(const std::string& path, const Eigen::Ref<const Eigen::MatrixXd>& values) {
  const Impl& impl = open_file();
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows_first = values;
  const Session session;
  const std::array<hsize_t, 2> size = {static_cast<hsize_t>(values.rows()),
                                       static_cast<hsize_t>(values.cols())};
  impl.write_dataset(hdf5::absolute(path), size, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, rows_first.data());
}

void Hdf5Writer::write_block(const std::string& path, const std::array<Eigen::Index, 3>& size,
                             std::span<const double> values) {
  const Impl& impl = open_file();
  if (static_cast<Eigen::Index>(values.size()) != size[0] * size[1] * size[2])
    impl.fail(path, "the block does not have the size that is said of it");
  const Session session;
  const std::array<hsize_t, 3> extents = {static_cast<hsize_t>(size[0]), static_cast<hsize_t>(size[1]),
                                          static_cast<hsize_t>(size[2])};
  impl.write_dataset(hdf5::absolute(path), extents, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data());
}

void Hdf5Writer::write_texts(const std::string& path, const std::vector<std::string>& texts) {
  const Impl& impl = open_file();
  std::size_t width = 1;
  bool ascii = true;
  for (const std::string& text : texts) {
    if (text.find('\0') != std::string::npos) impl.fail(path, "a text has a zero byte in it");
    width = std::max(width, text.size() + 1);
    ascii = ascii && is_ascii(text);
  }
  std::vector<char> packed(width * texts.size(), '\0');
  for (std::size_t i = 0; i < texts.size(); ++i) {
    std::copy(texts[i].begin(), texts[i].end(), packed.begin() + static_cast<std::ptrdiff_t>(i * width));
  }
  const Session session;
  const Handle type = string_type(width, ascii);
  const std::array<hsize_t, 1> size = {texts.size()};
  impl.write_dataset(hdf5::absolute(path), size, type.get(), type.get(), packed.data());
}

void Hdf5Writer::make_scale(const std::string& dataset, const std::string& name) {
  const Impl& impl = open_file();
  const Session session;
  const Handle scale = impl.open_dataset(hdf5::absolute(dataset));
  impl.check(H5DSset_scale(scale.get(), name.c_str()) >= 0, dataset);
}

void Hdf5Writer::attach_scale(const std::string& dataset, unsigned dimension, const std::string& scale) {
  const Impl& impl = open_file();
  const Session session;
  const Handle target = impl.open_dataset(hdf5::absolute(dataset));
  const Handle source = impl.open_dataset(hdf5::absolute(scale));
  if (H5DSis_scale(source.get()) <= 0) impl.fail(scale, "it is not a dimension scale");
  const Handle space(H5Dget_space(target.get()), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0 || dimension >= static_cast<unsigned>(rank)) {
    impl.fail(dataset, "it has no dimension " + std::to_string(dimension));
  }
  impl.check(H5DSattach_scale(target.get(), source.get(), dimension) >= 0, dataset);
}

void Hdf5Writer::commit() {
  Impl& impl = open_file();
  {
    const Session session;
    impl.check(H5Fflush(impl.file.get(), H5F_SCOPE_GLOBAL) >= 0, "/");
    impl.check(impl.file.close(), "/");
  }
  impl.pending.write(impl.image.file());
  impl.pending.commit();
  impl_.reset();
}

}  // namespace samara::io
