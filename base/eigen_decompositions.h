#pragma once

#include <Eigen/Dense>
#include <Eigen/SparseCore>

/// Eigen's decompositions and products of dense matrices of doubles, compiled once for the whole library instead of
/// in every source that factors a matrix: 1 to 20 s of compiling each, a sixth of the time of a build from nothing.
///
/// Nobody includes this header: it stands in the precompiled ones, and without them every source compiles its own
/// as ever. What is declared here is defined in eigen_decompositions.cpp by the same lines.
#ifndef SAMARA_EIGEN_TEMPLATE
#define SAMARA_EIGEN_TEMPLATE extern template
#endif

namespace Eigen {

namespace internal {

using SamaraColumns = const_blas_data_mapper<double, Index, ColMajor>;
using SamaraRows = const_blas_data_mapper<double, Index, RowMajor>;

SAMARA_EIGEN_TEMPLATE struct general_matrix_vector_product<Index, double, SamaraColumns, ColMajor, false,
                                                           double, SamaraRows, false, 0>;
SAMARA_EIGEN_TEMPLATE struct general_matrix_vector_product<Index, double, SamaraColumns, ColMajor, false,
                                                           double, SamaraColumns, false, 0>;
SAMARA_EIGEN_TEMPLATE struct general_matrix_vector_product<Index, double, SamaraRows, RowMajor, false, double,
                                                           SamaraColumns, false, 0>;
SAMARA_EIGEN_TEMPLATE struct gebp_kernel<
    double, double, Index, blas_data_mapper<double, Index, ColMajor, 0, 1>, gebp_traits<double, double>::mr,
    gebp_traits<double, double>::nr, false, false>;
SAMARA_EIGEN_TEMPLATE struct partial_lu_impl<double, ColMajor, int, Dynamic>;
SAMARA_EIGEN_TEMPLATE struct triangular_solve_vector<double, double, Index, OnTheLeft, Lower, false,
                                                     ColMajor>;
SAMARA_EIGEN_TEMPLATE struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false,
                                                     ColMajor>;
SAMARA_EIGEN_TEMPLATE struct triangular_solve_vector<double, double, Index, OnTheLeft, UnitLower, false,
                                                     ColMajor>;
SAMARA_EIGEN_TEMPLATE struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false,
                                                     RowMajor>;
SAMARA_EIGEN_TEMPLATE struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, ColMajor,
                                                     ColMajor, 1>;
SAMARA_EIGEN_TEMPLATE struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, ColMajor,
                                                     ColMajor, 1>;
SAMARA_EIGEN_TEMPLATE struct triangular_solve_matrix<double, Index, OnTheLeft, UnitLower, false, ColMajor,
                                                     ColMajor, 1>;
SAMARA_EIGEN_TEMPLATE struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, RowMajor,
                                                     ColMajor, 1>;
SAMARA_EIGEN_TEMPLATE struct general_matrix_matrix_product<Index, double, ColMajor, false, double, ColMajor,
                                                           false, ColMajor, 1>;
SAMARA_EIGEN_TEMPLATE struct general_matrix_matrix_product<Index, double, RowMajor, false, double, ColMajor,
                                                           false, ColMajor, 1>;
SAMARA_EIGEN_TEMPLATE struct general_matrix_matrix_product<Index, double, ColMajor, false, double, RowMajor,
                                                           false, ColMajor, 1>;
SAMARA_EIGEN_TEMPLATE void evaluateProductBlockingSizesHeuristic<double, double, 1, Index>(Index&, Index&,
                                                                                           Index&, Index);
SAMARA_EIGEN_TEMPLATE void evaluateProductBlockingSizesHeuristic<double, double, 4, Index>(Index&, Index&,
                                                                                           Index&, Index);
SAMARA_EIGEN_TEMPLATE void generic_product_impl<MatrixXd, MatrixXd, DenseShape, DenseShape,
                                                GemmProduct>::scaleAndAddTo(MatrixXd&, const MatrixXd&,
                                                                            const MatrixXd&, const double&);
SAMARA_EIGEN_TEMPLATE void generic_product_impl<Transpose<MatrixXd>, MatrixXd, DenseShape, DenseShape,
                                                GemmProduct>::scaleAndAddTo(MatrixXd&,
                                                                            const Transpose<MatrixXd>&,
                                                                            const MatrixXd&, const double&);
SAMARA_EIGEN_TEMPLATE void generic_product_impl<Transpose<const MatrixXd>, MatrixXd, DenseShape, DenseShape,
                                                GemmProduct>::scaleAndAddTo(MatrixXd&,
                                                                            const Transpose<const MatrixXd>&,
                                                                            const MatrixXd&, const double&);
SAMARA_EIGEN_TEMPLATE void generic_product_impl<MatrixXd, Transpose<const MatrixXd>, DenseShape, DenseShape,
                                                GemmProduct>::scaleAndAddTo(MatrixXd&, const MatrixXd&,
                                                                            const Transpose<const MatrixXd>&,
                                                                            const double&);
SAMARA_EIGEN_TEMPLATE std::ostream& print_matrix(std::ostream&, const MatrixXd&, const IOFormat&);
SAMARA_EIGEN_TEMPLATE std::ostream& print_matrix(std::ostream&, const VectorXd&, const IOFormat&);
SAMARA_EIGEN_TEMPLATE std::ostream& print_matrix(std::ostream&, const RowVectorXd&, const IOFormat&);
SAMARA_EIGEN_TEMPLATE std::ostream& print_matrix(std::ostream&, const Vector3d&, const IOFormat&);
SAMARA_EIGEN_TEMPLATE void assign_sparse_to_sparse(SparseMatrix<double>&, const SparseMatrix<double>&);
SAMARA_EIGEN_TEMPLATE void apply_block_householder_on_the_left(Block<MatrixXd>&, const Block<MatrixXd>&,
                                                               const VectorBlock<const VectorXd>&, bool);
SAMARA_EIGEN_TEMPLATE void tridiagonalization_inplace(MatrixXd&, VectorXd&, VectorXd&, VectorXd&, bool);
SAMARA_EIGEN_TEMPLATE ComputationInfo computeFromTridiagonal_impl(VectorXd&, VectorXd&, Index, bool,
                                                                  MatrixXd&);

}  // namespace internal

SAMARA_EIGEN_TEMPLATE class LLT<MatrixXd>;
SAMARA_EIGEN_TEMPLATE LLT<MatrixXd>& LLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
SAMARA_EIGEN_TEMPLATE void LLT<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
SAMARA_EIGEN_TEMPLATE void LLT<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;

SAMARA_EIGEN_TEMPLATE class LDLT<MatrixXd>;
SAMARA_EIGEN_TEMPLATE LDLT<MatrixXd>& LDLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
SAMARA_EIGEN_TEMPLATE void LDLT<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
SAMARA_EIGEN_TEMPLATE void LDLT<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;

SAMARA_EIGEN_TEMPLATE class PartialPivLU<MatrixXd>;
SAMARA_EIGEN_TEMPLATE PartialPivLU<MatrixXd>::PartialPivLU(const EigenBase<MatrixXd>&);
SAMARA_EIGEN_TEMPLATE void PartialPivLU<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
SAMARA_EIGEN_TEMPLATE void PartialPivLU<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;

SAMARA_EIGEN_TEMPLATE class HouseholderQR<MatrixXd>;
SAMARA_EIGEN_TEMPLATE void HouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
SAMARA_EIGEN_TEMPLATE void HouseholderQR<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;

SAMARA_EIGEN_TEMPLATE class ColPivHouseholderQR<MatrixXd>;
SAMARA_EIGEN_TEMPLATE ColPivHouseholderQR<MatrixXd>::ColPivHouseholderQR(const EigenBase<MatrixXd>&);
SAMARA_EIGEN_TEMPLATE ColPivHouseholderQR<MatrixXd>& ColPivHouseholderQR<MatrixXd>::compute(
    const EigenBase<MatrixXd>&);
SAMARA_EIGEN_TEMPLATE void ColPivHouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;

SAMARA_EIGEN_TEMPLATE class CompleteOrthogonalDecomposition<MatrixXd>;
SAMARA_EIGEN_TEMPLATE void CompleteOrthogonalDecomposition<MatrixXd>::_solve_impl(const VectorXd&,
                                                                                  VectorXd&) const;

SAMARA_EIGEN_TEMPLATE class SelfAdjointEigenSolver<MatrixXd>;
SAMARA_EIGEN_TEMPLATE SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(
    const EigenBase<MatrixXd>&, int);

SAMARA_EIGEN_TEMPLATE class SelfAdjointEigenSolver<Matrix3d>;
SAMARA_EIGEN_TEMPLATE SelfAdjointEigenSolver<Matrix3d>& SelfAdjointEigenSolver<Matrix3d>::compute(
    const EigenBase<Matrix3d>&, int);

SAMARA_EIGEN_TEMPLATE class JacobiSVD<MatrixXd>;
SAMARA_EIGEN_TEMPLATE class BDCSVD<MatrixXd>;

}  // namespace Eigen
