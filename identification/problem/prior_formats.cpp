#include "samara/identification/problem/prior_formats.h"

#include <fmt/format.h>

namespace samara::identification {

Prior read_prior(const io::TomlTable& table, const std::string& unit) {
  table.expect_keys({"mean", "deviation", "logarithmic"});
  const auto require_positive = [&](const char* key, double value) {
    if (!(value > 0.0))
      throw table.error(key, fmt::format("the value is {}; more than 0 was expected", value));
  };
  Prior prior{.mean = table.quantity("mean", unit),
              .logarithmic = table.optional_boolean("logarithmic").value_or(false)};
  prior.deviation = prior.logarithmic ? table.number("deviation") : table.difference("deviation", unit);
  require_positive("deviation", prior.deviation);
  if (prior.logarithmic) require_positive("mean", prior.mean);
  return prior;
}

nlohmann::ordered_json prior_json(const Prior& prior) {
  return {{"mean", prior.mean}, {"deviation", prior.deviation}, {"logarithmic", prior.logarithmic}};
}

Prior prior_of(const nlohmann::json& object) {
  return {.mean = object.at("mean").get<double>(),
          .deviation = object.at("deviation").get<double>(),
          .logarithmic = object.at("logarithmic").get<bool>()};
}

}  // namespace samara::identification
