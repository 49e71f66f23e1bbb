#pragma once

#include <cstddef>

/// The inner loops of queries, for doubles and single floats. Their source is compiled for the machine, and
/// knows neither Eigen nor anything else whose inline functions would leak its instructions into other
/// programs.
///
/// Matrices are stored column by column. Buffers that a kernel reads may be read, and those it fills as
/// scratch may be written, up to the end of the vector that holds their last number: allocate
/// padded<T>(size) numbers, zero at first.
namespace samara::codebooks::kernels {

/// Bytes of the longest vector of any machine, to which buffers are padded whatever the machine, and the alignment
/// that is fastest; none is required.
inline constexpr std::size_t kVectorBytes = 64;

/// Numbers of such a vector.
template <class T>
inline constexpr int kLanes = static_cast<int>(kVectorBytes / sizeof(T));

/// Points of a batch that go through the kernels together.
template <class T>
inline constexpr int kBlock = 2 * kLanes<T>;

template <class T>
constexpr std::ptrdiff_t padded(std::ptrdiff_t size) {
  return (size + kLanes<T> - 1) / kLanes<T> * kLanes<T>;
}

/// Values at a point of the Lagrange polynomials on nodes of [-1, 1], by products of differences: accurate
/// to a few eps of each of them.
/// @param lambda per node j, the product over all others k of 1 / (2 (node_j - node_k)); padded<double>(size)
///   numbers, as values
void lagrange(const double* nodes, const double* lambda, int size, double place, double* values);

/// The same at kBlock<T> places: values[j * kBlock<T> + p].
template <class T>
void lagrange_block(const double* nodes, const double* lambda, int size, const double* places, T* values);

/// What interpolation makes of a core or a factor matrix: for each of `sets` lists of weights,
/// out[b] = sum over nodes i of weights[i] core[i * stride + b].
/// @param sets 1 to 3  @param stride,length multiples of kLanes<T>
template <class T>
void blend(const T* core, std::ptrdiff_t stride, std::ptrdiff_t length, int nodes, const T* const* weights,
           int sets, T* const* out);

/// Copies numbers past the caches, for answers that are larger than those: memory is then written without
/// being read first.
void stream(const double* from, std::ptrdiff_t size, double* to);

/// out[i] = a[i] b[i]. @param length a multiple of kLanes<T>
template <class T>
void scale(const T* a, const T* b, std::ptrdiff_t length, T* out);

/// c_j = a b_j for some columns, a of `rows` x `inner` with the leading dimension `lda`. Writes `rows`
/// numbers of each column and no more.
template <class T, class U>
void multiply(const T* a, std::ptrdiff_t lda, std::ptrdiff_t rows, int inner, const T* const* b, int columns,
              U* const* c);

/// The same for the kBlock<T> columns of a block: b[k * kBlock<T> + p] is row k of column p. Null columns of
/// c are left out.
template <class T, class U>
void multiply_block(const T* a, std::ptrdiff_t lda, std::ptrdiff_t rows, int inner, const T* b, U* const* c);

/// A core of left x right matrices at the points of a block, each with its own weights, times a column at
/// each point: out[l, p] = sum over nodes i and r of core_i[l, r] weights[i, p] v[r, p].
/// @param core matrix i begins at i * stride  @param weights, v, out rows of kBlock<T> points
template <class T>
void contract_block(const T* core, std::ptrdiff_t stride, int left, int right, int nodes, const T* weights,
                    const T* v, T* out);

/// out[r, p] *= sum over nodes i of factor_i[r] weights[i, p].
template <class T>
void scale_block(const T* factor, std::ptrdiff_t stride, int rank, int nodes, const T* weights, T* out);

}  // namespace samara::codebooks::kernels
