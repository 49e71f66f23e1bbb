#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/linear/separated_operator.h"

namespace samara::pgd {

/// The terms of a separated operator as a chain over the modes, what terms share kept once.
///
/// Between two neighbouring modes stands a small set of states; at a mode, links lead from the states before
/// it to the states after it, each with one part of the operator. The sum over all paths from the first
/// state to the last one, of the products of the parts along them, is the operator. Terms that differ from
/// the parts most in use on one mode only (a Laplacian, a stiffness beside masses) share two states however
/// many they are; every other term has a state of its own. Sums over terms that are done from mode to mode
/// then cost O(links), for a Laplacian in d dimensions 3 d instead of d^2.
class OperatorChain {
 public:
  struct Link {
    int from = 0;
    int to = 0;
    int part = 0;
  };
  struct Mode {
    std::vector<ModeOperator> parts;  ///< distinct ones
    std::vector<Link> links;
  };

  explicit OperatorChain(const SeparatedOperator& op);
  /// @param parts distinct parts per mode; @param terms per term the part of every mode
  OperatorChain(std::vector<std::vector<ModeOperator>> parts, std::vector<std::vector<int>> terms);
  /// The chain of one path with one part (the identity of size `sizes`) per mode.
  static OperatorChain identity(std::span<const int> sizes);

  int modes() const { return static_cast<int>(modes_.size()); }
  const Mode& mode(int k) const { return modes_[static_cast<std::size_t>(k)]; }
  int size(int k) const { return mode(k).parts.front().cols(); }
  /// States before mode k; 1 at both ends (k = 0, modes()).
  int states(int k) const { return states_[static_cast<std::size_t>(k)]; }
  /// Per term the part of every mode.
  const std::vector<std::vector<int>>& terms() const { return terms_; }

 private:
  void link();

  std::vector<Mode> modes_;
  std::vector<std::vector<int>> terms_;
  std::vector<int> states_;
};

/// Inner products <V, A U> of two sums of products with an operator in between, term by term, mode by mode:
/// for V of `rows` and U of `cols` terms. The caller fills in gram(k, p) = V_k^T A_k^p U_k and visits the
/// modes in order:
///
///   products.start(); for k: products.coefficients(k) .. change gram(k, .) .. products.advance(k);
///
/// A sweep costs O(links rows cols) and does not allocate.
class ChainProducts {
 public:
  ChainProducts(const OperatorChain& chain, Eigen::Index rows, Eigen::Index cols);

  Eigen::MatrixXd& gram(int mode, int part) {
    return grams_[static_cast<std::size_t>(mode)][static_cast<std::size_t>(part)];
  }
  /// Fills gram(mode, .) for V_k = `v` and U_k = `u`.
  void refresh(int mode, const Eigen::MatrixXd& v, const Eigen::MatrixXd& u);

  /// Begins a sweep with the grams as they are.
  void start();
  /// @param first factor of all products, such as the weights of U: rows x cols
  void start(const Eigen::MatrixXd& first);
  /// Per part of the mode: products over all other modes, summed over the terms with that part.
  const std::vector<Eigen::MatrixXd>& coefficients(int mode);
  /// Takes gram(mode, .) over, so that the next mode can be visited.
  void advance(int mode);
  /// After all modes: the products over all of them.
  const Eigen::MatrixXd& total() const { return left_.back().front(); }

 private:
  void multiply_from_the_right();

  const OperatorChain* chain_;
  std::vector<std::vector<Eigen::MatrixXd>> grams_;         ///< [mode][part]
  std::vector<std::vector<Eigen::MatrixXd>> left_, right_;  ///< [bond][state]
  std::vector<std::vector<Eigen::MatrixXd>> coefficients_;  ///< [mode][part]
};

}  // namespace samara::pgd
