#include "samara/pgd/fields/field_check.h"

#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/unit_labels.h"

namespace samara::pgd {

namespace {

std::string described(const Axis& axis) {
  const std::string transform =
      axis.transform() == Transform::none ? "" : fmt::format(", {}", to_string(axis.transform()));
  return fmt::format("\"{}\" ({} nodes of {} on [{}, {}]{}{})", axis.name(), axis.size(),
                     to_string(axis.basis()), axis.lower(), axis.upper(), unit_suffix(axis.unit()),
                     transform);
}

bool same_axis(const Axis& a, const Axis& b) {
  // Nodes that went through a file or a unit may differ in the last digits, and their masses follow.
  constexpr double kRoundOff = 1e-12, kRoundOffOfMass = 1e-10;
  return a.name() == b.name() && a.unit() == b.unit() && a.basis() == b.basis() &&
         a.transform() == b.transform() && a.size() == b.size() && a.elements() == b.elements() &&
         (a.nodes() - b.nodes()).cwiseAbs().maxCoeff() <= kRoundOff * a.length() &&
         (a.mass() - b.mass()).norm() <= kRoundOffOfMass * a.mass().norm();
}

}  // namespace

int axis_index(const std::vector<Axis>& axes, const std::string& name) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    if (axes[k].name() == name) return static_cast<int>(k);
    names.push_back(axes[k].name());
  }
  throw ArgumentError(fmt::format("the field has no axis \"{}\"{}", name, suggestion(name, names)));
}

void require_same_axes(const char* what, const std::vector<Axis>& a, const std::vector<Axis>& b) {
  if (a.size() != b.size()) {
    throw ArgumentError(
        fmt::format("{} of fields of {} and {} axes, expected the same axes", what, a.size(), b.size()));
  }
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (same_axis(a[k], b[k])) continue;
    const bool similar = described(a[k]) == described(b[k]);
    throw ArgumentError(fmt::format("{} of fields on the axes {} and {}, expected the same{}", what,
                                    described(a[k]), described(b[k]), similar ? " nodes" : ""));
  }
}

void require_same_outputs(const char* what, const std::vector<OutputLabel>& f,
                          const std::vector<OutputLabel>& g) {
  if (f.size() != g.size()) {
    throw ArgumentError(
        fmt::format("{} of fields of {} and {} outputs, expected the same number", what, f.size(), g.size()));
  }
  for (std::size_t m = 0; m < f.size(); ++m) {
    const OutputLabel& a = f[m];
    const OutputLabel& b = g[m];
    if (a.unit != b.unit) {
      throw ArgumentError(
          fmt::format("{} of the outputs \"{}\" in {} and \"{}\" in {}, expected the same unit", what, a.name,
                      a.unit, b.name, b.unit));
    }
  }
}

void require_another_axis(const std::vector<Axis>& axes) {
  if (axes.size() > 1) return;
  throw ArgumentError(
      fmt::format("\"{}\" is the only axis of the field and cannot go: evaluate the field, or read its "
                  "numbers",
                  axes.front().name()));
}

void require_on_axis(const Axis& axis, double x) {
  if (!std::isfinite(x))
    throw ArgumentError(fmt::format("{} is {}, expected a finite number", axis.name(), x));
  if (!axis.contains(x)) {
    throw OutsideBoxError(fmt::format("{} = {}{} is outside the box [{}, {}]", axis.name(), x,
                                      unit_suffix(axis.unit()), axis.lower(), axis.upper()));
  }
}

void require_inside(const std::vector<Axis>& axes, std::span<const double> x) {
  if (x.size() != axes.size()) {
    throw ArgumentError(fmt::format("the point has {} coordinates, expected {}", x.size(), axes.size()));
  }
  for (std::size_t k = 0; k < axes.size(); ++k) {
    if (axes[k].contains(x[k])) continue;
    if (!std::isfinite(x[k])) {
      throw ArgumentError(fmt::format("{} is {}, expected a finite number", axes[k].name(), x[k]));
    }
    if (x[k] >= axes[k].lower() && x[k] <= axes[k].upper()) {
      throw OutsideBoxError(fmt::format("{} = {}{} is none of the {} values of its axis", axes[k].name(),
                                        x[k], unit_suffix(axes[k].unit()), axes[k].size()));
    }
    throw OutsideBoxError(fmt::format("{} = {}{} is outside the box [{}, {}]", axes[k].name(), x[k],
                                      unit_suffix(axes[k].unit()), axes[k].lower(), axes[k].upper()));
  }
}

}  // namespace samara::pgd
