#include "samara/models/batch/lanes.h"

#include <algorithm>

namespace samara::models {

Lanes::Lanes(const ParametricModel& model, const StepKernel& kernel, std::span<const int> directions)
    : model_(model),
      kernel_(kernel),
      directions_(directions.begin(), directions.end()),
      width_(static_cast<std::size_t>(kernel.width())),
      stride_(width_ * (1 + static_cast<std::size_t>(kernel.directions()))) {
  for (const ParameterInfo& parameter : model.model().info().parameters) {
    defaults_.push_back(parameter.default_value.value_or(0.0));
  }
  const auto states = static_cast<std::size_t>(model.state_count());
  initial_.resize(states);
  x_.resize(states * stride_);
  p_.resize(defaults_.size() * stride_);
}

void Lanes::load(int lane, std::span<const double> q, std::span<const int> directions) {
  const auto clear_and_set = [&](std::vector<double>& to, std::size_t variable, double value) {
    for (std::size_t layer = 0; layer < stride_; layer += width_) to[place(variable, lane) + layer] = 0.0;
    to[place(variable, lane)] = value;
  };
  model_.parameter_values(q, values_);
  for (std::size_t j = 0; j < defaults_.size(); ++j) {
    clear_and_set(p_, j, values_.given[j] ? values_.value[j] : defaults_[j]);
  }
  model_.initial(q, initial_);
  for (std::size_t i = 0; i < initial_.size(); ++i) clear_and_set(x_, i, initial_[i]);
  for (std::size_t d = 0; d < directions.size(); ++d) {
    const FreeCoordinate& coordinate = model_.free()[static_cast<std::size_t>(directions[d])];
    const std::size_t seed = place(static_cast<std::size_t>(coordinate.index), lane) + (d + 1) * width_;
    (coordinate.is_initial ? x_ : p_)[seed] = 1.0;
  }
}

void Lanes::set_state(int lane, std::span<const double> state) {
  for (std::size_t i = 0; i < initial_.size(); ++i) {
    for (std::size_t layer = 0; layer < stride_; layer += width_) x_[place(i, lane) + layer] = 0.0;
    x_[place(i, lane)] = state[i];
  }
}

void Lanes::set_tangent(int lane, int direction, std::span<const double> tangent) {
  const std::size_t offset = (static_cast<std::size_t>(direction) + 1) * width_;
  for (std::size_t i = 0; i < tangent.size(); ++i) x_[place(i, lane) + offset] = tangent[i];
}

void Lanes::save(int lane, std::span<double> numbers) const {
  for (std::size_t n = 0; n < numbers.size(); ++n)
    numbers[n] = x_[n * width_ + static_cast<std::size_t>(lane)];
}

void Lanes::restore(int lane, std::span<const double> numbers) {
  for (std::size_t n = 0; n < numbers.size(); ++n)
    x_[n * width_ + static_cast<std::size_t>(lane)] = numbers[n];
}

void Lanes::read(int lane, int layer, std::span<double> values) const {
  const std::size_t offset = static_cast<std::size_t>(layer) * width_;
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = x_[place(i, lane) + offset];
}

}  // namespace samara::models
