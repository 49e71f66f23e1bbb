#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/model.h"
#include "samara/models/trajectories/interval.h"

namespace samara::apps {

/// "NAME=TEXT" in two; the name may hold signs of its own, but no "=".
struct Setting {
  std::string name, text;
};

/// @param option that the text was given to, for the message
/// @throws ArgumentError for a text without "="
Setting setting_of(const std::string& option, const std::string& text);

/// A number in SI, or a number with a unit of the dimension of `unit`.
/// @throws ArgumentError naming `what` and the text.
double number_or_quantity(const std::string& what, const std::string& text, const std::string& unit);

/// The same of what must be more than 0.
double positive_quantity(const std::string& what, const std::string& text, const std::string& unit);

/// The same as number_or_quantity() of an error or a deviation, which degrees Celsius are none of.
double number_or_difference(const std::string& what, const std::string& text, const std::string& unit);

/// A value, or what stands before and behind "..".
struct EndTexts {
  std::string lower;
  std::optional<std::string> upper;  ///< none of a value
};

/// "0.5..2 mm" is meant as 0.5 mm to 2 mm, as in lists of numbers.
EndTexts ends_of(const std::string& text);

/// "0.2", or from and to: "20 deg..60 deg", "20..60 deg". @throws ArgumentError as number_or_quantity()
models::Interval interval_of(const std::string& name, const std::string& text, const std::string& unit);

/// A place in metres, "0, 5 m, 30 m". @param directions of the three, for the message
/// @throws ArgumentError as number_or_quantity(), and unless there are three numbers
Eigen::Vector3d place_of(const std::string& option, const std::string& text, const std::string& directions);

/// "v(0)" for "v0" or "v@0", which no shell takes apart, where no other name is written so; else the name as it is.
std::string full_name(const std::string& name, const std::vector<std::string>& known);
/// The other way: "v0" for "v(0)"; else the name as it is.
std::string shell_name(const std::string& name, const std::vector<std::string>& known);

/// Whether all parameters that have no default are among the values.
/// @param source of the model, as the caller typed it: its name, or its file
/// @throws ArgumentError naming the others, as --set would give them
void require_parameters(const std::string& source, const models::ModelInfo& info,
                        const std::map<std::string, double>& values);

/// Values of "NAME=VALUE" texts in SI.
/// @param units of every name that may be set
/// @param option that the texts were given to; said of every value, unless it is --set
/// @throws ArgumentError for a text without "=", an unknown name (the nearest is named), one set twice, or a
/// bad value.
std::map<std::string, double> parse_assignments(const std::vector<std::string>& texts,
                                                const std::map<std::string, std::string>& units,
                                                const std::string& option = "--set");

}  // namespace samara::apps
