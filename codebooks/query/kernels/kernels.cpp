#include "samara/codebooks/query/kernels/kernels.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "samara/codebooks/query/kernels/vectors.h"

namespace samara::codebooks::kernels {

namespace {

/// Sums that stand in registers: loops over them have to be unrolled before the compiler looks at memory.
template <class T, int kCount>
struct Sums {
  Vector<T> at[kCount];
  [[gnu::always_inline]] inline void clear() {
#pragma GCC unroll 32
    for (int i = 0; i < kCount; ++i) at[i] = Vector<T>{};
  }
};

/// Vectors first .. first + kVectors - 1 of the blends of kSets lists of weights.
template <class T, int kSets, int kVectors>
[[gnu::always_inline]] inline void blend_vectors(const T* core, std::ptrdiff_t stride, int nodes,
                                                 const T* const* weights, T* const* out,
                                                 std::ptrdiff_t first) {
  Sums<T, kSets * kVectors> sum;
  sum.clear();
  for (int i = 0; i < nodes; ++i) {
    const T* from = core + i * stride + first;
#pragma GCC unroll 32
    for (int b = 0; b < kVectors; ++b) {
      const Vector<T> value = load(from + b * kWidth<T>);
#pragma GCC unroll 4
      for (int s = 0; s < kSets; ++s) sum.at[s * kVectors + b] += all(weights[s][i]) * value;
    }
  }
#pragma GCC unroll 4
  for (int s = 0; s < kSets; ++s) {
    T* const to = out[s] + first;
#pragma GCC unroll 32
    for (int b = 0; b < kVectors; ++b) store<T>(sum.at[s * kVectors + b], to + b * kWidth<T>);
  }
}

template <class T, int kSets>
void blend_sets(const T* core, std::ptrdiff_t stride, std::ptrdiff_t length, int nodes,
                const T* const* weights, T* const* out) {
  // As many sums as hide the time of an addition, and fit into registers.
  constexpr int kMany = kSets == 1 ? 12 : std::min(8, kMostSums / kSets);
  std::ptrdiff_t at = 0;
  for (; length - at >= kMany * kWidth<T>; at += kMany * kWidth<T>)
    blend_vectors<T, kSets, kMany>(core, stride, nodes, weights, out, at);
  const auto left = static_cast<int>((length - at) / kWidth<T>);
  [&]<int... kLess>(std::integer_sequence<int, kLess...>) {
    ((left == kLess + 1 ? blend_vectors<T, kSets, kLess + 1>(core, stride, nodes, weights, out, at) : void()),
     ...);
  }
  (std::make_integer_sequence<int, kMany - 1>());
}

/// A tile of kVectors x kColumns of a product. One column of few rows would wait for each addition: it is
/// summed in four parts.
template <class T, class U, int kVectors, int kColumns>
[[gnu::always_inline]] inline void multiply_tile(const T* a, std::ptrdiff_t lda, int inner, const T* const* b,
                                                 U* const* c, std::ptrdiff_t row, std::ptrdiff_t rows) {
  constexpr int kParts = kVectors * kColumns >= 8 ? 1 : kVectors * kColumns >= 4 ? 2 : 4;
  constexpr int kTile = kVectors * kColumns;
  Sums<T, kParts * kTile> sum;
  sum.clear();
  const T* column = a + row;
  int k = 0;
  for (; k + kParts <= inner; k += kParts) {
#pragma GCC unroll 4
    for (int part = 0; part < kParts; ++part, column += lda) {
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) {
        const Vector<T> value = load(column + v * kWidth<T>);
#pragma GCC unroll 4
        for (int j = 0; j < kColumns; ++j)
          sum.at[part * kTile + j * kVectors + v] += value * all(b[j][k + part]);
      }
    }
  }
  for (; k < inner; ++k, column += lda) {
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      const Vector<T> value = load(column + v * kWidth<T>);
#pragma GCC unroll 4
      for (int j = 0; j < kColumns; ++j) sum.at[j * kVectors + v] += value * all(b[j][k]);
    }
  }
#pragma GCC unroll 4
  for (int j = 0; j < kColumns; ++j) {
    U* const to = c[j];
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      Vector<T> total = sum.at[j * kVectors + v];
#pragma GCC unroll 4
      for (int part = 1; part < kParts; ++part) total += sum.at[part * kTile + j * kVectors + v];
      const std::ptrdiff_t at = row + v * kWidth<T>;
      if (rows - at >= kWidth<T>) {
        store(total, to + at);
      } else {
        store_part<T>(total, to + at, rows - at);
      }
    }
  }
}

