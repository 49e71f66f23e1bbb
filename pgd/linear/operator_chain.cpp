#include "samara/pgd/linear/operator_chain.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

namespace samara::pgd {

namespace {

/// Index of `part` among the distinct ones, appended if it is new.
int find_or_add(const ModeOperator& part, std::vector<ModeOperator>& parts,
                std::unordered_multimap<std::size_t, int>& known) {
  const std::size_t print = part.fingerprint();
  const auto [begin, end] = known.equal_range(print);
  for (auto it = begin; it != end; ++it) {
    if (parts[static_cast<std::size_t>(it->second)] == part) return it->second;
  }
  const int index = static_cast<int>(parts.size());
  parts.push_back(part);
  known.emplace(print, index);
  return index;
}

/// The part that most terms have on each mode.
std::vector<int> usual_parts(const std::vector<std::vector<int>>& terms) {
  std::vector<int> usual;
  for (std::size_t k = 0; k < terms.front().size(); ++k) {
    std::unordered_map<int, int> count;
    for (const std::vector<int>& term : terms) ++count[term[k]];
    int best = terms.front()[k];
    for (const std::vector<int>& term : terms) {
      if (count[term[k]] > count[best]) best = term[k];
    }
    usual.push_back(best);
  }
  return usual;
}

}  // namespace

OperatorChain::OperatorChain(const SeparatedOperator& op) {
  modes_.resize(static_cast<std::size_t>(op.modes()));
  terms_.assign(op.terms.size(), std::vector<int>(modes_.size()));
  for (std::size_t k = 0; k < modes_.size(); ++k) {
    std::unordered_multimap<std::size_t, int> known;
    for (std::size_t i = 0; i < op.terms.size(); ++i)
      terms_[i][k] = find_or_add(op.terms[i][k], modes_[k].parts, known);
  }
  link();
}

OperatorChain::OperatorChain(std::vector<std::vector<ModeOperator>> parts,
                             std::vector<std::vector<int>> terms)
    : terms_(std::move(terms)) {
  for (std::vector<ModeOperator>& of_mode : parts) modes_.push_back({std::move(of_mode), {}});
  link();
}

OperatorChain OperatorChain::identity(std::span<const int> sizes) {
  std::vector<std::vector<ModeOperator>> parts;
  for (const int n : sizes) parts.push_back({ModeOperator::identity(n)});
  return {std::move(parts), {std::vector<int>(sizes.size(), 0)}};
}

void OperatorChain::link() {
  const std::size_t d = modes_.size();
  const std::vector<int> usual = usual_parts(terms_);
  // A term that is usual everywhere counts as different on the first mode, with its usual part there.
  std::vector<std::pair<std::size_t, int>> single;  // the mode and its part
  std::vector<const std::vector<int>*> own;
  for (const std::vector<int>& term : terms_) {
    std::size_t different = 0;
    int count = 0;
    for (std::size_t k = d; k-- > 0;) {
      if (term[k] == usual[k]) continue;
      different = k;
      ++count;
    }
    if (count <= 1) {
      single.emplace_back(different, term[different]);
    } else {
      own.push_back(&term);
    }
  }
  // States between modes: 0 before and 1 after the mode on which a single term differs, then the others.
  const bool shares = !single.empty();
  const int first_own = shares ? 2 : 0;
  states_.assign(d + 1, first_own + static_cast<int>(own.size()));
  states_.front() = states_.back() = 1;
  for (std::size_t k = 0; k < d; ++k) {
    const bool first = k == 0;
    const bool last = k + 1 == d;
    std::vector<Link>& links = modes_[k].links;
    const int after = last ? 0 : 1;
    if (shares && !last) links.push_back({0, 0, usual[k]});
    if (shares && !first) links.push_back({1, after, usual[k]});
    for (const auto& [mode, part] : single) {
      if (mode == k) links.push_back({0, after, part});
    }
    for (std::size_t j = 0; j < own.size(); ++j) {
      const int state = first_own + static_cast<int>(j);
      links.push_back({first ? 0 : state, last ? 0 : state, (*own[j])[k]});
    }
  }
}

ChainProducts::ChainProducts(const OperatorChain& chain, Eigen::Index rows, Eigen::Index cols)
    : chain_(&chain) {
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(rows, cols);
  for (int k = 0; k <= chain.modes(); ++k) {
    left_.emplace_back(static_cast<std::size_t>(chain.states(k)), zero);
    if (k == chain.modes()) break;
    grams_.emplace_back(chain.mode(k).parts.size(), zero);
  }
  right_ = left_;
  coefficients_ = grams_;
}

void ChainProducts::refresh(int mode, const Eigen::MatrixXd& v, const Eigen::MatrixXd& u) {
  const std::vector<ModeOperator>& parts = chain_->mode(mode).parts;
  for (std::size_t p = 0; p < parts.size(); ++p)
    gram(mode, static_cast<int>(p)).noalias() = v.transpose() * parts[p].apply(u);
}

void ChainProducts::start() {
  left_.front().front().setOnes();
  multiply_from_the_right();
}

void ChainProducts::start(const Eigen::MatrixXd& first) {
  left_.front().front() = first;
  multiply_from_the_right();
}

void ChainProducts::multiply_from_the_right() {
  right_.back().front().setOnes();
  for (std::size_t k = grams_.size(); k-- > 0;) {
    for (Eigen::MatrixXd& product : right_[k]) product.setZero();
    for (const OperatorChain::Link& link : chain_->mode(static_cast<int>(k)).links) {
      right_[k][static_cast<std::size_t>(link.from)].array() +=
          right_[k + 1][static_cast<std::size_t>(link.to)].array() *
          grams_[k][static_cast<std::size_t>(link.part)].array();
    }
  }
}

const std::vector<Eigen::MatrixXd>& ChainProducts::coefficients(int mode) {
  const auto k = static_cast<std::size_t>(mode);
  for (Eigen::MatrixXd& product : coefficients_[k]) product.setZero();
  for (const OperatorChain::Link& link : chain_->mode(mode).links) {
    coefficients_[k][static_cast<std::size_t>(link.part)].array() +=
        left_[k][static_cast<std::size_t>(link.from)].array() *
        right_[k + 1][static_cast<std::size_t>(link.to)].array();
  }
  return coefficients_[k];
}

void ChainProducts::advance(int mode) {
  const auto k = static_cast<std::size_t>(mode);
  for (Eigen::MatrixXd& product : left_[k + 1]) product.setZero();
  for (const OperatorChain::Link& link : chain_->mode(mode).links) {
    left_[k + 1][static_cast<std::size_t>(link.to)].array() +=
        left_[k][static_cast<std::size_t>(link.from)].array() *
        grams_[k][static_cast<std::size_t>(link.part)].array();
  }
}

}  // namespace samara::pgd
