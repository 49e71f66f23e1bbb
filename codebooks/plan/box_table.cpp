#include "samara/codebooks/plan/box_table.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "samara/codebooks/plan/plan_subject.h"

namespace samara::codebooks {

namespace {

using io::TomlTable;

/// Basis and transform of a free coordinate.
void read_axis_kind(const TomlTable& table, BoxEntry& entry) {
  entry.basis = pgd::basis_from_string(table.choice("basis", pgd::parameter_basis_names()));
  entry.transform =
      pgd::transform_from_string(table.choice("transform", {"none", "log", "reciprocal", "square_root"}));
  const pgd::BasisTraits& basis = pgd::basis_traits(entry.basis);
  if (!basis.tells_resolution && !entry.nodes)
    throw table.error("basis", fmt::format("is \"{}\", whose nodes the builder cannot choose: expected a key "
                                           "nodes beside it",
                                           to_string(entry.basis)));
  if (basis.odd_nodes && entry.nodes && *entry.nodes % 2 == 0) {
    throw table.error("nodes", fmt::format("is {}, expected an odd number of nodes on a {} axis",
                                           *entry.nodes, to_string(entry.basis)));
  }
  const bool periodic = basis.family == pgd::AxisFamily::periodic;
  if (periodic && entry.name.ends_with("(0)"))
    throw table.error(
        "basis", fmt::format("is \"{}\", but a solution is not periodic in an initial value", basis.name));
  if (periodic && entry.transform != pgd::Transform::none)
    throw table.error("transform", fmt::format("is not \"none\", which a {} axis cannot have", basis.name));
  if (!in_domain(entry.transform, entry.lower)) {
    throw table.error("transform", fmt::format("is \"{}\", which is not defined at the lower end {}",
                                               to_string(entry.transform), entry.lower));
  }
}

}  // namespace

BoxEntry read_box_entry(const TomlTable& box, const std::string& key, const std::string& unit) {
  BoxEntry entry;
  entry.name = key;
  std::vector<double> range;
  if (box.is_table(key)) {
    const TomlTable table = box.table(key);
    table.expect_keys({"range", "nodes", "basis", "transform"});
    range = table.quantities("range", unit);
    if (const auto nodes = table.optional_integer("nodes")) {
      if (*nodes < 2 || *nodes > 2000)
        throw table.error("nodes", fmt::format("is {}, expected 2 to 2000", *nodes));
      entry.nodes = static_cast<int>(*nodes);
    }
  } else {
    range = box.quantities(key, unit);
  }
  if (range.size() != 2)
    throw box.error(key, fmt::format("has {} numbers, expected an interval [lower, upper]", range.size()));
  if (!(range[0] < range[1])) {
    throw box.error(key, fmt::format("is the interval [{}, {}], expected lower < upper", range[0], range[1]));
  }
  constexpr double kLeastWidth = 1e-9;  // of the ends; narrower ones have no nodes that differ
  if (range[1] - range[0] < kLeastWidth * std::max(std::abs(range[0]), std::abs(range[1]))) {
    throw box.error(key, fmt::format("is the interval [{}, {}], expected a width of at least {} of its ends",
                                     range[0], range[1], kLeastWidth));
  }
  entry.lower = range[0];
  entry.upper = range[1];
  if (box.is_table(key)) read_axis_kind(box.table(key), entry);
  return entry;
}

std::string box_entry_text(const BoxEntry& entry, const std::string& lower, const std::string& upper) {
  std::string text = fmt::format("{{ range = [{}, {}]", lower, upper);
  if (entry.nodes) text += fmt::format(", nodes = {}", *entry.nodes);
  if (entry.basis != pgd::Basis::chebyshev) text += fmt::format(", basis = \"{}\"", to_string(entry.basis));
  if (entry.transform != pgd::Transform::none)
    text += fmt::format(", transform = \"{}\"", to_string(entry.transform));
  return text + " }";
}

}  // namespace samara::codebooks