/// Calls run(number of vectors as a constant, first row) for tiles of at most kMost vectors of rows.
template <class T, int kMost, class Run>
[[gnu::always_inline]] inline void in_row_tiles(std::ptrdiff_t rows, const Run& run) {
  static_assert(kMost == 3 || kMost == 4);
  std::ptrdiff_t row = 0;
  for (; rows - row > 2 * kWidth<T>; row += kMost * kWidth<T>) {
    if (kMost == 4 && rows - row <= 3 * kWidth<T>) return run(std::integral_constant<int, 3>(), row);
    run(std::integral_constant<int, kMost>(), row);
  }
  if (rows - row > kWidth<T>) {
    run(std::integral_constant<int, 2>(), row);
  } else if (rows > row) {
    run(std::integral_constant<int, 1>(), row);
  }
}

template <class T, class U, int kColumns>
void multiply_columns(const T* a, std::ptrdiff_t lda, std::ptrdiff_t rows, int inner, const T* const* b,
                      U* const* c) {
  in_row_tiles<T, std::min(4, kMostSums / kColumns)>(
      rows, [&](auto vectors, std::ptrdiff_t row) __attribute__((always_inline)) {
        multiply_tile<T, U, vectors(), kColumns>(a, lda, inner, b, c, row, rows);
      });
}

/// kVectors vectors of rows of kColumns points.
template <class T, class U, int kVectors, int kColumns>
[[gnu::always_inline]] inline void multiply_block_tile(const T* a, std::ptrdiff_t lda, int inner, const T* b,
                                                       U* const* c, std::ptrdiff_t row, std::ptrdiff_t rows) {
  Sums<T, kColumns * kVectors> sum;
  sum.clear();
  const T* column = a + row;
  for (int k = 0; k < inner; ++k, column += lda, b += kBlock<T>) {
    Vector<T> value[kVectors];
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) value[v] = load(column + v * kWidth<T>);
#pragma GCC unroll 8
    for (int j = 0; j < kColumns; ++j) {
      const Vector<T> factor = all(b[j]);
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) sum.at[j * kVectors + v] += value[v] * factor;
    }
  }
#pragma GCC unroll 8
  for (int j = 0; j < kColumns; ++j) {
    U* const to = c[j];
    if (to == nullptr) continue;
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      const std::ptrdiff_t at = row + v * kWidth<T>;
      if (rows - at >= kWidth<T>) {
        store(sum.at[j * kVectors + v], to + at);
      } else {
        store_part<T>(sum.at[j * kVectors + v], to + at, rows - at);
      }
    }
  }
}

/// kRows rows of a contraction, for two vectors of the points of a block. Without a column v, it is taken as 1.
template <class T, int kRows, bool kHasColumn>
[[gnu::always_inline]] inline void contract_rows(const T* core, std::ptrdiff_t stride, int left, int right,
                                                 int nodes, const T* weights, const T* v,
                                                 Sums<T, 2 * kRows>& sum) {
  sum.clear();
  for (int i = 0; i < nodes; ++i) {
    const Vector<T> w0 = load(weights + i * kBlock<T>);
    const Vector<T> w1 = load(weights + i * kBlock<T> + kWidth<T>);
    const T* column = core + i * stride;
    for (int r = 0; r < right; ++r, column += left) {
      const Vector<T> b0 = kHasColumn ? w0 * load(v + r * kBlock<T>) : w0;
      const Vector<T> b1 = kHasColumn ? w1 * load(v + r * kBlock<T> + kWidth<T>) : w1;
#pragma GCC unroll 16
      for (int l = 0; l < kRows; ++l) {
        const Vector<T> factor = all(column[l]);
        sum.at[2 * l] += factor * b0;
        sum.at[2 * l + 1] += factor * b1;
      }
    }
  }
}

constexpr int kMostRows = kMostSums / 2;

/// Where sum i of two vectors a row belongs among rows of a block.
template <class T>
constexpr std::ptrdiff_t place_of(int i) {
  return i / 2 * kBlock<T> + i % 2 * kWidth<T>;
}

template <class T, int kRows>
void contract_tile(const T* core, std::ptrdiff_t stride, int left, int right, int nodes, const T* weights,
                   const T* v, T* out) {
  for (int point = 0; point < kBlock<T>; point += 2 * kWidth<T>) {
    Sums<T, 2 * kRows> sum;
    contract_rows<T, kRows, true>(core, stride, left, right, nodes, weights + point, v + point, sum);
#pragma GCC unroll 32
    for (int i = 0; i < 2 * kRows; ++i) store<T>(sum.at[i], out + point + place_of<T>(i));
  }
}

