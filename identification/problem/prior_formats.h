#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "samara/identification/problem/priors.h"
#include "samara/io/toml_document.h"

/// Internal to identification/: how a prior stands in a fit's config, and in its result.
namespace samara::identification {

/// A table of [priors]: mean, deviation, logarithmic.
/// @param unit of the coordinate, where numbers come with one
/// @throws InputError naming the key for a deviation, or a median, that is not positive
Prior read_prior(const io::TomlTable& table, const std::string& unit);

nlohmann::ordered_json prior_json(const Prior& prior);
/// The same backwards. @throws nlohmann::json::exception where a number is missing
Prior prior_of(const nlohmann::json& object);

}  // namespace samara::identification
