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

}  // namespace

std::vector<io::SvgPanel> capture_panels(const std::filesystem::path& fit, const std::string& capture) {
  return of_fit(fit, [&](const FitFile& file) {
    std::vector<std::string> ids;
    for (const FitFile& each : file.at("captures")) {
      ids.push_back(each.at("id").get<std::string>());
      if (!capture.empty() && ids.back() != capture) continue;
      std::vector<io::SvgPanel> panels;
      const Eigen::VectorXd times = numbers_of(each.at("times"));
      for (const FitFile& residual : each.at("residuals")) {
        const auto name = residual.at("output").get<std::string>();
        const auto values = each.at("outputs").find(name);
        if (values == each.at("outputs").end()) continue;  // the attitude as a whole
        panels.push_back({.title = fmt::format("{}: {}", ids.back(), name),
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
    }
    throw ArgumentError(
        ids.empty() ? fmt::format("{} has no captures", fit.string())
                    : fmt::format("the fit has no capture \"{}\"{}", capture, suggestion(capture, ids)));
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
