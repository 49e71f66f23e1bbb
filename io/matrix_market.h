#pragma once

#include <filesystem>
#include <string>

#include <Eigen/SparseCore>

/// Reading of sparse matrices in the Matrix Market exchange format, in which finite element programs write
/// their mass and stiffness matrices. Reference: Boisvert, Pozo and Remington, The Matrix Market exchange
/// formats: initial design, NIST Interagency Report 5935 (1996).
///
/// Eigen's own reader is not used: it prints errors and goes on, and ignores symmetry.
namespace samara::io {

/// The matrix of a file with the header `%%MatrixMarket matrix coordinate FIELD SYMMETRY`, where FIELD is
/// real or integer and SYMMETRY is general or symmetric (then only one triangle stands in the file, and both
/// are returned). Compressed.
/// @throws InputError with file and line if the file is missing, its header is malformed or of another kind,
/// its sizes are negative or too large for an int, an entry is malformed, not finite or outside the matrix,
/// stands twice, or if there are fewer or more entries than announced.
Eigen::SparseMatrix<double> read_matrix_market(const std::filesystem::path& path);

/// The same from text; `name` stands for the file in messages.
Eigen::SparseMatrix<double> parse_matrix_market(const std::string& text, const std::string& name);

}  // namespace samara::io
