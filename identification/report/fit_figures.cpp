#include "samara/identification/report/fit_figures.h"

#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/report/read_fit.h"
#include "samara/io/text_file.h"

namespace samara::identification {

namespace {

using FitFile = nlohmann::ordered_json;

/// What `read` makes of the file, which is one of a fit.
template <class Read>
auto of_fit(const std::filesystem::path& path, const Read& read) {
  read_fit(path);  // says what is wrong with another file
  try {
    return read(FitFile::parse(io::read_text_file(path)));
  } catch (const FitFile::exception& error) {
    throw InputError(path.string(), fmt::format("its JSON is none of a fit: {}", error.what()));
  }
}

Eigen::VectorXd numbers_of(const FitFile& list) {
  Eigen::VectorXd numbers(static_cast<Eigen::Index>(list.size()));
  for (std::size_t k = 0; k < list.size(); ++k) {
    numbers[static_cast<Eigen::Index>(k)] =
        list[k].is_null() ? std::numeric_limits<double>::quiet_NaN() : list[k].get<double>();
  }
  return numbers;
}

std::string label_of(const std::string& name, const std::string& unit) {
  return unit == "1" ? name : fmt::format("{} [{}]", name, unit);
}

/// The capture of this id; where several have it, of the id and the file, as in "drop, second.csv".
/// @throws ArgumentError if there is none, or several
std::size_t place_of(const FitFile& captures, const std::string& name) {
  std::vector<std::string> ids, choices;
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < captures.size(); ++k) {
    ids.push_back(captures[k].at("id").get<std::string>());
    const std::string with_file = fmt::format("{}, {}", ids[k], captures[k].at("file").get<std::string>());
    if (with_file == name) return k;
    if (ids[k] != name) continue;
    places.push_back(k);
    choices.push_back(fmt::format("\"{}\"", with_file));
  }
  if (places.size() == 1) return places.front();
  if (places.empty())
    throw ArgumentError(fmt::format("the fit has no capture \"{}\"{}", name, suggestion(name, ids)));
  throw ArgumentError(fmt::format("the fit has {} captures \"{}\"; one of {} was expected", places.size(),
                                  name, join(choices)));
}

}  // namespace

std::vector<io::SvgPanel> capture_panels(const std::filesystem::path& fit, const std::string& capture) {
  return of_fit(fit, [&](const FitFile& file) {
    const FitFile& captures = file.at("captures");
    if (captures.empty()) throw ArgumentError(fmt::format("{} has no captures", fit.string()));
    const FitFile& shown = captures[capture.empty() ? 0 : place_of(captures, capture)];
    const auto id = shown.at("id").get<std::string>();
    std::vector<io::SvgPanel> panels;
    const Eigen::VectorXd times = numbers_of(shown.at("times"));
    for (const FitFile& residual : shown.at("residuals")) {
      const auto name = residual.at("output").get<std::string>();
      const auto values = shown.at("outputs").find(name);
      if (values == shown.at("outputs").end()) continue;  // the attitude as a whole
      panels.push_back({.title = fmt::format("{}: {}", id, name),
                        .x_label = "t [s]",
                        .y_label = label_of(name, residual.at("unit").get<std::string>()),
                        .series = {{.name = "measured",
                                    .x = times,
                                    .y = numbers_of(values->at("measured")),
                                    .kind = io::SvgSeries::Kind::points,
                                    .colour = 1},
                                   {.name = "model", .x = times, .y = numbers_of(values->at("model"))}}});
    }
    return panels;
  });
}

std::vector<io::SvgPanel> profile_panels(const std::filesystem::path& fit) {
  return of_fit(fit, [&](const FitFile& file) {
    std::vector<io::SvgPanel> panels;
    for (const FitFile& profile : file.at("profiles")) {
      const auto name = profile.at("name").get<std::string>();
      std::string unit = "1";
      for (const FitFile& coefficient : file.at("coefficients"))
        if (coefficient.at("name") == name) unit = coefficient.at("unit").get<std::string>();
      const double best = profile.at("best_cost").get<double>(),
                   dispersion = profile.at("dispersion").get<double>();
      const Eigen::VectorXd deviance = 2.0 / dispersion * (numbers_of(profile.at("costs")).array() - best);
      panels.push_back({.title = fmt::format("{}: {}", name, profile.at("shape").get<std::string>()),
                        .x_label = label_of(name, unit),
                        .y_label = "deviance",
                        .series = {{.name = {}, .x = numbers_of(profile.at("values")), .y = deviance}},
                        .rules = {{.at = 2.0 / dispersion * (profile.at("threshold").get<double>() - best)},
                                  {.at = profile.at("best").get<double>(), .is_vertical = true}},
                        .from_zero = false});
    }
    if (panels.empty())
      throw ArgumentError(fmt::format("{} has no profiles: samara fit --profiles makes them", fit.string()));
    return panels;
  });
}

}  // namespace samara::identification
