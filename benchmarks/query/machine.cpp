// What is compiled for the machine: the fastest matrix product at hand, and the plain loop once more.
#include <algorithm>
#include <limits>

#include <Eigen/Core>
#ifdef SAMARA_BENCHMARK_BLAS
#include <cblas.h>
#endif

#include "cases.h"

namespace samara::benchmarks {

#define PLAIN_NAME plain_value_native
#include "plain_train.inc"

namespace {

template <class T>
using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;

#ifdef SAMARA_BENCHMARK_BLAS
void product(const Matrix<double>& a, const Matrix<double>& b, Matrix<double>& c) {
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, static_cast<int>(a.rows()),
              static_cast<int>(b.cols()), static_cast<int>(a.cols()), 1.0, a.data(),
              static_cast<int>(a.rows()), b.data(), static_cast<int>(b.rows()), 0.0, c.data(),
              static_cast<int>(c.rows()));
}
void product(const Matrix<float>& a, const Matrix<float>& b, Matrix<float>& c) {
  cblas_sgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, static_cast<int>(a.rows()),
              static_cast<int>(b.cols()), static_cast<int>(a.cols()), 1.0F, a.data(),
              static_cast<int>(a.rows()), b.data(), static_cast<int>(b.rows()), 0.0F, c.data(),
              static_cast<int>(c.rows()));
}
#endif

template <class T>
double seconds_of(int rows, int inner, int columns) {
  const Matrix<T> a = Matrix<T>::Random(rows, inner), b = Matrix<T>::Random(inner, columns);
  Matrix<T> c = Matrix<T>::Zero(rows, columns);
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 7; ++i) {
    best = std::min(best, time_of([&] { c.noalias() = a * b; }, 1, 0.0));
#ifdef SAMARA_BENCHMARK_BLAS
    best = std::min(best, time_of([&] { product(a, b, c); }, 1, 0.0));
#endif
  }
  return best;
}

}  // namespace

double gemm_seconds(int rows, int inner, int columns, bool single) {
  return single ? seconds_of<float>(rows, inner, columns) : seconds_of<double>(rows, inner, columns);
}

}  // namespace samara::benchmarks
