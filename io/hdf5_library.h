#pragma once

#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

#include <hdf5.h>

/// What the HDF5 reader and writer share; internal to io/.
namespace samara::io::hdf5 {

/// Sole use of the HDF5 library for one scope: it is not thread-safe, and prints its errors unless told not
/// to. Every call of the library stands under one of these; it must not be nested.
class Session {
 public:
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

 private:
  std::lock_guard<std::mutex> lock_;
  H5E_auto2_t print_ = nullptr;
  void* print_data_ = nullptr;
};

/// An identifier of the library, closed at the end of its life (inside a Session).
class Handle {
 public:
  using Close = herr_t (*)(hid_t);

  Handle() = default;
  Handle(hid_t id, Close closing) : id_(id), close_(closing) {}
  ~Handle() { close(); }
  Handle(Handle&& other) noexcept;
  Handle& operator=(Handle&& other) noexcept;

  bool valid() const { return id_ >= 0; }
  hid_t get() const { return id_; }
  /// @returns false if the library reports a failure, such as a full disk.
  bool close();

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

/// Why the last call failed, in the library's words.
std::string last_reason();

/// The names along a path: "/pieces/0/x" and "pieces/0/x" give three, "/" none.
/// @throws ArgumentError for empty names, "." and ".."
std::vector<std::string> components(const std::string& path);

/// The path from the root, beginning with a slash.
std::string absolute(const std::string& path);

}  // namespace samara::io::hdf5
