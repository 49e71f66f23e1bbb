#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

#include "samara/codebooks/query/kernels/kernels.h"

namespace samara::codebooks::kernels {

/// Numbers on a border of vectors, zero at first, with a vector more after the last one, so that kernels may
/// read and write beyond the end.
template <class T>
class Buffer {
 public:
  Buffer() = default;
  explicit Buffer(std::ptrdiff_t size) : size_(padded<T>(size) + kLanes<T>) {
    const auto bytes = static_cast<std::size_t>(size_) * sizeof(T);
    data_.reset(static_cast<T*>(::operator new(bytes, std::align_val_t(kVectorBytes))));
    std::fill_n(data_.get(), size_, T(0));
  }
  Buffer(const Buffer& other) : Buffer() {
    if (other.size_ == 0) return;
    *this = Buffer(other.size_ - kLanes<T>);
    std::copy_n(other.data_.get(), size_, data_.get());
  }
  Buffer(Buffer&&) noexcept = default;
  Buffer& operator=(const Buffer& other) { return *this = Buffer(other); }
  Buffer& operator=(Buffer&&) noexcept = default;
  ~Buffer() = default;

  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }

 private:
  struct Free {
    void operator()(T* data) const { ::operator delete(data, std::align_val_t(kVectorBytes)); }
  };
  std::ptrdiff_t size_ = 0;
  std::unique_ptr<T, Free> data_;
};

}  // namespace samara::codebooks::kernels
