#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace samara::apps {

/// What stands after the number of a text: "s" of "0.2 s"; nothing where there is no number.
std::string unit_behind(const std::string& text);

/// Numbers of "0.3", of a list "0.1, 0.2 s" or of a range "FROM:STEP:TO" such as "0:0.1:0.5"; a unit at the end holds
/// for those before it that have none. TO is among them where a whole number of steps leads there.
/// @param option for the message @param unit of the numbers, SI
/// @throws ArgumentError as number_or_quantity(), for a step that does not lead from FROM to TO, and for more than ten
/// million numbers
std::vector<double> numbers_of(const std::string& option, const std::string& text, const std::string& unit);

/// All of several such texts, one after the other.
std::vector<double> numbers_of(const std::string& option, const std::vector<std::string>& texts,
                               const std::string& unit);

/// Times at even distances, both ends among them; those between are the nearest of 15 digits, 0.3 and not
/// 0.30000000000000004.
Eigen::VectorXd even_times(Eigen::Index count, double from, double to);

}  // namespace samara::apps
