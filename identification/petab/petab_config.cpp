#include "samara/identification/petab/petab_config.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace samara::identification {

namespace {

/// A name as a key or text of TOML.
std::string toml_text(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + '"';
}

/// A number that is not taken for a whole one.
std::string toml_number(double value) {
  const std::string text = fmt::format("{}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string toml_list(const std::vector<std::string>& names) {
  std::vector<std::string> texts;
  for (const std::string& name : names) texts.push_back(toml_text(name));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string toml_line(const std::string& key, const std::string& value) {
  return fmt::format("{} = {}\n", toml_text(key), value);
}

std::string prior_line(const PetabParameter& p) {
  const bool is_logarithmic = p.prior == "logNormal";
  const double mean = is_logarithmic ? std::exp(p.prior_numbers[0]) : p.prior_numbers[0];
  return toml_line(p.coordinate,
                   fmt::format("{{ mean = {}, deviation = {}, logarithmic = {} }}", toml_number(mean),
                               toml_number(p.prior_numbers[1]), is_logarithmic));
}

/// PEtab compares angles as they are, not by the circle.
std::string without_periods(const PetabProblem& problem) {
  std::string lines;
  if (problem.captures.empty()) return lines;
  for (const Channel& channel : problem.captures.front().channels)
    if (channel.unit == "rad") lines += toml_line(channel.quantity, "0.0");
  return lines;
}

}  // namespace

std::string petab_config(const PetabProblem& problem, const PetabSettings& settings) {
  std::vector<std::string> outputs, shared, own, by_factors;
  for (const auto& [output, id] : problem.observables) outputs.push_back(output);
  const std::string periods = without_periods(problem);
  std::string box, initial, priors, held, known, noise, levels;
  for (const PetabParameter& p : problem.parameters) {
    if (!p.estimated || p.coordinate.empty()) continue;
    std::vector<std::string>& role = p.condition.empty() ? shared : own;
    if (std::ranges::count(role, p.coordinate) > 0) continue;
    role.push_back(p.coordinate);
    box += toml_line(p.coordinate, fmt::format("[{}, {}]", toml_number(p.lower), toml_number(p.upper)));
    // A uniform prior may leave the nominal value out, where the fit would begin.
    if (p.nominal && p.condition.empty())
      initial += toml_line(p.coordinate, toml_number(std::clamp(*p.nominal, p.lower, p.upper)));
    if (!p.prior.empty()) priors += prior_line(p);
    const bool is_on_log_scale = p.scale == "log" || p.scale == "log10";
    if (is_on_log_scale && p.lower > 0.0 && p.condition.empty()) by_factors.push_back(p.coordinate);
  }
  for (const auto& [name, value] : settings.held) held += toml_line(name, toml_number(value));
  for (const auto& [name, interval] : settings.known) {
    known += toml_line(name, toml_text(name));
    box += toml_line(name, fmt::format("[{}, {}]", toml_number(interval.lower), toml_number(interval.upper)));
  }
  for (const auto& [output, level] : settings.noise) noise += toml_line(output, toml_number(level));
  for (const auto& [output, parameter] : settings.estimated_noise)
    levels += fmt::format("{}{} = {}", levels.empty() ? "" : ", ", toml_text(output), toml_text(parameter));
  std::string text = fmt::format("outputs = {}\noffsets = []\n", toml_list(outputs));
  if (!shared.empty()) text += fmt::format("shared = {}\n", toml_list(shared));
  if (!own.empty()) text += fmt::format("per_capture = {}\n", toml_list(own));
  if (!by_factors.empty()) text += fmt::format("log_scale = {}\n", toml_list(by_factors));
  if (!levels.empty()) text += fmt::format("noise = {{ levels = {{ {} }} }}\n", levels);
  text += "loss.kind = \"none\"\n";
  if (settings.attitude_noise)
    text += fmt::format("attitude_scale = {}\n", toml_number(*settings.attitude_noise));
  for (const auto& [heading, lines] : {std::pair<const char*, const std::string&>{"loss.scale", noise},
                                       {"periods", periods},
                                       {"fixed", held},
                                       {"known", known},
                                       {"box", box},
                                       {"initial", initial},
                                       {"priors", priors}})
    if (!lines.empty()) text += fmt::format("[{}]\n{}", heading, lines);
  return text;
}

}  // namespace samara::identification