template <class T, int kRows>
void scale_tile(const T* factor, std::ptrdiff_t stride, int rank, int nodes, const T* weights, T* out) {
  for (int point = 0; point < kBlock<T>; point += 2 * kWidth<T>) {
    Sums<T, 2 * kRows> sum;
    contract_rows<T, kRows, false>(factor, stride, rank, 1, nodes, weights + point, nullptr, sum);
#pragma GCC unroll 32
    for (int i = 0; i < 2 * kRows; ++i) {
      T* const to = out + point + place_of<T>(i);
      store<T>(sum.at[i] * load(to), to);
    }
  }
}

/// Calls run(number of rows as a constant, first row) for tiles of nearly equal size.
template <class Run>
void in_tiles(int rows, const Run& run) {
  const int tiles = (rows + kMostRows - 1) / kMostRows;
  int first = 0;
  for (int t = 0; t < tiles; ++t) {
    const int size = (rows - first + tiles - t - 1) / (tiles - t);
    [&]<int... kSizes>(std::integer_sequence<int, kSizes...>) {
      ((size == kSizes + 1 ? run(std::integral_constant<int, kSizes + 1>(), first) : void()), ...);
    }
    (std::make_integer_sequence<int, kMostRows>());
    first += size;
  }
}

}  // namespace

namespace {

using Integers [[gnu::vector_size(kRegisterBytes)]] = long long;

/// Each lane multiplies up the differences of its own polynomial; four products at a time do not wait for
/// each other.
template <int kVectors>
[[gnu::always_inline]] inline void lagrange_lanes(const double* nodes, const double* lambda, int size,
                                                  double place, double* values) {
  Integers lane[kVectors];
  Vector<double> product[kVectors][4];
  for (int v = 0; v < kVectors; ++v) {
    for (int i = 0; i < kWidth<double>; ++i) lane[v][i] = v * kWidth<double> + i;
    for (int part = 0; part < 4; ++part) product[v][part] = all(1.0);
  }
  for (int k = 0; k < size; ++k) {
    const Vector<double> factor = all(2.0 * (place - nodes[k]));
    for (int v = 0; v < kVectors; ++v) product[v][k % 4] *= lane[v] == k ? all(1.0) : factor;
  }
  for (int v = 0; v < kVectors; ++v) {
    const Vector<double> total = product[v][0] * product[v][1] * (product[v][2] * product[v][3]);
    store<double>(load(lambda + v * kWidth<double>) * total, values + v * kWidth<double>);
  }
}

}  // namespace

void lagrange(const double* nodes, const double* lambda, int size, double place, double* values) {
  if (size <= kWidth<double>) return lagrange_lanes<1>(nodes, lambda, size, place, values);
  if (size <= 2 * kWidth<double>) return lagrange_lanes<2>(nodes, lambda, size, place, values);
  double before = 1.0;
  for (int j = 0; j < size; ++j) {
    values[j] = lambda[j] * before;
    before *= 2.0 * (place - nodes[j]);
  }
  double after = 1.0;
  for (int j = size - 1; j >= 0; --j) {
    values[j] *= after;
    after *= 2.0 * (place - nodes[j]);
  }
}

template <class T>
void lagrange_block(const double* nodes, const double* lambda, int size, const double* places, T* values) {
  constexpr int kMost = 64;
  for (int first = 0; first < kBlock<T>; first += kWidth<double>) {
    const Vector<double> x = load(places + first);
    std::array<Vector<double>, kMost> before;
    Vector<double> product = all(1.0);
    for (int j = 0; j < size; ++j) {
      before[static_cast<std::size_t>(j)] = all(lambda[j]) * product;
      product *= 2.0 * (x - all(nodes[j]));
    }
    product = all(1.0);
    for (int j = size - 1; j >= 0; --j) {
      const Vector<double> value = before[static_cast<std::size_t>(j)] * product;
      for (int p = 0; p < kWidth<double>; ++p) values[j * kBlock<T> + first + p] = static_cast<T>(value[p]);
      product *= 2.0 * (x - all(nodes[j]));
    }
  }
}

template <class T>
void blend(const T* core, std::ptrdiff_t stride, std::ptrdiff_t length, int nodes, const T* const* weights,
           int sets, T* const* out) {
  if (sets == 1) return blend_sets<T, 1>(core, stride, length, nodes, weights, out);
  if (sets == 2) return blend_sets<T, 2>(core, stride, length, nodes, weights, out);
  blend_sets<T, 3>(core, stride, length, nodes, weights, out);
}

