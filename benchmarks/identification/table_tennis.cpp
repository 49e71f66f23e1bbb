#include "table_tennis.h"

#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "real_data.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fitted_motion.h"
#include "samara/identification/forecasts/baseline_scores.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/models/interface/model.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"

namespace samara::benchmarks::identification {

namespace {

using samara::identification::FitOptions;
using samara::identification::fitted_motion;
using samara::identification::LossKind;
using samara::models::TrajectoryFamily;

/// s: one step of RK4 per frame, which errs by less than a micrometre in 0.3 s.
constexpr double kStep = 7e-3;
/// rad/s: what the spin of a ball is in each direction, before anything is seen.
constexpr double kSpinPrior = 100.0;
/// m: noise of a frame on the grid, along the track.
constexpr double kNoise = 0.86e-3;

/// s: longer than every flight, so that each starts from where it is seen to start, in one piece.
constexpr double kUncut = 10.0;

const std::vector<std::string> kPosition = {"x", "y", "z"};

Box start_box() {
  Box box;
  for (const char* name : {"x(0)", "y(0)", "z(0)"}) box[name] = {-4.0, 4.0};
  for (const char* name : {"vx(0)", "vy(0)", "vz(0)"}) box[name] = {-30.0, 30.0};
  return box;
}

void add_spins(Box& box) {
  for (const char* name : {"wx(0)", "wy(0)", "wz(0)"}) box[name] = {-4000.0, 4000.0};
}

std::unique_ptr<models::TrajectoryFamily> family(const std::string& model,
                                                 const std::map<std::string, double>& fixed, const Box& box) {
  return step_trajectories(models::find_model(model), fixed, box, kStep);
}

/// Spins from labels.
std::map<std::string, samara::identification::KnownValue> labels() {
  return {{"wx(0)", "x_spin"}, {"wy(0)", "y_spin"}, {"wz(0)", "z_spin"}};
}

/// The forces alone, without the turn of the labels.
std::map<std::string, double> forces_of(const FitResult& fitted) {
  std::map<std::string, double> values = values_of(fitted);
  for (const char* name : {"spin_frame_x", "spin_frame_y", "spin_frame_z"}) values.erase(name);
  return values;
}

FitOptions options_with(LossKind kind, double scale) {
  FitOptions options;
  options.loss.kind = kind;
  options.loss.length_scale = scale;
  options.starts.count = 1;
  options.segments.length = kUncut;
  return options;
}

/// For coefficients: labels err, and robustly so.
FitOptions coefficient_options() {
  return options_with(LossKind::huber, 2e-3);
}

/// Of what a flight shows of its start: single frames err by more than the noise, and a short window feels
/// them.
FitOptions window_options() {
  return options_with(LossKind::huber, kNoise);
}

/// Where each flight is at a time after its first frame, from a fit of its own unknowns to what it shows.
std::vector<std::optional<Eigen::Vector3d>> carried_on(const models::TrajectoryFamily& family,
                                                       const FitOptions& options,
                                                       const std::vector<Capture>& seen,
                                                       const std::vector<double>& times) {
  const FitResult fitted = fit(family, seen, options);
  std::vector<std::optional<Eigen::Vector3d>> places;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const auto place = fitted_motion(family, options, fitted, k, {times[k]}, kPosition);
    places.push_back(place ? std::optional<Eigen::Vector3d>(place->row(0).transpose()) : std::nullopt);
  }
  return places;
}

/// The turn of the labels' axes.
Eigen::Matrix3d rotation_of(const FitResult& fitted) {
  const Eigen::Vector3d turn(value_of(fitted, "spin_frame_x"), value_of(fitted, "spin_frame_y"),
                             value_of(fitted, "spin_frame_z"));
  return turn.norm() > 0.0 ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix()
                           : Eigen::Matrix3d::Identity();
}

Eigen::Vector3d labelled_spin(const Capture& flight) {
  Eigen::Vector3d spin;
  for (Eigen::Index k = 0; k < 3; ++k)
    spin[k] = std::stod(flight.labels.at(std::string(1, "xyz"[k]) + "_spin"));
  return spin;
}

/// As a rotation vector. Half a turn about y after one about x is half a turn about an axis between y and z.
Eigen::Vector3d turn_of(const RotationStart& start) {
  if (!start.half_turned) return {start.about_x, 0.0, 0.0};
  return std::numbers::pi *
         Eigen::Vector3d(0.0, std::cos(0.5 * start.about_x), -std::sin(0.5 * start.about_x));
}

/// The part of a flight that predictors see, and the frame that they predict.
struct Question {
  Capture seen;
  double time = 0.0;
  Eigen::Vector3d place;
};

/// @param first frame with which the window begins
std::optional<Question> question_of(const Capture& flight, const Horizon& horizon, Eigen::Index first = 0) {
  const Eigen::VectorXd since = flight.times.array() - flight.times[first];
  const double half_frame = 0.5 * samara::identification::median_interval(flight.times);
  Eigen::Index frame = 0;
  (since.array() - horizon.end).abs().minCoeff(&frame);
  if (std::abs(since[frame] - horizon.end) > 1.01 * half_frame) return {};
  // Grid and impact without what came later.
  const Capture known = samara::identification::known_at(flight, horizon.window - since[0]);
  const Eigen::Index begin = (known.times.array() < flight.times[first] - half_frame).count();
  // A single frame may have another place on both grids, and so may the first.
  const Eigen::VectorXd apart = flight.times.head(known.frame_count()) - known.times;
  const double time = flight.times[frame] - median_of({apart.begin(), apart.end()});
  const double origin = known.times[begin];
  Question question{frames_of(known, begin, known.frame_count() - begin, origin), time - origin,
                    positions_of(flight).row(frame).transpose()};
  if (first > 0) question.seen.id += fmt::format(" from frame {}", first);
  return question;
}

}  // namespace

