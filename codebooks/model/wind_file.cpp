#include "samara/codebooks/model/wind_file.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/io/toml_document.h"

namespace samara::codebooks {

namespace {

using io::TomlTable;
using models::wind::EnergyConstants;
using models::wind::Gust;
using models::wind::GustOptions;
using models::wind::GustShape;
using models::wind::ProfileKind;
using models::wind::ProfileOptions;
using models::wind::WindProfile;

double not_negative(const TomlTable& table, const std::string& key, const std::string& unit, double value) {
  if (!(value >= 0.0)) throw table.error(key, fmt::format("is {:.6g} {}, expected at least 0", value, unit));
  return value;
}

std::vector<std::string> mean_keys(ProfileKind kind) {
  switch (kind) {
    case ProfileKind::uniform:
      return {"profile", "speed", "towards"};
    case ProfileKind::power:
      return {"profile", "speed", "towards", "height", "exponent"};
    case ProfileKind::logarithmic:
      break;
  }
  return {"profile", "speed", "towards", "height", "roughness", "displacement"};
}

ProfileOptions read_profile(const TomlTable& mean) {
  ProfileOptions options;
  const std::string kind = mean.choice("profile", {"logarithmic", "power", "uniform"});
  if (kind == "power") options.kind = ProfileKind::power;
  if (kind == "uniform") options.kind = ProfileKind::uniform;
  mean.expect_keys(mean_keys(options.kind));
  options.speed = not_negative(mean, "speed", "m/s", mean.quantity("speed", "m/s"));
  options.height = mean.optional_positive("height", "m").value_or(options.height);
  options.roughness = mean.optional_positive("roughness", "m").value_or(options.roughness);
  options.displacement =
      not_negative(mean, "displacement", "m", mean.optional_quantity("displacement", "m").value_or(0.0));
  options.exponent = mean.optional_positive("exponent", "1").value_or(options.exponent);
  const double least = options.displacement + options.roughness;
  if (options.kind == ProfileKind::logarithmic && !(options.height > least)) {
    throw mean.error(
        mean.has("roughness") ? "roughness" : "height",
        fmt::format("leaves no wind: the height of the mean speed is {:.6g} m, expected more than "
                    "displacement and roughness, {:.6g} m",
                    options.height, least));
  }
  return options;
}

EnergyConstants read_constants(const TomlTable& table) {
  const bool of_model = table.choice("constants", {"kaimal", "k-epsilon"}) == "k-epsilon";
  return of_model ? EnergyConstants::k_epsilon : EnergyConstants::kaimal;
}

/// [turbulence] of the kind "seen".
EnergyConstants read_seen(const TomlTable& table, const models::wind::Wind& wind) {
  table.expect_keys({"kind", "constants"});
  const ProfileOptions& mean = wind.profile.options();
  if (mean.kind != ProfileKind::logarithmic || !(mean.speed > 0.0))
    throw table.error("kind", "\"seen\" follows from a logarithmic profile with a wind only");
  if (!wind.gusts.empty()) throw table.error("kind", "\"seen\" takes no [[gusts]], expected \"modes\"");
  return read_constants(table);
}

models::wind::TurbulenceOptions read_turbulence(const TomlTable& table, const ProfileOptions& mean) {
  table.expect_keys(
      {"kind", "height", "sigma", "length", "constants", "ratios", "modes", "shortest", "longest", "frozen"});
  models::wind::TurbulenceOptions options;
  options.height = table.optional_positive("height", "m");
  options.sigma = table.optional_positive("sigma", "m/s");
  const bool has_iec_length = table.is_string("length") && table.string("length") == "iec";
  if (!has_iec_length) options.length = table.optional_positive("length", "m");
  options.shortest = table.optional_positive("shortest", "m");
  options.longest = table.optional_positive("longest", "m");
  if (options.shortest && options.longest && !(*options.longest > *options.shortest)) {
    throw table.error("longest", fmt::format("is {:.6g} m, expected more than the shortest wave, {:.6g} m",
                                             *options.longest, *options.shortest));
  }
  options.constants = read_constants(table);
  if (const auto ratios = table.optional_numbers("ratios")) {
    if (ratios->size() != 3 || std::ranges::any_of(*ratios, [](double ratio) { return !(ratio > 0.0); }))
      throw table.error("ratios", "are other than 3 numbers above 0: along the wind, across it, vertical");
    options.ratios = {(*ratios)[0], (*ratios)[1], (*ratios)[2]};
  }
  const std::int64_t modes = table.optional_integer("modes").value_or(options.modes);
  if (modes < 1 || modes > models::wind::kMostModes) {
    throw table.error("modes", fmt::format("is {}, expected 1 to {}", modes, models::wind::kMostModes));
  }
  options.modes = static_cast<int>(modes);
  options.frozen = table.optional_boolean("frozen").value_or(false);
  const double height = options.height.value_or(mean.height);
  if (mean.kind == ProfileKind::logarithmic && !(height > mean.displacement + mean.roughness)) {
    throw table.error(
        "height", fmt::format("is {:.6g} m, expected more than displacement and roughness, {:.6g} m", height,
                              mean.displacement + mean.roughness));
  }
  if (has_iec_length) options.length = 0.8 * models::wind::iec_scale(height);
  if (options.sigma && options.length) return options;
  const std::string missing = options.sigma ? "length" : "sigma";
  if (mean.kind != ProfileKind::logarithmic || !(mean.speed > 0.0)) {
    throw table.error(
        missing,
        fmt::format("\"{}\" is missing, and follows from a logarithmic profile with a wind only", missing));
  }
  return options;
}

Eigen::Vector3d read_vector(const TomlTable& table, const std::string& key) {
  const std::vector<double> numbers = table.quantities(key, "m/s");
  if (numbers.size() != 3)
    throw table.error(key, fmt::format("has {} numbers, expected 3: along x, y and z", numbers.size()));
  return {numbers[0], numbers[1], numbers[2]};
}

Gust read_gust(const TomlTable& table) {
  table.expect_keys({"shape", "velocity", "start", "duration", "travel"});
  GustOptions options;
  const std::string shape = table.choice("shape", {"one_minus_cosine", "step", "extreme_operating"});
  if (shape == "step") options.shape = GustShape::step;
  if (shape == "extreme_operating") options.shape = GustShape::extreme_operating;
  options.velocity = read_vector(table, "velocity");
  options.start = table.optional_quantity("start", "s").value_or(0.0);
  options.duration = table.positive("duration", "s");
  if (table.has("travel")) {
    options.travel = read_vector(table, "travel");
    constexpr double kLeast = 1e-6;
    if (options.travel.norm() < kLeast)
      throw table.error("travel",
                        fmt::format("is {:.6g} m/s long, expected at least {:g}; without it the gust is "
                                    "everywhere at once",
                                    options.travel.norm(), kLeast));
  }
  return Gust(options);
}

SeriesKind read_series(const TomlTable& table, const ProfileOptions& mean) {
  table.expect_keys({"spectrum", "sigma"});
  SeriesKind kind;
  if (table.choice("spectrum", {"iec", "kaimal"}) == "kaimal") {
    kind.spectrum = models::wind::SeriesSpectrum::kaimal;
    if (table.has("sigma"))
      throw table.error("sigma", "follows from the mean wind with \"kaimal\", expected none");
    if (mean.kind != ProfileKind::logarithmic || !(mean.speed > 0.0))
      throw table.error("spectrum", "\"kaimal\" follows from a logarithmic profile with a wind only");
    return kind;
  }
  kind.sigma = table.positive("sigma", "m/s");
  return kind;
}

/// @param root of the file
WindFile wind_of(const TomlTable& root) {
  root.expect_keys({"mean", "turbulence", "gusts", "series"});
  const TomlTable mean = root.table("mean");
  const ProfileOptions profile = read_profile(mean);
  WindFile file{.wind = {.profile = WindProfile(profile)}};
  file.wind.towards = mean.optional_quantity("towards", "rad").value_or(0.0);
  if (const auto tables = root.optional_tables("gusts")) {
    for (const TomlTable& table : *tables) file.wind.gusts.push_back(read_gust(table));
  }
  if (const auto table = root.optional_table("turbulence")) {
    if (table->choice("kind", {"modes", "seen"}) == "seen")
      file.seen = read_seen(*table, file.wind);
    else
      file.wind.turbulence = read_turbulence(*table, profile);
  }
  if (const auto table = root.optional_table("series")) file.series = read_series(*table, profile);
  return file;
}

}  // namespace

WindFile read_wind(const std::filesystem::path& path) {
  return wind_of(TomlTable::read(path, "a wind"));
}

WindFile parse_wind(std::string_view text, const std::string& name) {
  return wind_of(TomlTable::parse(text, name, "a wind"));
}

}  // namespace samara::codebooks
