#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#ifdef __SSE2__
#include <immintrin.h>
#endif

#include "samara/codebooks/query/kernels/kernels.h"

/// Vectors of numbers, for the sources of kernels only, which are compiled for the machine: nothing of this
/// may be used elsewhere.
namespace samara::codebooks::kernels {

namespace {

// As long as the registers of the machine: longer vectors the compiler takes apart through memory, at several times
// the cost.
#if defined(__AVX512F__)
constexpr std::size_t kRegisterBytes = 64;
constexpr int kRegisters = 32;
#elif defined(__AVX__)
constexpr std::size_t kRegisterBytes = 32;
constexpr int kRegisters = 16;
#elif defined(__aarch64__)
constexpr std::size_t kRegisterBytes = 16;
constexpr int kRegisters = 32;
#else
constexpr std::size_t kRegisterBytes = 16;
constexpr int kRegisters = 16;
#endif
static_assert(kVectorBytes % kRegisterBytes == 0);

/// Numbers of a register.
template <class T>
constexpr int kWidth = static_cast<int>(kRegisterBytes / sizeof(T));

/// Sums that stand in registers beside what is added to them.
constexpr int kMostSums = kRegisters * 3 / 4;

/// A register.
template <class T>
struct VectorOf {
  using Type [[gnu::vector_size(kRegisterBytes)]] = T;
  /// The same anywhere in memory.
  using Anywhere [[gnu::vector_size(kRegisterBytes), gnu::aligned(alignof(T)), gnu::may_alias]] = T;
};
template <class T>
using Vector = typename VectorOf<T>::Type;

// Not by memcpy, which the compiler splits into the shorter vectors that it prefers to copy with.
template <class T>
[[gnu::always_inline]] inline Vector<T> load(const T* from) {
  return *reinterpret_cast<const typename VectorOf<T>::Anywhere*>(from);
}

template <class T>
[[gnu::always_inline]] inline void store(const Vector<T>& v, T* to) {
  *reinterpret_cast<typename VectorOf<T>::Anywhere*>(to) = v;
}

/// Half of a vector of single floats, as doubles.
template <int kFirst, int... kLane>
[[gnu::always_inline]] inline Vector<double> half(const Vector<float>& v,
                                                  std::integer_sequence<int, kLane...>) {
  return __builtin_convertvector(__builtin_shufflevector(v, v, kFirst + kLane...), Vector<double>);
}
[[gnu::always_inline]] inline Vector<double> low_half(const Vector<float>& v) {
  return half<0>(v, std::make_integer_sequence<int, kWidth<double>>());
}
[[gnu::always_inline]] inline Vector<double> high_half(const Vector<float>& v) {
  return half<kWidth<double>>(v, std::make_integer_sequence<int, kWidth<double>>());
}

/// Doubles of a vector of single floats.
[[gnu::always_inline]] inline void store(const Vector<float>& v, double* to) {
  store<double>(low_half(v), to);
  store<double>(high_half(v), to + kWidth<double>);
}

/// The first `count` lanes, fewer than all.
template <class T, class U>
[[gnu::always_inline]] inline void store_part(const Vector<T>& v, U* to, std::ptrdiff_t count) {
#ifdef __AVX512F__
  // Lane by lane, the last rows of a product would cost as much as all others.
  const unsigned lanes = (1u << count) - 1u;
  const auto low = static_cast<__mmask8>(lanes), high = static_cast<__mmask8>(lanes >> 8);
  if constexpr (std::is_same_v<U, float>) {
    _mm512_mask_storeu_ps(to, static_cast<__mmask16>(lanes), __m512(v));
  } else if constexpr (std::is_same_v<T, double>) {
    _mm512_mask_storeu_pd(to, low, __m512d(v));
  } else {
    _mm512_mask_storeu_pd(to, low, __m512d(low_half(v)));
    _mm512_mask_storeu_pd(to + 8, high, __m512d(high_half(v)));
  }
#else
  for (std::ptrdiff_t i = 0; i < count; ++i) to[i] = static_cast<U>(v[i]);
#endif
}

template <class T>
[[gnu::always_inline]] inline Vector<T> all(T x) {
  return x - Vector<T>{};
}

}  // namespace

}  // namespace samara::codebooks::kernels