void stream(const double* from, std::ptrdiff_t size, double* to) {
  std::ptrdiff_t i = 0;
#ifdef __SSE2__
  for (; i < size && reinterpret_cast<std::uintptr_t>(to + i) % kVectorBytes != 0; ++i) to[i] = from[i];
  for (; i + 8 <= size; i += 8) {
#ifdef __AVX512F__
    _mm512_stream_pd(to + i, _mm512_loadu_pd(from + i));
#else
    for (int k = 0; k < 8; k += 2) _mm_stream_pd(to + i + k, _mm_loadu_pd(from + i + k));
#endif
  }
#endif
  for (; i < size; ++i) to[i] = from[i];
}

template <class T>
void scale(const T* a, const T* b, std::ptrdiff_t length, T* out) {
  for (std::ptrdiff_t i = 0; i < length; i += kWidth<T>) store<T>(load(a + i) * load(b + i), out + i);
}

template <class T, class U>
void multiply(const T* a, std::ptrdiff_t lda, std::ptrdiff_t rows, int inner, const T* const* b, int columns,
              U* const* c) {
  int j = 0;
  for (; j + 4 <= columns; j += 4) multiply_columns<T, U, 4>(a, lda, rows, inner, b + j, c + j);
  if (columns - j == 3) return multiply_columns<T, U, 3>(a, lda, rows, inner, b + j, c + j);
  if (columns - j == 2) return multiply_columns<T, U, 2>(a, lda, rows, inner, b + j, c + j);
  if (columns - j == 1) multiply_columns<T, U, 1>(a, lda, rows, inner, b + j, c + j);
}

template <class T, class U>
void multiply_block(const T* a, std::ptrdiff_t lda, std::ptrdiff_t rows, int inner, const T* b, U* const* c) {
  constexpr int kVectors = 3, kColumns = kMostSums / kVectors;
  static_assert(kBlock<T> % kColumns == 0);
  for (int j = 0; j < kBlock<T>; j += kColumns) {
    in_row_tiles<T, kVectors>(
        rows, [&](auto vectors, std::ptrdiff_t row) __attribute__((always_inline)) {
          multiply_block_tile<T, U, vectors(), kColumns>(a, lda, inner, b + j, c + j, row, rows);
        });
  }
}

template <class T>
void contract_block(const T* core, std::ptrdiff_t stride, int left, int right, int nodes, const T* weights,
                    const T* v, T* out) {
  in_tiles(left, [&](auto rows, int first) {
    contract_tile<T, rows()>(core + first, stride, left, right, nodes, weights, v, out + first * kBlock<T>);
  });
}

template <class T>
void scale_block(const T* factor, std::ptrdiff_t stride, int rank, int nodes, const T* weights, T* out) {
  in_tiles(rank, [&](auto rows, int first) {
    scale_tile<T, rows()>(factor + first, stride, rank, nodes, weights, out + first * kBlock<T>);
  });
}

template void lagrange_block(const double*, const double*, int, const double*, double*);
template void lagrange_block(const double*, const double*, int, const double*, float*);
template void blend(const double*, std::ptrdiff_t, std::ptrdiff_t, int, const double* const*, int,
                    double* const*);
template void blend(const float*, std::ptrdiff_t, std::ptrdiff_t, int, const float* const*, int,
                    float* const*);
template void scale(const double*, const double*, std::ptrdiff_t, double*);
template void scale(const float*, const float*, std::ptrdiff_t, float*);
template void multiply(const double*, std::ptrdiff_t, std::ptrdiff_t, int, const double* const*, int,
                       double* const*);
template void multiply(const float*, std::ptrdiff_t, std::ptrdiff_t, int, const float* const*, int,
                       float* const*);
template void multiply(const float*, std::ptrdiff_t, std::ptrdiff_t, int, const float* const*, int,
                       double* const*);
template void multiply_block(const double*, std::ptrdiff_t, std::ptrdiff_t, int, const double*,
                             double* const*);
template void multiply_block(const float*, std::ptrdiff_t, std::ptrdiff_t, int, const float*, float* const*);
template void multiply_block(const float*, std::ptrdiff_t, std::ptrdiff_t, int, const float*, double* const*);
template void contract_block(const double*, std::ptrdiff_t, int, int, int, const double*, const double*,
                             double*);
template void contract_block(const float*, std::ptrdiff_t, int, int, int, const float*, const float*, float*);
template void scale_block(const double*, std::ptrdiff_t, int, int, const double*, double*);
template void scale_block(const float*, std::ptrdiff_t, int, int, const float*, float*);

}  // namespace samara::codebooks::kernels
