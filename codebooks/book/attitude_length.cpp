#include "samara/codebooks/book/attitude_length.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "samara/models/interface/model.h"

namespace samara::codebooks {

namespace {

/// The states that are the numbers of the quaternion; none where the model is unknown, or has no quaternion.
std::vector<models::StateInfo> quaternion_states(const Codebook& book) {
  const auto model = known_model(book.model());
  if (!model) return {};
  const models::ModelInfo& info = model->info();
  const auto group =
      std::ranges::find(info.groups, models::StateGroupKind::quaternion, &models::StateGroup::kind);
  if (group == info.groups.end()) return {};
  const auto first = info.states.begin() + group->first;
  return {first, first + 4};
}

}  // namespace

std::optional<std::array<int, 4>> quaternion_places(const Codebook& book, const std::vector<int>& outputs) {
  const std::vector<models::StateInfo> states = quaternion_states(book);
  if (states.empty()) return std::nullopt;
  std::array<int, 4> places = {};
  for (std::size_t k = 0; k < 4; ++k) {
    const auto wanted = std::ranges::find_if(
        outputs, [&](int o) { return book.outputs()[static_cast<std::size_t>(o)].name == states[k].name; });
    if (wanted == outputs.end()) return std::nullopt;
    places[k] = static_cast<int>(wanted - outputs.begin());
  }
  return places;
}

std::optional<AttitudeLength> AttitudeLength::of(const Codebook& book, const std::vector<int>& outputs) {
  const auto places = quaternion_places(book, outputs);
  if (!places) return std::nullopt;
  AttitudeLength result;
  result.place_ = *places;
  double square = 0.0;
  for (const models::StateInfo& state : quaternion_states(book)) {
    const std::string initial = state.name + "(0)";
    if (std::ranges::count(book.coordinates(), initial, &Coordinate::name) > 0) return std::nullopt;
    const double start = models::held_start(state, book.model().fixed);
    square += start * start;
  }
  result.length_ = std::sqrt(square);
  return result.length_ > 0.0 ? std::optional(result) : std::nullopt;
}

/// With u = L q/|q| and n = |q|/L, where q' is a derivative: n_j = u.q_j / L^2, u_j = (q_j - u n_j)/n, and
/// u_jk = (q_jk - u_k n_j - u_j n_k - u n_jk)/n with n_jk = (u_k.q_j + u.q_jk) / L^2.
void AttitudeLength::restore(double* const* columns, int order, int coordinates, int times) const {
  const double by_square = 1.0 / (length_ * length_);
  // No call may allocate: derivatives are worked on where they are, the second ones first.
  for (int i = 0; i < times; ++i) {
    const auto at = [&](int column) {
      const double* const from = columns[column];
      return Eigen::Vector4d(from[i + times * place_[0]], from[i + times * place_[1]],
                             from[i + times * place_[2]], from[i + times * place_[3]]);
    };
    const auto put = [&](int column, const Eigen::Vector4d& value) {
      for (std::size_t k = 0; k < 4; ++k)
        columns[column][i + times * place_[k]] = value[static_cast<Eigen::Index>(k)];
    };
    const Eigen::Vector4d q = at(0);
    const double n = q.norm() / length_;
    const Eigen::Vector4d u = q / n;
    const auto slope = [&](const Eigen::Vector4d& by) { return by_square * u.dot(by); };
    const auto first = [&](const Eigen::Vector4d& by) -> Eigen::Vector4d { return (by - u * slope(by)) / n; };
    int column = 1 + coordinates;
    for (int k = 0; order > 1 && k < coordinates; ++k) {
      for (int j = 0; j <= k; ++j, ++column) {
        const Eigen::Vector4d by_j = at(1 + j), by_k = at(1 + k), both = at(column);
        const double bend = by_square * (first(by_k).dot(by_j) + u.dot(both));
        put(column, (both - first(by_k) * slope(by_j) - first(by_j) * slope(by_k) - u * bend) / n);
      }
    }
    for (int k = 0; order > 0 && k < coordinates; ++k) put(1 + k, first(at(1 + k)));
    put(0, u);
  }
}

}  // namespace samara::codebooks
