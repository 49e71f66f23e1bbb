#include "samara/identification/problem/known_values.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/text.h"
#include "samara/identification/captures/number_cells.h"

namespace samara::identification {

namespace {

/// The number in the label or channel of a known coordinate.
double stated_number(const Capture& capture, const std::string& coordinate, const std::string& label) {
  const auto refuse_text = [&](const char* what, const std::string& text) {
    refuse(capture.file,
           fmt::format("capture \"{}\": the {} \"{}\" is \"{}\"; the value of \"{}\" in SI units, a "
                       "finite number, was expected",
                       capture.id, what, label, text, coordinate));
  };
  if (const auto found = capture.labels.find(label); found != capture.labels.end()) {
    const std::optional<double> value = number_in(found->second);
    if (!value) refuse_text("label", found->second);
    return *value;
  }
  if (capture.has(label) && capture.times.size() > 0) {
    const double value = capture.channel(label).values[0];
    if (!std::isfinite(value)) refuse_text("first value of", fmt::format("{}", value));
    return value;
  }
  refuse(capture.file,
         fmt::format("capture \"{}\" has no label \"{}\" and no such channel, which was to hold \"{}\"",
                     capture.id, label, coordinate));
}

}  // namespace

double known_value(const Capture& capture, const std::string& coordinate, const KnownValue& known) {
  return known.times * std::pow(stated_number(capture, coordinate, known.label), known.power);
}

std::vector<double> known_values(const models::FamilyInfo& family, const Capture& capture,
                                 const FitOptions& options) {
  std::vector<double> values;
  for (const auto& [coordinate, known] : options.unknowns.known) {
    const double value = known_value(capture, coordinate, known);
    const auto c = std::ranges::find(family.coordinates, coordinate, &models::FamilyCoordinate::name);
    if (!(value >= c->lower && value <= c->upper)) {
      refuse(capture.file,
             fmt::format("capture \"{}\": the label \"{}\" says that \"{}\" is {}; a value in the box of the "
                         "{}, {} to {}, was expected",
                         capture.id, known.label, coordinate, value, family.source, c->lower, c->upper));
    }
    values.push_back(value);
  }
  return values;
}

bool has_value(const Capture& capture, const KnownValue& known) {
  const auto label = capture.labels.find(known.label);
  return label != capture.labels.end() ? !label->second.empty() : capture.has(known.label);
}

}  // namespace samara::identification