Flights read_flights(const std::filesystem::path& folder, const std::filesystem::path& sidecar,
                     int least_frames) {
  Flights flights;
  for (Capture& flight : samara::identification::read_captures(folder / "[0-9]*.csv", sidecar)) {
    if (flight.frame_count() < least_frames) continue;
    const std::string stem = std::filesystem::path(flight.file).stem().string();
    const int number = std::stoi(stem);
    flight.labels["number"] = stem;
    const bool belongs = number <= 50 || (number >= 106 && number <= 212);
    (belongs ? flights.labelled : flights.shifted)
        .push_back(frames_of(flight, 0, flight.frame_count(), flight.times[0]));
  }
  return flights;
}

FitResult fit_labelled(const std::vector<Capture>& flights, const RotationStart& start, SpinDrag spin_drag) {
  Box box = start_box();
  add_spins(box);
  box["C_D"] = {0.1, 1.5};
  // Each sign by itself: a descent would go from one to the other.
  box["C_M"] = start.C_M < 0.0 ? Box::mapped_type{-10.0, -1e-3} : Box::mapped_type{1e-3, 10.0};
  box["magnus_saturation"] = {0.0, 30.0};
  for (const char* name : {"spin_frame_x", "spin_frame_y", "spin_frame_z"}) box[name] = {-4.0, 4.0};
  FitOptions options = coefficient_options();
  options.unknowns.known = labels();
  const Eigen::Vector3d turn = turn_of(start);
  options.starts.initial = {{"C_D", 0.5},
                            {"C_M", start.C_M},
                            {"magnus_saturation", 1.0},
                            {"spin_frame_x", turn.x()},
                            {"spin_frame_y", turn.y()},
                            {"spin_frame_z", turn.z()}};
  if (spin_drag == SpinDrag::fitted) {
    box["spin_drag"] = {-1.0, 1.0};
    options.starts.initial["spin_drag"] = 0.0;
  }
  return fit(*family("sphere_flight_turned_spin", {}, box), flights, options);
}

FitResult fit_drag_only(const std::vector<Capture>& flights) {
  Box box = start_box();
  box["C_D"] = {0.1, 1.5};
  return fit(*family("sphere_flight", {{"C_M", 0.0}}, box), flights, coefficient_options());
}

LiftCoefficient lift_coefficient(const FitResult& fitted, double S) {
  const double slope = value_of(fitted, "C_M");
  const double lag = 1.0 + value_of(fitted, "magnus_saturation") * S;
  Eigen::VectorXd by = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(fitted.coefficients.size()));
  for (std::size_t k = 0; k < fitted.coefficients.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    if (fitted.coefficients[k].name == "C_M") by[at] = S / lag;
    if (fitted.coefficients[k].name == "magnus_saturation") by[at] = -slope * S * S / (lag * lag);
  }
  // What is at a bound or not determined is NaN in the covariance, and so is an answer that needs it.
  double variance = 0.0;
  for (Eigen::Index i = 0; i < by.size(); ++i) {
    for (Eigen::Index j = 0; j < by.size(); ++j) {
      if (by[i] != 0.0 && by[j] != 0.0) variance += by[i] * fitted.covariance(i, j) * by[j];
    }
  }
  return {slope * S / lag, std::sqrt(variance)};
}

double median_flight_rms(const FitResult& fitted) {
  std::vector<double> flights;
  for (const auto& flight : fitted.captures) {
    double sum = 0.0;
    for (const auto& output : flight.residuals) sum += output.rms * output.rms;
    flights.push_back(std::sqrt(sum));
  }
  return median_of(flights);
}

std::vector<SpinComparison> compare_spins(const std::vector<Capture>& flights, const FitResult& fitted) {
  Box box = start_box();
  add_spins(box);
  FitOptions options = window_options();
  for (const char* name : {"wx(0)", "wy(0)", "wz(0)"})
    options.priors.coordinates[name] = {.deviation = kSpinPrior};
  const FitResult own = fit(*family("sphere_flight", forces_of(fitted), box), flights, options);
  const Eigen::Matrix3d R = rotation_of(fitted);
  std::vector<SpinComparison> comparisons;
  for (std::size_t k = 0; k < flights.size(); ++k) {
    const Eigen::MatrixX3d path = positions_of(flights[k]);
    const Eigen::Vector3d way = (path.bottomRows(1) - path.topRows(1)).transpose().normalized();
    const auto across = [&way](const Eigen::Vector3d& w) { return Eigen::Vector3d(w - way * way.dot(w)); };
    Eigen::Vector3d spin;
    for (const auto& n : own.captures[k].nuisances) {
      if (n.name[0] == 'w') spin[n.name[1] - 'x'] = n.value;
    }
    comparisons.push_back(
        {flights[k].labels.at("number"), across(spin), across(R * labelled_spin(flights[k]))});
  }
  return comparisons;
}

