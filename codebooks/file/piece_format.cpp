#include "samara/codebooks/file/piece_format.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/file/file_format.h"
#include "samara/codebooks/file/front_format.h"

namespace samara::codebooks {

namespace {

using io::Hdf5Reader;
using io::Hdf5Writer;

std::span<const double> as_span(const Eigen::VectorXd& v) {
  return {v.data(), static_cast<std::size_t>(v.size())};
}

/// The lower triangle of a symmetric matrix, entry by entry.
void write_mass(Hdf5Writer& file, const std::string& path, const pgd::SparseMatrix& mass) {
  std::vector<double> rows, columns, values;
  for (int column = 0; column < mass.outerSize(); ++column) {
    for (pgd::SparseMatrix::InnerIterator entry(mass, column); entry; ++entry) {
      if (entry.row() < entry.col()) continue;
      rows.push_back(static_cast<double>(entry.row()));
      columns.push_back(static_cast<double>(entry.col()));
      values.push_back(entry.value());
    }
  }
  const auto write = [&](const char* name, const std::vector<double>& numbers) {
    file.write_vector(path + name, Eigen::Map<const Eigen::VectorXd>(
                                       numbers.data(), static_cast<Eigen::Index>(numbers.size())));
  };
  write("/rows", rows);
  write("/columns", columns);
  write("/values", values);
}

void write_axis(Hdf5Writer& file, const std::string& path, int index, const pgd::Axis& axis) {
  file.write_vector(path, axis.nodes());
  file.make_scale(path, axis.name());
  file.write_integer_attribute(path, "index", index);
  file.write_text_attribute(path, "units", axis.unit());
  file.write_text_attribute(path, "role", to_string(axis.role()));
  file.write_text_attribute(path, "basis", to_string(axis.basis()));
  file.write_text_attribute(path, "transform", to_string(axis.transform()));
  file.write_number_attribute(path, "lower", axis.lower());
  file.write_number_attribute(path, "upper", axis.upper());
  if (!axis.has_elements()) return;
  file.write_integer_attribute(path, "degree", axis.degree());
  file.write_numbers_attribute(path, "borders", as_span(axis.borders()));
}

void write_sum(Hdf5Writer& file, const std::string& piece, const std::string& path,
               const pgd::SeparatedField& field) {
  file.write_matrix(path + "/weights", field.weights());
  for (std::size_t k = 0; k < field.axes().size(); ++k) {
    const std::string& name = field.axes()[k].name();
    file.write_matrix(path + "/factors/" + name, field.factors()[k]);
    file.attach_scale(path + "/factors/" + name, 0, piece + "/axes/" + name);
  }
}

void write_train(Hdf5Writer& file, const std::string& piece, const std::string& path,
                 const pgd::TrainField& field) {
  std::vector<double> values;
  for (std::size_t k = 0; k < field.train().cores.size(); ++k) {
    const pgd::TrainCore& core = field.train().cores[k];
    const std::string name = fmt::format("{}/cores/{}", path, k);
    values.clear();
    for (int l = 0; l < core.left; ++l) {
      for (int i = 0; i < core.size; ++i) {
        for (int r = 0; r < core.right; ++r) values.push_back(core.slice(i)(l, r));
      }
    }
    file.write_block(name, {core.left, core.size, core.right}, values);
    if (k > 0) file.attach_scale(name, 1, piece + "/axes/" + field.axes()[k - 1].name());
  }
}

void write_group(Hdf5Writer& file, const std::string& piece, const std::string& path,
                 const FieldGroup& group) {
  file.create_group(path);
  std::vector<std::string> names, units;
  for (const pgd::OutputLabel& output : group.outputs()) {
    names.push_back(output.name);
    units.push_back(output.unit);
  }
  file.write_text_attribute(path, "kind", group.train() != nullptr ? format::kTrain : format::kSum);
  file.write_texts(path + "/outputs", names);
  file.write_texts(path + "/units", units);
  if (const pgd::TrainField* train = group.train()) {
    write_train(file, piece, path, *train);
  } else {
    write_sum(file, piece, path, *group.sum());
  }
}

}  // namespace

void write_piece(Hdf5Writer& file, const std::string& path, const Piece& piece) {
  std::vector<double> lower, upper;
  const std::vector<pgd::Axis>& axes = piece.groups().front().axes();
  for (std::size_t k = 0; k < axes.size(); ++k) {
    write_axis(file, path + "/axes/" + axes[k].name(), static_cast<int>(k), axes[k]);
    if (!pgd::basis_traits(axes[k].basis()).storable)
      write_mass(file, path + "/mass/" + axes[k].name(), axes[k].mass());
    lower.push_back(axes[k].lower());
    upper.push_back(axes[k].upper());
  }
  file.write_numbers_attribute(path, "lower", lower);
  file.write_numbers_attribute(path, "upper", upper);
  for (std::size_t g = 0; g < piece.groups().size(); ++g) {
    write_group(file, path, fmt::format("{}/groups/{}", path, g), piece.groups()[g]);
  }
  if (piece.front() != nullptr) write_front(file, path + "/front", *piece.front(), axes);
}

int numbered_children(const Hdf5Reader& file, const std::string& group) {
  const std::vector<std::string> names = file.children(group);  // sorted
  const auto count = static_cast<int>(names.size());
  for (int k = 0; k < count; ++k) {
    if (!std::binary_search(names.begin(), names.end(), fmt::format("{}", k)))
      throw file.error(group, fmt::format("member {} of {} is missing", k, count));
  }
  if (count == 0) throw file.error(group, "is empty, expected at least one member");
  return count;
}

namespace {

/// `lower` and `upper` of an object, for readers that do not look at borders, must be what they say.
void check_ends(const Hdf5Reader& file, const std::string& path, const std::vector<double>& lower,
                const std::vector<double>& upper) {
  if (file.numbers_attribute(path, "lower") != lower)
    throw file.error(path, "attribute lower is not where the axes begin");
  if (file.numbers_attribute(path, "upper") != upper)
    throw file.error(path, "attribute upper is not where the axes end");
}

/// The tables of one element, or of a fourier axis, take degree^2 numbers of memory: no plan makes such.
constexpr Eigen::Index kLargestDegree = 4096;

pgd::Axis read_periodic_axis(const Hdf5Reader& file, const std::string& path, pgd::Axis::Label label,
                             const pgd::BasisTraits& basis, Eigen::Index size) {
  if (size > kLargestDegree) {
    throw file.error(path, fmt::format("has {} nodes, expected at most {} on a {} axis", size, kLargestDegree,
                                       basis.name));
  }
  return basis.over_interval(std::move(label), file.number_attribute(path, "lower"),
                             file.number_attribute(path, "upper"), static_cast<int>(size));
}

pgd::Axis read_axis_of_elements(const Hdf5Reader& file, const std::string& path, pgd::Axis::Label label,
                                pgd::Basis basis, const Eigen::VectorXd& nodes) {
  const std::vector<double> border_list = file.numbers_attribute(path, "borders");
  const Eigen::VectorXd borders =
      Eigen::Map<const Eigen::VectorXd>(border_list.data(), static_cast<Eigen::Index>(border_list.size()));
  const auto degree = static_cast<Eigen::Index>(file.integer_attribute(path, "degree"));
  if (degree > kLargestDegree) {
    throw file.error(path, fmt::format("degree is {}, expected at most {}", degree, kLargestDegree));
  }
  if (degree < 1 || borders.size() < 2 || (borders.size() - 1) * degree + 1 != nodes.size()) {
    throw file.error(path, fmt::format("{} nodes do not fit {} borders and degree {}", nodes.size(),
                                       borders.size(), degree));
  }
  return pgd::Axis::of_elements(std::move(label), basis, borders, static_cast<int>(degree));
}

/// Numbers of nodes, stored as doubles.
std::vector<int> read_places(const Hdf5Reader& file, const std::string& path, Eigen::Index entries,
                             Eigen::Index nodes) {
  std::vector<int> places;
  for (const double number : file.vector(path, {.rows = entries})) {
    if (number != std::floor(number) || number < 0.0 || !(number < static_cast<double>(nodes)))
      throw file.error(path, fmt::format("holds {}, expected whole numbers from 0 to {}", number, nodes - 1));
    places.push_back(static_cast<int>(number));
  }
  return places;
}

pgd::SparseMatrix read_mass(const Hdf5Reader& file, const std::string& path, Eigen::Index nodes) {
  const Eigen::VectorXd values = file.vector(path + "/values");
  const std::vector<int> rows = read_places(file, path + "/rows", values.size(), nodes);
  const std::vector<int> columns = read_places(file, path + "/columns", values.size(), nodes);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double value = values[static_cast<Eigen::Index>(i)];
    const bool follows = i == 0 || std::pair(columns[i - 1], rows[i - 1]) < std::pair(columns[i], rows[i]);
    if (rows[i] < columns[i] || !follows)
      throw file.error(path,
                       fmt::format("entry {} at ({}, {}) is not the next one of a lower triangle, column by "
                                   "column",
                                   i, rows[i], columns[i]));
    entries.emplace_back(rows[i], columns[i], value);
    if (rows[i] != columns[i]) entries.emplace_back(columns[i], rows[i], value);
  }
  pgd::SparseMatrix mass(nodes, nodes);
  mass.setFromTriplets(entries.begin(), entries.end());
  return mass;
}

/// @param mass where that of the axis is, if it has one of its own
pgd::Axis read_axis_of_basis(const Hdf5Reader& file, const std::string& path, const std::string& mass,
                             pgd::Axis::Label label, const pgd::BasisTraits& basis,
                             const Eigen::VectorXd& nodes) {
  switch (basis.family) {
    case pgd::AxisFamily::elements:
      return read_axis_of_elements(file, path, std::move(label), basis.basis, nodes);
    case pgd::AxisFamily::periodic:
      return read_periodic_axis(file, path, std::move(label), basis, nodes.size());
    case pgd::AxisFamily::list:
      break;
  }
  if (!basis.storable) return pgd::Axis::imported(std::move(label), read_mass(file, mass, nodes.size()));
  return pgd::Axis::discrete(std::move(label), nodes);
}

/// Axes are rebuilt from their attributes; the nodes in the file must be the ones that follow.
pgd::Axis read_axis(const Hdf5Reader& file, const std::string& piece, const std::string& name) {
  const std::string path = piece + "/axes/" + name;
  const Eigen::VectorXd nodes = file.vector(path);
  try {
    pgd::Axis::Label label{name, file.text_attribute(path, "units"),
                           pgd::role_from_string(file.text_attribute(path, "role")),
                           pgd::transform_from_string(file.text_attribute(path, "transform"))};
    const pgd::BasisTraits& basis =
        pgd::basis_traits(pgd::basis_from_string(file.text_attribute(path, "basis")));
    const pgd::Axis axis =
        read_axis_of_basis(file, path, piece + "/mass/" + name, std::move(label), basis, nodes);
    const bool fits =
        axis.size() == nodes.size() && (axis.nodes() - nodes).cwiseAbs().maxCoeff() <=
                                           1e-12 * std::max(axis.length(), nodes.cwiseAbs().maxCoeff());
    if (!fits) throw file.error(path, fmt::format("the nodes are not those of a {} axis", basis.name));
    check_ends(file, path, {axis.lower()}, {axis.upper()});
    return axis;
  } catch (const ArgumentError& error) {
    throw file.error(path, error.what());
  }
}

std::vector<pgd::Axis> read_axes(const Hdf5Reader& file, const std::string& piece) {
  const std::string group = piece + "/axes";
  const std::vector<std::string> names = file.children(group);
  std::vector<std::string> ordered(names.size());
  for (const std::string& name : names) {
    const auto index = static_cast<std::size_t>(file.integer_attribute(group + "/" + name, "index"));
    if (index >= names.size() || !ordered[index].empty()) {
      throw file.error(group + "/" + name,
                       fmt::format("index {} is taken or not below {}", index, names.size()));
    }
    ordered[index] = name;
  }
  std::vector<pgd::Axis> axes;
  for (const std::string& name : ordered) axes.push_back(read_axis(file, piece, name));
  if (axes.empty()) throw file.error(group, "is empty, expected at least one axis");
  return axes;
}

std::vector<pgd::OutputLabel> read_outputs(const Hdf5Reader& file, const std::string& path) {
  const std::vector<std::string> names = file.texts(path + "/outputs");
  const std::vector<std::string> units = file.texts(path + "/units");
  if (names.size() != units.size() || names.empty()) {
    throw file.error(path, fmt::format("has {} outputs and {} units", names.size(), units.size()));
  }
  std::vector<pgd::OutputLabel> outputs;
  for (std::size_t o = 0; o < names.size(); ++o) outputs.push_back({names[o], units[o]});
  return outputs;
}

pgd::SeparatedField read_sum(const Hdf5Reader& file, const std::string& path,
                             const std::vector<pgd::Axis>& axes) {
  std::vector<pgd::OutputLabel> outputs = read_outputs(file, path);
  Eigen::MatrixXd weights =
      file.matrix(path + "/weights", {.rows = static_cast<Eigen::Index>(outputs.size())});
  std::vector<Eigen::MatrixXd> factors;
  for (const pgd::Axis& axis : axes) {
    factors.push_back(
        file.matrix(path + "/factors/" + axis.name(), {.rows = axis.size(), .columns = weights.cols()}));
  }
  return pgd::SeparatedField(axes, std::move(outputs), std::move(factors), std::move(weights));
}

/// @param left, size what the core before and the axis ask for
pgd::TrainCore read_core(const Hdf5Reader& file, const std::string& path, int left, int size) {
  const io::Hdf5Block block = file.block(path);
  if (block.size[0] != left || block.size[1] != size || block.size[2] < 1) {
    throw file.error(path, fmt::format("has the size {} x {} x {}, expected {} x {} x a rank", block.size[0],
                                       block.size[1], block.size[2], left, size));
  }
  pgd::TrainCore core(left, size, static_cast<int>(block.size[2]));
  auto value = block.values.begin();
  for (int l = 0; l < left; ++l) {
    for (int i = 0; i < size; ++i) {
      for (int r = 0; r < core.right; ++r)
        core.data[l + Eigen::Index{left} * (i + Eigen::Index{size} * r)] = *value++;
    }
  }
  return core;
}

pgd::TrainField read_train(const Hdf5Reader& file, const std::string& path,
                           const std::vector<pgd::Axis>& axes) {
  std::vector<pgd::OutputLabel> outputs = read_outputs(file, path);
  const std::string cores = path + "/cores";
  const int count = numbered_children(file, cores);
  if (count != static_cast<int>(axes.size()) + 1) {
    throw file.error(cores, fmt::format("has {} cores, expected {}: of the outputs, then of every axis",
                                        count, axes.size() + 1));
  }
  pgd::TensorTrain train;
  int left = 1;
  for (std::size_t k = 0; k <= axes.size(); ++k) {
    const int size = k == 0 ? static_cast<int>(outputs.size()) : axes[k - 1].size();
    train.cores.push_back(read_core(file, fmt::format("{}/{}", cores, k), left, size));
    left = train.cores.back().right;
  }
  if (left != 1) {
    throw file.error(fmt::format("{}/{}", cores, axes.size()),
                     fmt::format("ends with the rank {}, expected 1", left));
  }
  return pgd::TrainField(axes, std::move(outputs), std::move(train));
}

FieldGroup read_group(const Hdf5Reader& file, const std::string& path, const std::vector<pgd::Axis>& axes) {
  const std::string kind = file.text_attribute(path, "kind");
  if (kind == format::kSum) return read_sum(file, path, axes);
  if (kind == format::kTrain) return read_train(file, path, axes);
  throw file.error(
      path, fmt::format("kind is \"{}\", expected \"{}\" or \"{}\"", kind, format::kSum, format::kTrain));
}

/// Numbers of a dataset, and the size of its last dimension.
struct Shape {
  long entries = 1;
  int last = 0;
};

Shape shape_of(const Hdf5Reader& file, const std::string& path, std::size_t dimensions) {
  const std::vector<Eigen::Index> sizes = file.shape(path);
  if (sizes.size() != dimensions)
    throw file.error(path, fmt::format("has {} dimensions, expected {}", sizes.size(), dimensions));
  Shape shape;
  for (const Eigen::Index size : sizes) shape.entries *= size;
  shape.last = static_cast<int>(sizes.back());
  return shape;
}

GroupOutline read_group_outline(const Hdf5Reader& file, const std::string& path,
                                const std::vector<pgd::Axis>& axes) {
  GroupOutline group{read_outputs(file, path), file.text_attribute(path, "kind") == format::kTrain, {}, 0};
  if (!group.is_train) {
    const Shape weights = shape_of(file, path + "/weights", 2);
    group.ranks.push_back(weights.last);
    group.entries = weights.entries;
    for (const pgd::Axis& axis : axes)
      group.entries += shape_of(file, path + "/factors/" + axis.name(), 2).entries;
    return group;
  }
  for (std::size_t k = 0; k <= axes.size(); ++k) {
    const Shape core = shape_of(file, fmt::format("{}/cores/{}", path, k), 3);
    group.entries += core.entries;
    if (k < axes.size()) group.ranks.push_back(core.last);
  }
  return group;
}

}  // namespace

PieceOutline read_outline(const Hdf5Reader& file, const std::string& path) {
  PieceOutline outline{read_axes(file, path), {}};
  const int count = numbered_children(file, path + "/groups");
  for (int g = 0; g < count; ++g)
    outline.groups.push_back(read_group_outline(file, fmt::format("{}/groups/{}", path, g), outline.axes));
  return outline;
}

Piece read_piece(const Hdf5Reader& file, const std::string& path) {
  const std::vector<pgd::Axis> axes = read_axes(file, path);
  std::vector<double> lower, upper;
  for (const pgd::Axis& axis : axes) {
    lower.push_back(axis.lower());
    upper.push_back(axis.upper());
  }
  check_ends(file, path, lower, upper);
  Piece::Groups groups;
  const int count = numbered_children(file, path + "/groups");
  for (int g = 0; g < count; ++g)
    groups.push_back(read_group(file, fmt::format("{}/groups/{}", path, g), axes));
  if (!file.has(path + "/front")) return groups;
  const std::string front = path + "/front";
  try {
    return {std::move(groups), read_front(file, front, axes)};
  } catch (const ArgumentError& error) {
    throw file.error(front, error.what());
  }
}

}  // namespace samara::codebooks
