#include "samara/io/hdf5_library.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "samara/base/errors.h"

namespace samara::io::hdf5 {

namespace {
std::mutex library_mutex;

/// Keeps the first description it is shown, which is that of the innermost function.
herr_t keep_first(unsigned, const H5E_error2_t* error, void* kept) {
  auto& reason = *static_cast<std::string*>(kept);
  if (reason.empty() && error->desc != nullptr) reason = error->desc;
  return 0;
}
}  // namespace

Session::Session() : lock_(library_mutex) {
  // HDF5 1.10 loses track of memory when it meets damaged metadata, and complains on stderr when the process
  // ends. What is registered after its own handler for the exit runs before it.
  [[maybe_unused]] static const bool silent_at_exit =
      H5open() >= 0 && std::atexit([] { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }) == 0;
  H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Session::~Session() {
  H5Eset_auto2(H5E_DEFAULT, print_, print_data_);
}

Handle::Handle(Handle&& other) noexcept
    : id_(std::exchange(other.id_, -1)), close_(std::exchange(other.close_, nullptr)) {}

Handle& Handle::operator=(Handle&& other) noexcept {
  if (this == &other) return *this;
  close();
  id_ = std::exchange(other.id_, -1);
  close_ = std::exchange(other.close_, nullptr);
  return *this;
}

bool Handle::close() {
  if (!valid()) return true;
  return close_(std::exchange(id_, -1)) >= 0;
}

std::string last_reason() {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, &reason);
  return reason.empty() ? "no reason given" : reason;
}

std::vector<std::string> components(const std::string& path) {
  std::vector<std::string> names;
  std::size_t at = path.starts_with('/') ? 1 : 0;
  while (at < path.size()) {
    const std::size_t end = std::min(path.find('/', at), path.size());
    names.push_back(path.substr(at, end - at));
    if (names.back().empty() || names.back() == "." || names.back() == "..") {
      throw ArgumentError("the HDF5 path \"" + path + "\" has the name \"" + names.back() + "\" in it");
    }
    at = end + 1;
  }
  return names;
}

std::string absolute(const std::string& path) {
  std::string joined;
  for (const std::string& name : components(path)) joined += "/" + name;
  return joined.empty() ? "/" : joined;
}

}  // namespace samara::io::hdf5
