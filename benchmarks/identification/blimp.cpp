#include "blimp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <fmt/format.h>

#include "real_data.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fitted_motion.h"
#include "samara/identification/forecasts/baseline_scores.h"
#include "samara/models/interface/model.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"

namespace samara::benchmarks::identification {

namespace {

using samara::identification::Baseline;
using samara::identification::FitOptions;
using samara::identification::LossKind;
using samara::models::TrajectoryFamily;

constexpr Eigen::Index kRate = 60;  // Hz
/// s: one step of RK4 per frame; nothing here changes within a tenth of a second.
constexpr double kStep = 1.01 / static_cast<double>(kRate);
constexpr Eigen::Index kWindow = kRate;        ///< frame intervals of a window to fit
constexpr Eigen::Index kSeen = 6;              ///< frame intervals that predictors see
constexpr Eigen::Index kBetweenMoments = 30;   ///< frames from one prediction to the next
constexpr Eigen::Index kBetweenForecasts = 6;  ///< the same of forecasts that are distributions
constexpr double kUncut = 1e3;                 ///< s: longer than every window

/// Captured quantities that a flight keeps: the gondola by the model's names.
const std::map<std::string, std::string> kKnown = {{"gondola_x", "offset_x"},
                                                   {"gondola_y", "offset_y"},
                                                   {"gondola_z", "offset_z"},
                                                   {"thrust_left", "thrust_left"},
                                                   {"thrust_right", "thrust_right"}};

/// The makers' measurements.
const std::map<std::string, double>& body() {
  static const std::map<std::string, double> values = {{"mass", 0.10482},
                                                       {"I_x", 0.03},
                                                       {"I_y", 0.015},
                                                       {"I_z", 0.01},
                                                       {"r_cx", -0.0432},
                                                       {"r_cy", -0.0003},
                                                       {"r_cz", 0.0079},
                                                       {"offset_mass", 0.05407},
                                                       {"g", 9.8},
                                                       {"area", 0.25},
                                                       {"displaced_mass", 0.15204},
                                                       {"fluid_density", 1.2187},
                                                       {"thrust_arm", 0.15}};
  return values;
}

constexpr std::array kStates = {"x", "y", "z", "qw", "qx", "qy", "qz", "ux", "uy", "uz", "wx", "wy", "wz"};

Box start_box() {
  Box box;
  for (const char* name : {"x(0)", "y(0)", "z(0)"}) box[name] = {-50.0, 50.0};
  for (const char* name : {"qw(0)", "qx(0)", "qy(0)", "qz(0)"}) box[name] = {-1.1, 1.1};
  for (const char* name : {"ux(0)", "uy(0)", "uz(0)"}) box[name] = {-5.0, 5.0};
  for (const char* name : {"wx(0)", "wy(0)", "wz(0)"}) box[name] = {-10.0, 10.0};
  for (const auto& [quantity, name] : kKnown) box[name] = {-1.0, 1.0};
  return box;
}

/// Scales are what the model lacks in a second, not the noise.
FitOptions base_options() {
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.loss.length_scale = 0.01;
  options.loss.attitude_scale = 0.01;
  for (const auto& [quantity, name] : kKnown) options.unknowns.known[name] = name;
  options.starts.count = 1;
  return options;
}

/// Of coefficients: a window starts from the state measured at its first frame (labels named like the
/// coordinates), as predictions do. With starts of their own, windows hide errors of the moments in their
/// starts: damping came out with the wrong sign.
FitOptions coefficient_options() {
  FitOptions options = base_options();
  for (const char* state : kStates)
    options.unknowns.known[fmt::format("{}(0)", state)] = fmt::format("{}(0)", state);
  options.compared.outputs = {"x", "y", "z", "qw", "qx", "qy", "qz"};
  options.uncertainty.cluster_by = {"flight"};
  return options;
}

/// Of the state at the end of a short time that was seen: rates as measured say most of it.
FitOptions start_options() {
  FitOptions options = base_options();
  for (const char* name : {"ux", "uy", "uz"}) options.loss.scales[name] = 0.02;
  for (const char* name : {"wx", "wy", "wz"}) options.loss.scales[name] = 0.03;
  options.segments.length = kUncut;
  return options;
}

std::unique_ptr<models::TrajectoryFamily> family(std::map<std::string, double> fixed, const Box& box) {
  fixed.insert(body().begin(), body().end());
  return step_trajectories(models::find_model("coefficient_body"), fixed, box, kStep);
}

Capture window_of(const Capture& capture, Eigen::Index first, Eigen::Index intervals) {
  Capture window = frames_of(capture, first, intervals + 1, capture.times[first]);
  window.id += fmt::format(" from frame {}", first);
  return window;
}

std::vector<Capture> windows_of(const std::vector<BlimpFlight>& flights) {
  std::vector<Capture> windows;
  for (const BlimpFlight& flight : flights) {
    const Eigen::Index frames = flight.capture.frame_count();
    for (Eigen::Index first = 0; first + kWindow < frames; first += kWindow) {
      Capture window = window_of(flight.capture, first, kWindow);
      for (const char* state : kStates)
        window.labels[fmt::format("{}(0)", state)] = fmt::format("{}", window.channel(state).values[0]);
      windows.push_back(std::move(window));
    }
  }
  return windows;
}

/// Of a body whose x axis points ahead, in a world with z up.
double pitch_of(const Eigen::Vector4d& attitude) {
  const Eigen::Vector4d q = attitude.normalized();
  return std::asin(2.0 * (q[1] * q[3] - q[0] * q[2]));
}

Eigen::VectorXd pitches_of(const Capture& capture) {
  Eigen::VectorXd pitches(capture.frame_count());
  for (Eigen::Index k = 0; k < pitches.size(); ++k) {
    Eigen::Vector4d q;
    for (Eigen::Index part = 0; part < 4; ++part)
      q[part] = capture.channel(std::string("q") + "wxyz"[part]).values[k];
    pitches[k] = pitch_of(q);
  }
  return pitches;
}

/// Velocity and attitude as measured say how fast the body moves in the world: a straight line through that
/// over the frames seen, carried on from the place that all frames agree on best.
Eigen::Vector3d carried_on_by_velocity(const Capture& seen, double time) {
  const Eigen::Index frames = seen.frame_count();
  const Eigen::MatrixX3d places = positions_of(seen);
  const double end = seen.times[frames - 1];
  Eigen::MatrixXd line(frames, 2), velocities(frames, 3);
  const auto at = [&](const char* name, Eigen::Index k) { return seen.channel(name).values[k]; };
  for (Eigen::Index k = 0; k < frames; ++k) {
    const Eigen::Quaterniond q(at("qw", k), at("qx", k), at("qy", k), at("qz", k));
    velocities.row(k) = (q.normalized() * Eigen::Vector3d(at("ux", k), at("uy", k), at("uz", k))).transpose();
    line.row(k) << 1.0, seen.times[k] - end;
  }
  const Eigen::MatrixXd fitted = line.householderQr().solve(velocities);
  const auto moved_by = [&](double since_end) -> Eigen::RowVector3d {
    return fitted.row(0) * since_end + fitted.row(1) * (0.5 * since_end * since_end);
  };
  Eigen::RowVector3d last = Eigen::RowVector3d::Zero();
  for (Eigen::Index k = 0; k < frames; ++k) last += places.row(k) - moved_by(seen.times[k] - end);
  return (last / static_cast<double>(frames) + moved_by(time - end)).transpose();
}

void add_error(const Eigen::Vector3d& place, double pitch, const Capture& truth, BlimpErrors& errors) {
  errors.position.push_back((place - positions_of(truth).row(0).transpose()).norm());
  errors.pitch.push_back(std::abs(pitch - pitches_of(truth)[0]));
}

}  // namespace

std::vector<BlimpFlight> read_blimp(const std::filesystem::path& folder,
                                    const std::filesystem::path& sidecar) {
  std::vector<BlimpFlight> flights;
  for (Capture& capture : samara::identification::read_captures(folder / "data_*.csv", sidecar)) {
    const std::string stem = std::filesystem::path(capture.file).stem().string();
    const int number = std::stoi(stem.substr(stem.find('_') + 1));
    capture.labels["flight"] = std::to_string(number);
    for (const auto& [quantity, name] : kKnown)
      capture.labels[name] = fmt::format("{}", capture.channel(quantity).values[0]);
    constexpr int kFirstStraight = 121;
    flights.push_back({number, number < kFirstStraight, std::move(capture)});
  }
  std::ranges::sort(flights, {}, &BlimpFlight::number);
  return flights;
}

BlimpSplit split_blimp(const std::vector<BlimpFlight>& flights, const std::vector<int>& left_out) {
  BlimpSplit split;
  for (const BlimpFlight& flight : flights) {
    const bool out = std::ranges::count(left_out, flight.number) > 0;
    (out ? split.left_out : split.training).push_back(flight);
  }
  return split;
}

const Coefficients& makers_coefficients() {
  static const Coefficients values = {
      {"Cd0", 0.2425},   {"Cda", 4.4195},   {"Cdb", 7.5080},   {"Cs0", 0.0083},  {"Csa", -0.0744},
      {"Csb", -2.1140},  {"Cl0", 0.1594},   {"Cla", 2.9375},   {"Clb", 4.5537},  {"Cmx0", 0.0131},
      {"Cmxa", -0.0301}, {"Cmxb", -0.5256}, {"Cmy0", 0.0568},  {"Cmya", 0.0933}, {"Cmyb", 5.2357},
      {"Cmz0", 0.0006},  {"Cmza", -0.0012}, {"Cmzb", -0.0936}, {"K1", -0.0503},  {"K2", -0.0264},
      {"K3", -0.0137}};
  return values;
}

const std::vector<std::string>& blimp_coefficients() {
  static const std::vector<std::string> names = {"Cd0",  "Cda",  "Cdb",  "Cs0",  "Csa",  "Csb",  "Cl0",
                                                 "Cla",  "Clb",  "Cmx0", "Cmxa", "Cmxb", "Cmy0", "Cmya",
                                                 "Cmyb", "Cmz0", "Cmza", "Cmzb", "K1",   "K2",   "K3"};
  return names;
}

FitResult fit_blimp(const std::vector<BlimpFlight>& flights, AddedMass added_mass,
                    const Coefficients& initial) {
  Box box = start_box();
  // Wide: terms of the sideslip hardly show, least its fourth power.
  for (const std::string& name : blimp_coefficients()) box[name] = {-1e3, 1e3};
  box["Cmyb"] = {-1e6, 1e6};
  if (added_mass == AddedMass::diagonal) {
    for (const char* name : {"M_x", "M_y", "M_z"}) box[name] = {0.0, 0.5};
    for (const char* name : {"J_x", "J_y", "J_z"}) box[name] = {0.0, 0.1};
  }
  FitOptions options = coefficient_options();
  options.starts.initial = initial;
  return fit(*family({}, box), windows_of(flights), options);
}

Coefficients jackknife_errors(const std::vector<BlimpFlight>& flights) {
  Coefficients sum, squares, errors;
  for (const BlimpFlight& left_out : flights) {
    const FitResult fitted = fit_blimp(split_blimp(flights, {left_out.number}).training);
    for (const auto& c : fitted.coefficients) {
      sum[c.name] += c.value;
      squares[c.name] += c.value * c.value;
    }
  }
  const auto n = static_cast<double>(flights.size());
  for (const auto& [name, total] : sum) {
    const double scatter = squares[name] - total * total / n;
    errors[name] = std::sqrt((n - 1.0) / n * std::max(0.0, scatter));
  }
  return errors;
}

namespace {

/// What was seen, and the frame to predict, in the same times.
struct Questions {
  std::vector<Capture> seen, truth;
};

Questions questions_of(const std::vector<BlimpFlight>& flights, double ahead) {
  const auto frames_ahead = static_cast<Eigen::Index>(std::lround(ahead * static_cast<double>(kRate)));
  Questions questions;
  auto& [seen, truth] = questions;
  for (const BlimpFlight& flight : flights) {
    const Eigen::Index frames = flight.capture.frame_count();
    for (Eigen::Index now = kSeen; now + frames_ahead < frames; now += kBetweenMoments) {
      seen.push_back(window_of(flight.capture, now - kSeen, kSeen));
      truth.push_back(frames_of(flight.capture, now + frames_ahead, 1, flight.capture.times[now - kSeen]));
    }
  }
  return questions;
}

}  // namespace

std::map<std::string, double> blimp_body(const BlimpFlight& flight) {
  std::map<std::string, double> values = body();
  for (const auto& [quantity, name] : kKnown) values[name] = std::stod(flight.capture.labels.at(name));
  return values;
}

std::vector<BlimpMoment> blimp_moments(const std::vector<BlimpFlight>& flights, double ahead) {
  const auto frames_ahead = static_cast<Eigen::Index>(std::lround(ahead * static_cast<double>(kRate)));
  std::vector<BlimpMoment> moments;
  for (std::size_t k = 0; k < flights.size(); ++k) {
    const Capture& capture = flights[k].capture;
    const std::map<std::string, double> known = blimp_body(flights[k]);
    const double net_mass = known.at("mass") + known.at("offset_mass") - known.at("displaced_mass");
    for (Eigen::Index now = kSeen; now + frames_ahead < capture.frame_count(); now += kBetweenForecasts) {
      const Capture seen = window_of(capture, now - kSeen, kSeen);
      BlimpMoment moment{.flight = k, .origin = now};
      moment.seen = {.times = seen.times,
                     .positions = positions_of(seen),
                     .rates = Eigen::MatrixX3d(seen.frame_count(), 3),
                     .up = 2,
                     .net_weight = known.at("g") * net_mass / (known.at("mass") + known.at("offset_mass"))};
      for (Eigen::Index frame = 0; frame < seen.frame_count(); ++frame) {
        const auto at = [&](const char* name) { return seen.channel(name).values[frame]; };
        const Eigen::Quaterniond q(at("qw"), at("qx"), at("qy"), at("qz"));
        moment.seen.rates.row(frame) =
            (q.normalized() * Eigen::Vector3d(at("ux"), at("uy"), at("uz"))).transpose();
      }
      const Capture truth = frames_of(capture, now + frames_ahead, 1, capture.times[now - kSeen]);
      moment.time = truth.times[0];
      moment.next = positions_of(truth).row(0);
      moments.push_back(std::move(moment));
    }
  }
  return moments;
}

std::map<std::string, BlimpErrors> predict_blimp(const std::vector<BlimpFlight>& flights,
                                                 const Coefficients& coefficients, double ahead) {
  const auto [seen, truth] = questions_of(flights, ahead);
  std::map<std::string, BlimpErrors> errors;
  const auto blimp = family(coefficients, start_box());
  const FitOptions options = start_options();
  const FitResult starts = fit(*blimp, seen, options);
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const double time = truth[k].times[0];
    const auto model = samara::identification::fitted_motion(*blimp, options, starts, k, {time},
                                                             {"x", "y", "z", "qw", "qx", "qy", "qz"});
    if (model) {
      add_error(model->row(0).head<3>().transpose(), pitch_of(model->row(0).tail<4>().transpose()), truth[k],
                errors["model"]);
    } else {
      errors["model"].position.push_back(INFINITY);
      errors["model"].pitch.push_back(INFINITY);
    }
    const Eigen::MatrixXd places = positions_of(seen[k]);
    const Eigen::VectorXd at = Eigen::VectorXd::Constant(1, time);
    const Eigen::MatrixXd turned = predict(Baseline::straight_line, {seen[k].times, pitches_of(seen[k])}, at);
    add_error(carried_on_by_velocity(seen[k], time), turned(0, 0), truth[k], errors["measured velocity"]);
    for (const Baseline baseline : samara::identification::all_baselines()) {
      if (baseline == Baseline::measured_velocity) continue;  // of the body in its own axes: above
      if (baseline == Baseline::point_with_drag) continue;    // what floats does not fall
      const Eigen::MatrixXd place = predict(baseline, {seen[k].times, places}, at);
      const Eigen::MatrixXd pitch = predict(baseline, {seen[k].times, pitches_of(seen[k])}, at);
      add_error(place.row(0).transpose(), pitch(0, 0), truth[k], errors[to_string(baseline)]);
    }
  }
  return errors;
}

}  // namespace samara::benchmarks::identification
