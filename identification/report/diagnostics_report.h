#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "samara/identification/problem/fit_result.h"

/// Internal to identification/: the part of the reports that says what a fit may claim.
namespace samara::identification {

using Json = nlohmann::ordered_json;

/// "x [m]", as above a column; the name alone where the unit is 1.
std::string with_unit(const std::string& name, const std::string& unit);

/// Null if it is not finite, or not there.
Json number(double value);
Json number(const std::optional<double>& value);
Json column(const Eigen::Ref<const Eigen::VectorXd>& values);

/// Adds "profiles", "identifiability", "whiteness", "bootstrap", "predictions" and "global_search"; null or
/// empty where the result has none.
void add_diagnostics(const FitResult& result, Json& object);

/// The same in sentences and a table.
void add_diagnostics_text(const FitResult& result, std::string& text);

}  // namespace samara::identification