namespace {

/// Spins as they are before anything is seen.
FitOptions own_spin_options() {
  FitOptions options = window_options();
  for (const char* name : {"wx(0)", "wy(0)", "wz(0)"})
    options.priors.coordinates[name] = {.deviation = kSpinPrior};
  return options;
}

Box box_with_spin() {
  Box box = start_box();
  add_spins(box);
  return box;
}

}  // namespace

std::vector<FlightMoment> flight_moments(const std::vector<Capture>& flights, const FitResult& fitted,
                                         const Horizon& horizon, Eigen::Index stride) {
  std::vector<FlightMoment> moments;
  std::vector<Capture> seen;
  std::vector<double> times;
  for (const Capture& flight : flights) {
    for (Eigen::Index first = 0; first < (stride > 0 ? flight.frame_count() : 1); first += stride) {
      const auto question = question_of(flight, horizon, first);
      if (!question) {  // there a frame is missing, or the flight has ended
        if (stride <= 0) break;
        continue;
      }
      seen.push_back(question->seen);
      times.push_back(question->time);
      moments.push_back({.number = flight.labels.at("number"),
                         .seen = question->seen,
                         .time = question->time,
                         .next = question->place.transpose()});
      if (stride <= 0) break;
    }
  }
  if (seen.empty()) return moments;
  const auto places = carried_on(*family("sphere_flight", forces_of(fitted), box_with_spin()),
                                 own_spin_options(), seen, times);
  for (std::size_t k = 0; k < moments.size(); ++k)
    moments[k].model =
        places[k] ? Eigen::RowVector3d(places[k]->transpose()) : Eigen::RowVector3d::Constant(INFINITY);
  return moments;
}

Distances predict_flights(const std::vector<Capture>& flights, const FitResult& fitted,
                          const FitResult& drag_only, const Horizon& horizon) {
  using namespace samara::identification;
  std::vector<Capture> seen;
  std::vector<double> times;
  std::vector<Eigen::Vector3d> truth;
  for (const Capture& flight : flights) {
    const auto question = question_of(flight, horizon);
    if (!question) continue;
    seen.push_back(question->seen);
    times.push_back(question->time);
    truth.push_back(question->place);
  }
  Distances distances;
  if (seen.empty()) return distances;
  const auto add = [&](const std::string& name, const models::TrajectoryFamily& family,
                       const FitOptions& options) {
    const auto places = carried_on(family, options, seen, times);
    for (std::size_t k = 0; k < seen.size(); ++k) {
      distances[name].push_back(places[k] ? (*places[k] - truth[k]).norm() : INFINITY);
    }
  };
  const Box with_spin = box_with_spin();
  add("model", *family("sphere_flight", forces_of(fitted), with_spin), own_spin_options());
  FitOptions known_spin = window_options();
  known_spin.unknowns.known = labels();
  add("labels", *family("sphere_flight_turned_spin", values_of(fitted), with_spin), known_spin);
  std::map<std::string, double> drag = values_of(drag_only);
  drag["C_M"] = 0.0;
  add("drag only", *family("sphere_flight", drag, start_box()), window_options());
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const Eigen::VectorXd at = Eigen::VectorXd::Constant(1, times[k]);
    const Eigen::MatrixXd place = predict(Baseline::quadratic, {seen[k].times, positions_of(seen[k])}, at);
    distances["parabola"].push_back((place.row(0).transpose() - truth[k]).norm());
  }
  return distances;
}

namespace {

FitResult fit_from_all(const std::vector<Capture>& flights, std::span<const RotationStart> starts,
                       SpinDrag spin_drag) {
  FitResult best;
  for (const RotationStart& start : starts) {
    FitResult result = fit_labelled(flights, start, spin_drag);
    if (best.captures.empty() || result.cost < best.cost) best = std::move(result);
  }
  return best;
}

}  // namespace

Distances predict_left_out_flights(const std::vector<Capture>& flights, std::span<const RotationStart> starts,
                                   int folds, const Horizon& horizon, SpinDrag spin_drag) {
  Distances all;
  for (int fold = 0; fold < folds; ++fold) {
    std::vector<Capture> training, test;
    for (std::size_t k = 0; k < flights.size(); ++k) {
      (static_cast<int>(k) % folds == fold ? test : training).push_back(flights[k]);
    }
    const Distances part =
        predict_flights(test, fit_from_all(training, starts, spin_drag), fit_drag_only(training), horizon);
    for (const auto& [name, values] : part) all[name].insert(all[name].end(), values.begin(), values.end());
  }
  return all;
}

}  // namespace samara::benchmarks::identification
