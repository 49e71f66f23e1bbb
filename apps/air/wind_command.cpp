#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <ranges>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "inputs/assignments.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/base/text.h"
#include "samara/codebooks/model/wind_file.h"
#include "samara/io/csv.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

namespace wind = models::wind;

struct WindArguments {
  std::string file;
  std::vector<std::string> at;  ///< points; none: say what the wind is
  std::string until;            ///< empty: 600 s, as are those below
  std::string step;             ///< 0.05 s
  std::optional<std::uint64_t> seed;
  std::optional<std::uint64_t> realisation;
  std::string output;
  bool json = false;
};

constexpr std::array kDirections = {"along", "across", "vertical"};

double positive_time(const std::string& option, const std::string& text, double otherwise) {
  return text.empty() ? otherwise : positive_quantity(option, text, "s");
}

wind::SeriesOptions series_options(const WindArguments& arguments, const codebooks::SeriesKind& kind) {
  wind::SeriesOptions options{.spectrum = kind.spectrum, .sigma = kind.sigma};
  options.step = positive_time("--step", arguments.step, options.step);
  const double duration = positive_time("--until", arguments.until, 600.0);
  const double samples = std::round(duration / options.step);
  const auto points = static_cast<double>(arguments.at.size());
  const double most = std::floor(wind::kMostSeriesNumbers / (3.0 * points));
  if (!(samples >= 4.0 && samples <= most)) {
    throw ArgumentError(
        fmt::format("--until is {:.6g} s, {:.6g} steps of {:.6g} s; expected 4 to {:.0f} steps at {} {}",
                    duration, samples, options.step, most, points, points > 1.0 ? "points" : "point"));
  }
  options.samples = static_cast<long>(samples);
  options.points.resize(3, static_cast<Eigen::Index>(arguments.at.size()));
  for (std::size_t i = 0; i < arguments.at.size(); ++i)
    options.points.col(static_cast<Eigen::Index>(i)) =
        place_of("--at", arguments.at[i], "along the wind, across it, up");
  return options;
}

std::string csv_of(const wind::WindSeries& series) {
  const Eigen::Index points = series.velocity[0].cols();
  std::vector<std::string> header = {"t[s]"};
  Eigen::MatrixXd rows(series.times.size(), 1 + 3 * points);
  rows.col(0) = series.times;
  for (Eigen::Index i = 0; i < points; ++i) {
    for (std::size_t c = 0; c < kDirections.size(); ++c) {
      header.push_back(fmt::format("{}_{}[m/s]", kDirections[c], i + 1));
      rows.col(1 + 3 * i + static_cast<Eigen::Index>(c)) = series.velocity[c].col(i);
    }
  }
  return io::format_csv(header, rows);
}

/// To four digits, without the sign of what rounds to zero.
double shown(double mean) {
  return std::round(1e4 * mean) / 1e4 + 0.0;
}

/// Correlation of the along-wind parts of two points at equal times.
double correlation(const Eigen::MatrixXd& along, Eigen::Index i, Eigen::Index j) {
  const Eigen::ArrayXd a = along.col(i).array() - along.col(i).mean(),
                       b = along.col(j).array() - along.col(j).mean();
  return (a * b).sum() / std::sqrt(a.square().sum() * b.square().sum());
}

std::string words_of(const wind::WindSeries& series, const wind::SeriesStatistics& statistics,
                     const wind::SeriesOptions& options) {
  std::string text =
      fmt::format("{} samples, one every {:.6g} s\n\n{:<7}{:<10}{:>11}{:>12}{:>20}\n", options.samples,
                  options.step, "point", "component", "mean [m/s]", "sigma [m/s]", "of spectrum [m/s]");
  for (Eigen::Index i = 0; i < options.points.cols(); ++i) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      text += fmt::format("{:<7}{:<10}{:>11.4f}{:>12.4f}{:>20.4f}\n", i + 1,
                          kDirections[static_cast<std::size_t>(c)], shown(statistics.mean(c, i)),
                          statistics.deviation(c, i), statistics.target(c, i));
    }
  }
  for (Eigen::Index i = 1; i < options.points.cols(); ++i)
    text += fmt::format("correlation of points 1 and {} along the wind {:.3f}\n", i + 1,
                        correlation(series.velocity[0], 0, i));
  return text;
}

std::string profile_words(const wind::WindProfile& profile) {
  const wind::ProfileOptions& o = profile.options();
  if (o.kind == wind::ProfileKind::uniform)
    return fmt::format("mean        {:.4g} m/s everywhere\n", o.speed);
  std::string text = fmt::format("mean        {:.4g} m/s at {:.4g} m", o.speed, o.height);
  if (o.kind == wind::ProfileKind::logarithmic)
    text += fmt::format(", u_star {:.4g} m/s, still below {:.4g} m", profile.friction_velocity(),
                        o.displacement + o.roughness);
  text += "\n";
  for (const double z : {0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0})
    text += fmt::format("  {:>5} m   {:.4f} m/s\n", z, profile.speed(z));
  return text;
}

