#include "samara/identification/statistics/loss.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

namespace samara::identification {

std::string to_string(LossKind kind) {
  switch (kind) {
    case LossKind::none:
      return "none";
    case LossKind::huber:
      return "huber";
    case LossKind::soft_l1:
      return "soft_l1";
    case LossKind::cauchy:
      return "cauchy";
  }
  throw ArgumentError("a loss of no known kind");
}

LossKind loss_kind_from_string(const std::string& name) {
  std::vector<std::string> known;
  for (const LossKind kind : {LossKind::none, LossKind::huber, LossKind::soft_l1, LossKind::cauchy}) {
    known.push_back(to_string(kind));
    if (known.back() == name) return kind;
  }
  throw ArgumentError(fmt::format("there is no loss \"{}\"{}", name, suggestion(name, known)));
}

double efficient_bend(LossKind kind) {
  // (E psi')^2/E psi^2 = 0.95
  switch (kind) {
    case LossKind::none:
      return 1.0;
    case LossKind::huber:
      return 1.345;
    case LossKind::soft_l1:
      return 1.287;
    case LossKind::cauchy:
      return 2.385;
  }
  throw ArgumentError("a loss of no known kind");
}

bool is_density(LossKind kind) {
  switch (kind) {
    case LossKind::none:
    case LossKind::huber:
    case LossKind::soft_l1:
      return true;
    case LossKind::cauchy:
      return false;
  }
  throw ArgumentError("a loss of no known kind");
}

double bounded_loss(LossKind kind, double r) {
  const double s = r * r;
  switch (kind) {
    case LossKind::none:
      return s;
    case LossKind::huber:
      return std::min(s, 1.0);
    case LossKind::soft_l1:
    case LossKind::cauchy:
      return s / (1.0 + s);
  }
  throw ArgumentError("a loss of no known kind");
}

double expected_bounded_loss(LossKind kind) {
  const double c = efficient_bend(kind);
  const double outside = std::erfc(c / std::numbers::sqrt2);
  switch (kind) {
    case LossKind::none:
      return 1.0;
    case LossKind::huber: {
      const double density = std::exp(-0.5 * c * c) / std::sqrt(2.0 * std::numbers::pi);
      return (1.0 - outside - 2.0 * c * density) / (c * c) + outside;
    }
    case LossKind::soft_l1:
    case LossKind::cauchy:
      // E Z^2/(c^2 + Z^2)
      return 1.0 - c * std::sqrt(0.5 * std::numbers::pi) * std::exp(0.5 * c * c) * outside;
  }
  throw ArgumentError("a loss of no known kind");
}

LossValue loss_value(LossKind kind, double r) {
  const double s = r * r;
  switch (kind) {
    case LossKind::none:
      return {s, r, 1.0};
    case LossKind::huber:
      if (s <= 1.0) return {s, r, 1.0};
      return {2.0 * std::abs(r) - 1.0, std::copysign(1.0, r), 0.0};
    case LossKind::soft_l1: {
      const double root = std::sqrt(1.0 + s);
      // 2 (root - 1) without its cancellation.
      return {2.0 * s / (root + 1.0), r / root, 1.0 / (root * root * root)};
    }
    case LossKind::cauchy:
      return {std::log1p(s), r / (1.0 + s), (1.0 - s) / ((1.0 + s) * (1.0 + s))};
  }
  throw ArgumentError("a loss of no known kind");
}

}  // namespace samara::identification
