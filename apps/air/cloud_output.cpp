#include "air/cloud_output.h"

#include <array>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "samara/base/rounded.h"
#include "samara/base/version.h"
#include "samara/io/hdf5_writer.h"
#include "samara/motion/patterns/share.h"

namespace samara::apps {

namespace {

using models::Ensemble;
using models::LandingStatistics;
using models::RealisationStatus;

constexpr std::array<std::pair<RealisationStatus, const char*>, 4> kStatusNames = {
    {{RealisationStatus::flying, "flying"},
     {RealisationStatus::landed, "landed"},
     {RealisationStatus::left_flow, "left_flow"},
     {RealisationStatus::not_finite, "not_finite"}}};

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json estimated(const models::Estimated& value) {
  return {{"value", number(value.value)}, {"error", number(value.error)}};
}

Json list(const Eigen::Ref<const Eigen::VectorXd>& values) {
  Json all = Json::array();
  for (const double value : values) all.push_back(number(value));
  return all;
}

Json rows(const Eigen::MatrixXd& matrix) {
  Json all = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) all.push_back(list(matrix.row(i).transpose()));
  return all;
}

Json landing_json(const LandingStatistics& landing) {
  Json quantiles, intervals;
  for (Eigen::Index i = 0; i < 5; ++i) {
    const std::string share = fmt::format("{}", models::kLandingShares[i]);
    quantiles[share] = list(landing.quantiles.row(i).transpose());
    intervals[share] = {list(landing.quantiles_lower.row(i).transpose()),
                        list(landing.quantiles_upper.row(i).transpose())};
  }
  return {{"landed", landing.landed},
          {"t", estimated(landing.t)},
          {"mean", list(landing.mean)},
          {"mean_error", list(landing.mean_error)},
          {"covariance", rows(landing.covariance)},
          {"covariance_error", rows(landing.covariance_error)},
          {"quantiles", quantiles},
          {"quantile_intervals", intervals}};
}

/// Values of the model that were flown, by name: parameters with their defaults, and initial values "s(0)".
struct NamedValues {
  std::vector<std::string> names, units;
  std::vector<double> values;

  explicit NamedValues(const models::ParametricModel& model) {
    const models::ModelInfo& info = model.model().info();
    for (const models::ParameterInfo& parameter : info.parameters) {
      names.push_back(parameter.name);
      units.push_back(parameter.unit);
    }
    values = model.parameters({});
    std::vector<double> initial(info.states.size());
    model.initial({}, initial);
    for (const models::StateInfo& state : info.states) {
      names.push_back(state.name + "(0)");
      units.push_back(state.unit);
    }
    values.insert(values.end(), initial.begin(), initial.end());
  }
};

std::string structure_constant_of(const CloudFile& file) {
  return file.C_0.empty() ? "by the Reynolds number of the turbulence" : file.C_0;
}

/// size[0] x size[1] x size[2] from matrices of one size.
void write_matrices(io::Hdf5Writer& file, const std::string& path,
                    const std::vector<Eigen::MatrixXd>& matrices) {
  if (matrices.empty()) return;
  std::vector<double> values;
  for (const Eigen::MatrixXd& matrix : matrices) {
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> by_rows = matrix;
    values.insert(values.end(), by_rows.data(), by_rows.data() + by_rows.size());
  }
  file.write_block(path, {std::ssize(matrices), matrices[0].rows(), matrices[0].cols()}, values);
}

}  // namespace

CloudTable cloud_table(const Ensemble& cloud) {
  CloudTable table = {{"t[s]", "flying[1]"}, {}};
  const auto states = static_cast<Eigen::Index>(cloud.states.size());
  for (std::size_t s = 0; s < cloud.states.size(); ++s) {
    for (const char* what : {"mean", "error", "deviation"})
      table.header.push_back(fmt::format("{}.{}[{}]", cloud.states[s], what, cloud.units[s]));
  }
  table.rows.resize(cloud.times.size(), 2 + 3 * states);
  for (Eigen::Index k = 0; k < cloud.times.size(); ++k) {
    table.rows(k, 0) = cloud.times[k];
    table.rows(k, 1) = static_cast<double>(cloud.flying[k]);
    for (Eigen::Index s = 0; s < states; ++s) {
      table.rows(k, 2 + 3 * s) = cloud.mean(k, s);
      table.rows(k, 3 + 3 * s) = cloud.mean_error(k, s);
      table.rows(k, 4 + 3 * s) = cloud.standard_deviation(k, s);
    }
  }
  return table;
}

