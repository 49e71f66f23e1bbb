#include "samara/codebooks/file/front_format.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace samara::codebooks {

void write_front(io::Hdf5Writer& file, const std::string& path, const FrontMap& front,
                 const std::vector<pgd::Axis>& axes) {
  file.create_group(path);
  std::vector<std::string> others;
  std::vector<double> coefficients;
  for (const FrontMap::Other& other : front.others()) {
    others.push_back(axes[static_cast<std::size_t>(other.coordinate)].name());
    coefficients.push_back(other.coefficients);
  }
  file.write_text_attribute(path, "coordinate", axes[static_cast<std::size_t>(front.coordinate())].name());
  file.write_texts(path + "/others", others);
  file.write_numbers_attribute(path, "coefficients", coefficients);
  file.write_vector(path + "/place", front.place());
}

namespace {

int axis_of_name(const io::Hdf5Reader& file, const std::string& path, const std::string& name,
                 const std::vector<pgd::Axis>& axes) {
  const auto found = std::ranges::find(axes, name, [](const pgd::Axis& axis) { return axis.name(); });
  if (found == axes.end())
    throw file.error(path, fmt::format("names \"{}\", expected one of the axes of the piece", name));
  return static_cast<int>(found - axes.begin());
}

}  // namespace

FrontMap read_front(const io::Hdf5Reader& file, const std::string& path, const std::vector<pgd::Axis>& axes) {
  const auto axis_at = [&](int place) { return axes[static_cast<std::size_t>(place)]; };
  const int coordinate = axis_of_name(file, path, file.text_attribute(path, "coordinate"), axes);
  const std::vector<std::string> names = file.texts(path + "/others");
  const std::vector<double> coefficients = file.numbers_attribute(path, "coefficients");
  if (names.size() != coefficients.size())
    throw file.error(
        path, fmt::format("has {} others and {} numbers of coefficients", names.size(), coefficients.size()));
  std::vector<FrontMap::Other> others;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const int other = axis_of_name(file, path, names[k], axes);
    if (coefficients[k] != std::floor(coefficients[k]) || !(coefficients[k] >= 1.0) ||
        !(coefficients[k] <= FrontMap::kMostCoefficients)) {
      throw file.error(path, fmt::format("has {} coefficients along \"{}\", expected 1 to {}",
                                         coefficients[k], names[k], FrontMap::kMostCoefficients));
    }
    others.push_back(
        {other, axis_at(other).lower(), axis_at(other).upper(), static_cast<int>(coefficients[k])});
  }
  return {coordinate, axis_at(coordinate).lower(), axis_at(coordinate).upper(), std::move(others),
          file.vector(path + "/place")};
}

}  // namespace samara::codebooks
