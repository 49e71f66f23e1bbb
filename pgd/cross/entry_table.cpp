#include "samara/pgd/cross/entry_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::pgd {

EntryTable::EntryTable(const EntryFunction& function, int outputs, std::vector<int> sizes)
    : function_(function), outputs_(outputs), sizes_(std::move(sizes)) {
  double entries = 1.0;
  for (const int n : sizes_) entries *= n;
  if (!(entries < 0x1.0p63)) {
    throw ArgumentError(fmt::format("the grid has {:.3g} entries, expected less than 2^63", entries));
  }
}

std::uint64_t EntryTable::key(const Eigen::Ref<const Eigen::VectorXi>& entry) const {
  std::uint64_t linear = 0;
  for (std::size_t k = sizes_.size(); k-- > 0;) {
    linear = linear * static_cast<std::uint64_t>(sizes_[k]) +
             static_cast<std::uint64_t>(entry[static_cast<Eigen::Index>(k)]);
  }
  return linear;
}

std::vector<std::size_t> EntryTable::positions(const IndexBatch& entries) {
  std::vector<std::size_t> position(static_cast<std::size_t>(entries.cols()));
  std::vector<int> missing;
  for (Eigen::Index j = 0; j < entries.cols(); ++j) {
    const auto [it, is_new] = columns_.try_emplace(key(entries.col(j)), columns_.size());
    position[static_cast<std::size_t>(j)] = it->second;
    if (is_new) missing.push_back(static_cast<int>(j));
  }
  if (!missing.empty()) evaluate(entries(Eigen::all, missing));
  return position;
}

Eigen::MatrixXd EntryTable::fetch(const IndexBatch& entries) {
  const std::vector<std::size_t> position = positions(entries);
  Eigen::MatrixXd result(outputs_, entries.cols());
  for (Eigen::Index j = 0; j < entries.cols(); ++j) {
    const double* value =
        values_.data() + position[static_cast<std::size_t>(j)] * static_cast<std::size_t>(outputs_);
    result.col(j) = Eigen::Map<const Eigen::VectorXd>(value, outputs_);
  }
  return result;
}

Eigen::VectorXd EntryTable::fetch(const IndexBatch& entries,
                                  const Eigen::Ref<const Eigen::VectorXi>& outputs) {
  const std::vector<std::size_t> position = positions(entries);
  Eigen::VectorXd result(entries.cols());
  for (Eigen::Index j = 0; j < entries.cols(); ++j) {
    result[j] = values_[position[static_cast<std::size_t>(j)] * static_cast<std::size_t>(outputs_) +
                        static_cast<std::size_t>(outputs[j % outputs.size()])];
  }
  return result;
}

void EntryTable::evaluate(const IndexBatch& missing) {
  Eigen::MatrixXd values(outputs_, missing.cols());
  function_(missing, values);
  for (Eigen::Index j = 0; j < values.cols(); ++j) {
    if (values.col(j).allFinite()) {
      largest_ = std::max(largest_, values.col(j).cwiseAbs().maxCoeff());
    } else if (bad_entry_.empty()) {
      bad_entry_.assign(missing.col(j).begin(), missing.col(j).end());
    }
  }
  values_.insert(values_.end(), values.data(), values.data() + values.size());
}

}  // namespace samara::pgd