Json cloud_json(const CloudFile& file) {
  const Ensemble& cloud = file.cloud;
  Json status, shares;
  for (const auto& [which, name] : kStatusNames) {
    status[name] = cloud.count(which);
    const motion::Share share = motion::counted_share(cloud.count(which), cloud.realisations());
    shares[name] = {{"share", share.value}, {"interval", {share.lower, share.upper}}};
  }
  Json times = Json::array();
  for (Eigen::Index k = 0; k < cloud.times.size(); ++k) {
    const auto at = static_cast<std::size_t>(k);
    times.push_back({{"t", cloud.times[k]},
                     {"flying", cloud.flying[k]},
                     {"mean", list(cloud.mean.row(k).transpose())},
                     {"mean_error", list(cloud.mean_error.row(k).transpose())},
                     {"covariance", rows(cloud.covariance[at])},
                     {"covariance_error", rows(cloud.covariance_error[at])}});
  }
  const NamedValues named(file.model);
  Json values;
  for (std::size_t j = 0; j < named.names.size(); ++j) values[named.names[j]] = number(named.values[j]);
  Json object = {{"schema", "samara-cloud/1"},
                 {"model", file.model.model().info().name},
                 {"air", file.air},
                 {"seed", file.seed},
                 {"first", cloud.first},
                 {"realisations", cloud.realisations()},
                 {"antithetic", cloud.antithetic},
                 {"step", file.step},
                 {"ground", file.ground ? Json(*file.ground) : Json(nullptr)},
                 {"body_radius", file.body_radius},
                 {"C_0", structure_constant_of(file)},
                 {"rotation", file.rotation},
                 {"generator", fmt::format("samara {}", version())},
                 {"cancelled", cloud.cancelled},
                 {"values", values},
                 {"status", status},
                 {"shares", shares},
                 {"relative_error", number(cloud.relative_error)},
                 {"steps_beyond_a_tenth", cloud.steps.beyond_tenth},
                 {"steps_beyond_a_third", cloud.steps.beyond_third},
                 {"states", cloud.states},
                 {"units", cloud.units},
                 {"times", times}};
  if (!cloud.half_turns.empty()) object["half_turns"] = estimated(cloud.mean_half_turns);
  if (!cloud.landings.empty()) object["landing"] = landing_json(models::landing_statistics(cloud));
  return object;
}

