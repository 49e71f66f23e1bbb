#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

/// Which combinations of coefficients the data determine, from the eigenvectors of the information matrix, in
/// words.
///
/// With the information F (the second derivative of the cost 1/2 sum rho by the coefficients, the captures'
/// own unknowns eliminated by a Schur complement) and a scale s_k for each coefficient (a change that would
/// matter: half the width of its box), the scaled matrix
///
///     G = diag(s) F diag(s)/dispersion = sum_j lambda_j v_j v_j^T
///
/// says how well the motion along v_j is known: its standard error is 1/sqrt(lambda_j) scales. The words:
///
///   undetermined   standard error > 1/sqrt(3) = 0.577: the data know less than the box does (a uniform
///                  distribution over a box has that deviation in units of half its width)
///   weak           > 0.25: the 95 % interval covers half of the box
///   determined     otherwise
///
/// Undetermined directions that share coefficients are taken together, because eigenvectors of equal
/// eigenvalues are arbitrary; what is said is which combination IS determined: "C_D0 and C_D90 only as a
/// sum", "C_T only relative to C_R (ratio)", "a, b and c only as a + 0.5 b - 2 c", "C_w not at all".
///
/// These are statements about the neighbourhood of the optimum. Profiles (profile.h) see farther and cost
/// more.
namespace samara::identification {

/// What one coefficient is for the information matrix.
struct InformedCoefficient {
  std::string name = {};
  double value = 0.0;
  double scale = 1.0;       ///< a change that would matter, in the unit of the matrix's coordinate
  bool log_scaled = false;  ///< the matrix is with respect to the logarithm of the value (value > 0)
};

enum class DirectionKind { determined, weak, undetermined };

/// "determined", "weak", "undetermined".
std::string to_string(DirectionKind kind);

struct InformationDirection {
  DirectionKind kind = DirectionKind::determined;
  double eigenvalue = 0.0;      ///< of G, at least 0
  double standard_error = 0.0;  ///< in scales; infinite if the eigenvalue is zero
  /// Unit vector of scaled coefficients, its largest entry positive.
  Eigen::VectorXd vector = {};
};

struct Identifiability {
  std::vector<std::string> names = {};
  std::vector<InformationDirection> directions = {};  ///< the least known first
  /// What is not determined or weak, one phrase each, without a full stop. Empty if all is well.
  std::vector<std::string> phrases = {};
  int undetermined_count = 0;
};

/// @param information F, symmetric, positive semidefinite up to rounding, coefficients x coefficients
/// @param dispersion what the cost is divided by to be a log-likelihood; see profile.h
/// @throws ArgumentError for sizes that differ, scales or dispersions that are not positive, numbers that are
///   not finite, and log-scaled values that are not positive.
Identifiability identifiability(const std::vector<InformedCoefficient>& coefficients,
                                const Eigen::MatrixXd& information, double dispersion = 1.0);

}  // namespace samara::identification