std::string turbulence_words(const codebooks::WindFile& file) {
  const wind::Wind& it = file.wind;
  if (file.seen) {
    const models::Turbulence at_a_metre =
        wind::surface_layer_turbulence(it.profile.friction_velocity(), 1.0, *file.seen);
    return fmt::format(
        "turbulence  as seen along the path: k {:.4g} m^2/s^2, epsilon {:.4g} m^2/s^3 at 1 m\n", at_a_metre.k,
        at_a_metre.epsilon);
  }
  if (!it.turbulence) return "turbulence  none\n";
  constexpr double kCommonBody = 0.1;
  // A wind of small eddies is for smaller bodies.
  const double body =
      it.turbulence->longest ? std::min(kCommonBody, 0.5 * *it.turbulence->longest) : kCommonBody;
  const wind::ModeSpectrum modes = wind::mode_spectrum(it, body);
  const wind::VonKarmanSpectrum& spectrum = modes.spectrum();
  const double longest = 2.0 * std::numbers::pi / modes.options().lowest,
               shortest = 2.0 * std::numbers::pi / modes.options().highest;
  const std::string divergence =
      modes.divergence() > 1e-7 ? fmt::format("  stretched: the divergence is {:.1f} % of the gradient\n",
                                              100.0 * modes.divergence())
                                : "";
  return fmt::format(
             "turbulence  {} modes, sigma {:.4g} m/s, L {:.4g} m (integral length {:.4g} m), epsilon {:.4g} "
             "m^2/s^3\n"
             "  carried at {:.4g} m/s{}\n"
             "  waves from {:.4g} m{} to {:.4g} m hold {:.1f} % of the variance\n",
             modes.options().modes, spectrum.sigma(), spectrum.length(), spectrum.integral_length(),
             spectrum.dissipation(), modes.options().convection.norm(),
             modes.options().frozen ? ", frozen" : ", and swept", shortest,
             it.turbulence->shortest ? "" : " (for a body of that length)", longest,
             100.0 * modes.variance_share()) +
         divergence;
}

Json profile_json(const codebooks::WindFile& file) {
  const wind::ProfileOptions& o = file.wind.profile.options();
  Json heights = Json::array(), speeds = Json::array();
  for (const double z : {0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0}) {
    heights.push_back(z);
    speeds.push_back(file.wind.profile.speed(z));
  }
  return {{"schema", "samara-wind/1"},
          {"speed", o.speed},
          {"height", o.height},
          {"profile", {{"heights", heights}, {"speeds", speeds}}},
          {"has_turbulence", file.wind.turbulence.has_value() || file.seen.has_value()},
          {"gusts", file.wind.gusts.size()}};
}

/// What was drawn, beside what it was drawn from; the series itself where no file has it.
Json series_json(const wind::WindSeries& series, const wind::SeriesStatistics& statistics,
                 const wind::SeriesOptions& options, bool with_series) {
  const auto list = [](const auto& column) { return std::vector<double>(column.begin(), column.end()); };
  Json object = {{"samples", options.samples}, {"step", options.step}, {"points", Json::array()}};
  if (with_series) object["times"] = list(series.times);
  for (Eigen::Index i = 0; i < options.points.cols(); ++i) {
    Json point = {{"place", list(options.points.col(i))}, {"components", Json::array()}};
    for (Eigen::Index c = 0; c < 3; ++c) {
      const auto direction = static_cast<std::size_t>(c);
      Json component = {{"name", kDirections[direction]},
                        {"mean", statistics.mean(c, i)},
                        {"deviation", statistics.deviation(c, i)},
                        {"of_spectrum", statistics.target(c, i)}};
      if (with_series) component["values"] = list(series.velocity[direction].col(i));
      point["components"].push_back(std::move(component));
    }
    object["points"].push_back(std::move(point));
  }
  return object;
}

int run_wind(const WindArguments& arguments) {
  if (!arguments.output.empty()) check_text_output(arguments.output, {arguments.file}, ".csv");
  const codebooks::WindFile file = codebooks::read_wind(arguments.file);
  if (arguments.at.empty()) {
    if (arguments.json) {
      print(profile_json(file));
      return kDone;
    }
    print(profile_words(file.wind.profile) + turbulence_words(file) +
          fmt::format("gusts       {}\n", file.wind.gusts.size()));
    return kDone;
  }
  if (arguments.output.empty() && !arguments.json) throw ArgumentError("--at requires --output, or --json");
  if (!file.series)
    throw InputError(arguments.file, "holds no [series], which says what the series of --at are drawn from");
  const wind::SeriesOptions options = series_options(arguments, *file.series);
  const wind::WindSeries series = wind::wind_series(file.wind.profile, options, arguments.seed.value_or(1),
                                                    arguments.realisation.value_or(0));
  const wind::SeriesStatistics statistics = wind::statistics_of(series, file.wind.profile, options);
  if (arguments.json) {
    if (!arguments.output.empty()) write_answer(arguments.output, csv_of(series));
    Json object = profile_json(file);
    object["series"] = series_json(series, statistics, options, arguments.output.empty());
    print(object);
    return kDone;
  }
  write_answer(arguments.output, csv_of(series));
  print(words_of(series, statistics, options));
  return kDone;
}

}  // namespace

void add_wind(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<WindArguments>();
  CLI::App* command =
      app.add_subcommand("wind", "what a file of a wind means; series of its turbulence at points");
  command->add_option("WIND", values->file, "file of a wind (WIND.toml)")->required();
  CLI::Option* at =
      command
          ->add_option("--at", values->at,
                       "a point, along the wind, across it and up, m or with units: \"0, 5 m, 30 m\"; "
                       "may be repeated")
          ->allow_extra_args(false);
  command->add_option("--until", values->until, "duration of the series, s or with a unit; default 600 s")
      ->needs(at);
  command->add_option("--step", values->step, "of the series, s or with a unit; default 0.05 s")->needs(at);
  command->add_option("--seed", values->seed, "default 1")->check(whole_number<std::uint64_t>())->needs(at);
  command->add_option("--realisation", values->realisation, "number of the series of that seed; default 0")
      ->check(whole_number<std::uint64_t>())
      ->needs(at);
  command
      ->add_option("-o,--output", values->output, "CSV file of the series, which --at needs but for --json")
      ->needs(at);
  command->add_flag("--json", values->json, kJson);
  on_call(*command, arguments, values, run_wind);
}

}  // namespace samara::apps