void write_cloud(const std::string& path, const CloudFile& file) {
  const Ensemble& cloud = file.cloud;
  const models::ModelInfo& info = file.model.model().info();
  io::Hdf5Writer out(path);
  out.write_text_attribute("/", "format", kCloudFormat);
  out.write_text_attribute("/", "format_version", "0.1");
  out.write_text_attribute("/", "model", info.name);
  out.write_text_attribute("/", "air", file.air);
  out.write_text_attribute("/", "seed", fmt::format("{}", file.seed));
  out.write_integer_attribute("/", "first", cloud.first);
  out.write_integer_attribute("/", "realisations", cloud.realisations());
  out.write_integer_attribute("/", "antithetic", cloud.antithetic ? 1 : 0);
  out.write_number_attribute("/", "step", file.step);
  if (file.ground) out.write_number_attribute("/", "ground", *file.ground);
  out.write_number_attribute("/", "body_radius", file.body_radius);
  out.write_text_attribute("/", "C_0", structure_constant_of(file));
  out.write_integer_attribute("/", "rotation", file.rotation ? 1 : 0);
  out.write_text_attribute("/", "generator", fmt::format("samara {}", version()));
  out.write_integer_attribute("/", "cancelled", cloud.cancelled ? 1 : 0);
  out.write_number_attribute("/", "steps_beyond_a_tenth", cloud.steps.beyond_tenth);
  out.write_number_attribute("/", "steps_beyond_a_third", cloud.steps.beyond_third);
  const NamedValues named(file.model);
  out.write_texts("/value_names", named.names);
  out.write_texts("/value_units", named.units);
  out.write_vector("/values",
                   Eigen::Map<const Eigen::VectorXd>(named.values.data(), std::ssize(named.values)));
  out.write_vector("/t", cloud.times);
  out.make_scale("/t", "t");
  out.write_texts("/states", cloud.states);
  out.write_texts("/units", cloud.units);
  out.write_vector("/flying", cloud.flying.cast<double>());
  out.write_matrix("/mean", cloud.mean);
  out.write_matrix("/mean_error", cloud.mean_error);
  write_matrices(out, "/covariance", cloud.covariance);
  write_matrices(out, "/covariance_error", cloud.covariance_error);
  for (const char* name : {"/flying", "/mean", "/mean_error", "/covariance", "/covariance_error"})
    out.attach_scale(name, 0, "/t");
  std::vector<std::string> status;
  for (const RealisationStatus which : cloud.status)
    status.emplace_back(kStatusNames[static_cast<std::size_t>(which)].second);
  out.write_texts("/status", status);
  if (!cloud.half_turns.empty())
    out.write_vector("/half_turns",
                     Eigen::Map<const Eigen::VectorXi>(cloud.half_turns.data(), std::ssize(cloud.half_turns))
                         .cast<double>());
  if (!cloud.landings.empty()) {
    Eigen::MatrixXd landings(std::ssize(cloud.landings), 5);
    for (Eigen::Index n = 0; n < landings.rows(); ++n) {
      const models::Landing& landing = cloud.landings[static_cast<std::size_t>(n)];
      landings.row(n) << static_cast<double>(landing.realisation), landing.t, landing.position.transpose();
    }
    out.write_matrix("/landings", landings);
    out.write_texts("/landing_columns", {"realisation", "t", "x", "y", "z"});
  }
  if (!cloud.kept.empty()) {
    write_matrices(out, "/kept", cloud.kept);
    out.attach_scale("/kept", 1, "/t");
    std::vector<std::string> states;
    for (const models::StateInfo& state : info.states) states.push_back(state.name);
    out.write_texts("/kept_states", states);
  }
  out.commit();
}

std::string cloud_summary(const CloudFile& file, const models::GustLayout& layout) {
  const Ensemble& cloud = file.cloud;
  std::string text =
      fmt::format("{} realisations in {}, seed {}:", cloud.realisations(), file.air, file.seed);
  const char* separator = " ";
  for (const auto& [which, name] : kStatusNames) {
    if (const long count = cloud.count(which); count > 0) {
      fmt::format_to(std::back_inserter(text), "{}{} {}", separator, count, name);
      separator = ", ";
    }
  }
  const auto three = [](double value) { return fmt::format("{:.3g}", value); };
  // Of one realisation there is no error.
  const auto with_error = [&](double value, double error) {
    return std::isfinite(error) ? fmt::format("{} +- {}", three(value), three(error)) : three(value);
  };
  if (!cloud.landings.empty()) {
    const LandingStatistics landing = models::landing_statistics(cloud);
    fmt::format_to(std::back_inserter(text), "; landing at t = {} s",
                   with_error(landing.t.value, landing.t.error));
    const bool in_plane = layout.space() == models::GustLayout::Space::plane;
    for (Eigen::Index axis = 0; axis < (in_plane ? 1 : 2); ++axis) {
      fmt::format_to(std::back_inserter(text), ", {} = {} m", axis == 0 ? "x" : "y",
                     with_error(landing.mean[axis], landing.mean_error[axis]));
      if (landing.landed > 1)
        fmt::format_to(std::back_inserter(text), " (deviation {} m)",
                       three(std::sqrt(landing.covariance(axis, axis))));
    }
  }
  if (!cloud.half_turns.empty()) {
    fmt::format_to(std::back_inserter(text), "; half turns {}",
                   with_error(cloud.mean_half_turns.value, cloud.mean_half_turns.error));
  }
  if (cloud.cancelled) text += "; interrupted";
  return text;
}

}  // namespace samara::apps
