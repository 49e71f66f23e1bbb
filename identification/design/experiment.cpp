#include "samara/identification/design/experiment.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

constexpr const char* kAttitude = "attitude";
/// Releases stay so far inside their box, as a share of it: the fit does not know the start, and must not
/// meet a bound while it looks for it.
constexpr double kMargin = 0.02;

const models::FamilyCoordinate& coordinate_of(const models::FamilyInfo& family, const std::string& what,
                                              const std::string& name) {
  if (const auto at = models::position(family.coordinates, name)) return family.coordinates[*at];
  throw ArgumentError(fmt::format("the fit has {} \"{}\", and the {} of \"{}\" has no such coordinate{}",
                                  what, name, family.source, family.model,
                                  suggestion(name, models::names_of(family.coordinates))));
}

/// Every parameter of the family has the role that it had in the fit; what was held there is held.
void assign_roles(const models::FamilyInfo& family, const FitResult& fitted, FitOptions& options) {
  UnknownOptions& unknowns = options.unknowns;
  for (const std::string& name : unknowns.shared) coordinate_of(family, "the coefficient", name);
  for (const std::string& name : unknowns.per_capture) coordinate_of(family, "each capture's own", name);
  for (const auto& [name, label] : unknowns.known) coordinate_of(family, "the known", name);
  for (const models::FamilyCoordinate& c : family.coordinates) {
    const bool has_role = contains(unknowns.shared, c.name) || contains(unknowns.per_capture, c.name) ||
                          unknowns.known.contains(c.name) || unknowns.fixed.contains(c.name);
    if (has_role || c.name == family.clock) continue;
    if (const auto held = fitted.fixed.find(c.name); held != fitted.fixed.end()) {
      unknowns.fixed[c.name] = held->second;
    } else if (!c.is_initial) {
      throw ArgumentError(
          fmt::format("\"{}\" is free in the {} of \"{}\", and the fit says nothing of it; a family "
                      "of the fit's coordinates was expected",
                      c.name, family.source, family.model));
    }
  }
}

/// Outputs to compare, "attitude" as its four.
std::vector<std::string> compared_outputs(const models::FamilyInfo& family, const FitOptions& setup,
                                          const DesignOptions& options) {
  std::vector<std::string> outputs;
  const std::vector<std::string> known = models::output_names(family);
  const bool is_chosen = !options.outputs.empty();
  for (const std::string& name : is_chosen ? options.outputs : setup.compared.outputs) {
    if (name == kAttitude && !family.attitude.empty()) {
      outputs.insert(outputs.end(), family.attitude.begin(), family.attitude.end());
    } else if (contains(known, name)) {
      outputs.push_back(name);
    } else {
      throw ArgumentError(fmt::format("{}: \"{}\" is no output of the {} of \"{}\"{}",
                                      is_chosen ? "outputs" : "outputs of the fit", name, family.source,
                                      family.model, suggestion(name, known)));
    }
  }
  if (outputs.empty())
    throw ArgumentError("the fit does not say which outputs it compared; outputs were expected");
  return outputs;
}

/// Unknowns that a fit has: coefficients, and each capture's own.
double unknowns_of(const FitResult& fitted) {
  std::size_t count = fitted.coefficients.size();
  for (const CaptureFit& capture : fitted.captures) count += capture.nuisances.size();
  return static_cast<double>(count);
}

/// What the fit says of the noise of an output, of an attitude about each axis: its level, or what residuals leave,
/// less what unknowns took.
std::optional<double> found_noise(const FitResult& fitted, const std::string& output) {
  for (const NoiseLevel& level : fitted.noise) {
    if (contains(level.outputs, output)) return level.value;
  }
  const auto residual = std::ranges::find(fitted.residuals, output, &OutputRms::output);
  if (residual == fitted.residuals.end()) return {};
  const double values = fitted.residual_count, left = values - unknowns_of(fitted);
  // The residual of an attitude is the whole turn.
  const double rms = output == kAttitude ? residual->rms / std::sqrt(3.0) : residual->rms;
  return rms * (left > 0.0 ? std::sqrt(values / left) : 1.0);
}

double noise_of(const FitResult& fitted, const DesignOptions& options, const std::string& output) {
  const auto given = options.noise.find(output);
  const std::optional<double> found = found_noise(fitted, output);
  if (given == options.noise.end() && !found) {
    throw ArgumentError(fmt::format(
        "the fit did not compare \"{}\", and its noise is not given; noise was expected", output));
  }
  const double value = given != options.noise.end() ? given->second : *found;
  if (value > 0.0 && std::isfinite(value)) return value;
  throw ArgumentError(fmt::format("the noise of \"{}\"{} is {}; a positive number was expected", output,
                                  given != options.noise.end() ? "" : " in the fit", value));
}

/// What is seen, and the scales of its residuals.
void set_outputs(const models::FamilyInfo& family, const FitResult& fitted, const KnownSoFar& known,
                 const DesignOptions& options, Experiment& experiment) {
  FitOptions& next = experiment.options;
  next.compared.outputs = compared_outputs(family, fitted.setup, options);
  next.loss = {.kind = LossKind::none};
  bool has_attitude = false;
  const double raised = std::sqrt(known.inflation);
  for (const std::string& name : next.compared.outputs) {
    if (contains(family.attitude, name)) {
      has_attitude = true;
      continue;
    }
    const auto output = std::ranges::find(family.outputs, name, &models::FamilyOutput::name);
    const double noise = noise_of(fitted, options, name);
    experiment.outputs.push_back({name, output->unit, noise});
    next.loss.scales[name] = raised * noise;
  }
  if (has_attitude) {
    experiment.outputs.push_back({kAttitude, "rad", noise_of(fitted, options, kAttitude)});
    next.loss.attitude_scale = raised * experiment.outputs.back().noise;
  }
  for (const auto& [name, noise] : options.noise) {
    if (std::ranges::count(experiment.outputs, name, &SeenOutput::name) > 0) continue;
    throw ArgumentError(
        fmt::format("noise: \"{}\" is not seen{}", name, suggestion(name, next.compared.outputs)));
  }
  // What was unknown of outputs that are not seen does not matter any more.
  std::erase_if(*next.unknowns.offsets,
                [&](const std::string& name) { return !contains(next.compared.outputs, name); });
  if (next.camera.angles)
    std::erase_if(*next.camera.angles,
                  [&](const std::string& name) { return !contains(next.compared.outputs, name); });
  const bool sees_place = std::ranges::any_of(
      next.camera.axes, [&](const std::string& name) { return contains(next.compared.outputs, name); });
  if (!sees_place) next.camera = {};
}

/// Of the captures of the fit: the longest, and the median interval of its frames.
struct Film {
  double duration = 0.0, interval = 0.0;
};

Film film_of(const FitResult& fitted) {
  Film film;
  for (const CaptureFit& capture : fitted.captures) {
    const Eigen::Index frames = capture.times.size();
    if (frames < 2) continue;
    const double duration = capture.times[frames - 1] - capture.times[0];
    if (!(duration > film.duration)) continue;
    film.duration = duration;
    film.interval = median_interval(capture.times);
  }
  return film;
}

/// Duration and frames.
void set_times(const models::FamilyInfo& family, const FitResult& fitted, const DesignOptions& options,
               Experiment& experiment) {
  const Film film = film_of(fitted);
  // Means of frames begin before the first of them, and end after the last.
  const double around = (experiment.options.compared.averaged_frames - 1) * film.interval;
  experiment.duration = options.duration.value_or(std::min(film.duration, family.end_time - around));
  if (!(experiment.duration > 0.0)) {
    throw ArgumentError("the captures of the fit do not say how long they are; a duration was expected");
  }
  if (experiment.duration > family.end_time) {
    throw ArgumentError(fmt::format("duration is {:.6g} s; at most that of the {}, {:.6g} s, was expected",
                                    experiment.duration, family.source, family.end_time));
  }
  constexpr double kLongestFilm = 5000;
  if (!options.frames && !(film.interval > 0.0))
    throw ArgumentError(
        "the captures of the fit do not say how many frames a second has; frames were expected");
  const double frames =
      options.frames ? *options.frames : std::floor(experiment.duration / film.interval + 1.001);
  if (!(frames >= 2.0 && frames <= kLongestFilm)) {
    throw ArgumentError(fmt::format("a capture of {:.6g} s has {:.6g} frames; 2 to {:g} were expected",
                                    experiment.duration, frames, kLongestFilm));
  }
  experiment.frames = static_cast<int>(frames);
}

/// NaN where the capture does not say.
double value_in(const CaptureFit& capture, const std::string& coordinate) {
  const auto own = std::ranges::find(capture.nuisances, coordinate, &Nuisance::name);
  if (own != capture.nuisances.end()) return own->value;
  const auto known = capture.known.find(coordinate);
  return known != capture.known.end() ? known->second : std::nan("");
}

/// Where the captures of the fit were, in the mean; the middle of the box where they do not say.
double usual_value(const FitResult& fitted, const models::FamilyCoordinate& c) {
  double sum = 0.0;
  int count = 0;
  for (const CaptureFit& capture : fitted.captures) {
    const double value = value_in(capture, c.name);
    if (!std::isfinite(value)) continue;
    sum += value;
    ++count;
  }
  return count == 0 ? 0.5 * (c.lower + c.upper) : std::clamp(sum / count, c.lower, c.upper);
}

/// The mean attitude at the start, of which q and -q are one; zero where the captures do not say.
Eigen::Vector4d usual_attitude(const models::FamilyInfo& family, const FitResult& fitted) {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  if (family.attitude.empty()) return sum;
  for (const CaptureFit& capture : fitted.captures) {
    Eigen::Vector4d q;
    for (std::size_t k = 0; k < 4; ++k)
      q[static_cast<Eigen::Index>(k)] = value_in(capture, family.attitude[k] + "(0)");
    if (!q.allFinite()) continue;
    sum += q.dot(sum) < 0.0 ? Eigen::Vector4d(-q) : q;
  }
  return sum.normalized();
}

/// @param c with the box of the fit
/// @param usual where it is held, if it cannot be chosen
ReleaseCoordinate release_coordinate(double usual, const models::FamilyCoordinate& c,
                                     const DesignOptions& options, double margin) {
  ReleaseCoordinate result{.name = c.name, .unit = c.unit, .lower = c.lower, .upper = c.upper};
  const auto given = options.box.find(c.name);
  if (given != options.box.end()) {
    const models::Interval& box = given->second;
    if (!(box.lower <= box.upper && box.lower >= c.lower && box.upper <= c.upper)) {
      throw ArgumentError(fmt::format(
          "the box of the release \"{}\" goes from {} to {}; an interval within {} to {} was expected",
          c.name, box.lower, box.upper, c.lower, c.upper));
    }
    result.lower = box.lower;
    result.upper = box.upper;
  } else if (!options.release.empty() && !contains(options.release, c.name)) {
    result.lower = result.upper = usual;
  }
  if (result.lower == result.upper) return result;
  const double inset = margin * (c.upper - c.lower);
  const double lower = std::max(result.lower, c.lower + inset),
               upper = std::min(result.upper, c.upper - inset);
  if (lower < upper) {
    result.lower = lower;
    result.upper = upper;
  }
  return result;
}

void set_coordinates(const models::FamilyInfo& family, const FitResult& fitted, const DesignOptions& options,
                     Experiment& experiment) {
  const FitProblem problem = describe_problem(family, std::vector{experiment.capture}, experiment.options);
  const Eigen::Vector4d attitude = usual_attitude(family, fitted);
  const auto part_of = [&](const models::FamilyCoordinate& c) {
    return std::ranges::find_if(family.attitude,
                                [&](const std::string& name) { return c.name == name + "(0)"; });
  };
  const auto usual = [&](const models::FamilyCoordinate& c) {
    const auto part = part_of(c);
    if (part == family.attitude.end() || attitude.isZero()) return usual_value(fitted, c);
    return std::clamp(attitude[part - family.attitude.begin()], c.lower, c.upper);
  };
  for (const models::FamilyCoordinate& c : problem.own) {
    const double margin = part_of(c) == family.attitude.end() ? kMargin : 0.0;
    experiment.coordinates.push_back(release_coordinate(usual(c), c, options, margin));
  }
  experiment.own_count = problem.own.size();
  for (const std::string& name : problem.known) {
    const models::FamilyCoordinate& c = family.coordinates[*models::position(family.coordinates, name)];
    experiment.coordinates.push_back(release_coordinate(usual(c), c, options, 0.0));
  }
  std::vector<std::string> names;
  for (const ReleaseCoordinate& c : experiment.coordinates) names.push_back(c.name);
  std::vector<std::string> given = options.release;
  for (const auto& [name, box] : options.box) given.push_back(name);
  for (const std::string& name : given) {
    if (contains(names, name)) continue;
    throw ArgumentError(fmt::format("release: \"{}\" is not a coordinate that a capture has of its own{}",
                                    name, suggestion(name, names)));
  }
}

/// With zeros in all channels but for those whose start has a box.
Capture blank_capture(const models::FamilyInfo& family, const Experiment& experiment) {
  Capture capture{.id = "the next capture", .file = {}, .labels = {}, .times = {}, .channels = {}};
  capture.times = Eigen::VectorXd::LinSpaced(experiment.frames, 0.0, experiment.duration);
  for (const std::string& name : experiment.options.compared.outputs) {
    const auto output = std::ranges::find(family.outputs, name, &models::FamilyOutput::name);
    double value = contains(family.attitude, name) && name == family.attitude.front() ? 1.0 : 0.0;
    if (const auto start = experiment.options.unknowns.box.find(name + "(0)");
        start != experiment.options.unknowns.box.end() && !contains(family.attitude, name))
      value = 0.5 * (start->second.lower + start->second.upper);
    capture.channels.push_back({name, output->unit, Eigen::VectorXd::Constant(experiment.frames, value)});
  }
  for (const auto& [name, label] : experiment.options.unknowns.known) {
    const models::FamilyCoordinate& c = family.coordinates[*models::position(family.coordinates, name)];
    capture.labels[name] = fmt::format("{:.17g}", 0.5 * (c.lower + c.upper));
  }
  return capture;
}

}  // namespace

void check_fitted(const models::FamilyInfo& family, const FitResult& fitted) {
  if (fitted.model != family.model) {
    throw ArgumentError(fmt::format("the fit is of the model \"{}\"; one of \"{}\" was expected",
                                    fitted.model, family.model));
  }
  for (const auto* names : {&fitted.setup.unknowns.shared, &fitted.setup.unknowns.per_capture}) {
    for (const std::string& name : *names) {
      const bool is_of_measurement = name == kDelay || name.starts_with(gain_name(""));
      if (is_of_measurement && !models::position(family.coordinates, name))
        throw ArgumentError(
            fmt::format("the fit has \"{}\" among its unknowns, which designs do not know; a fit without "
                        "delay and gains was expected",
                        name));
    }
  }
  FitOptions setup = fitted.setup;
  setup.unknowns.shared = known_so_far(fitted).names;
  assign_roles(family, fitted, setup);
  compared_outputs(family, setup, {});
  for (const NoiseLevel& level : fitted.noise) {
    if (level.value > 0.0 && std::isfinite(level.value)) continue;
    throw ArgumentError(fmt::format("the noise of {} in the fit is {}; a positive number was expected",
                                    join(level.outputs), level.value));
  }
}

Experiment make_experiment(const models::TrajectoryFamily& family, const FitResult& fitted,
                           const KnownSoFar& known, const DesignOptions& options) {
  const models::FamilyInfo& info = family.info();
  check_fitted(info, fitted);
  if (!info.has_derivatives)
    throw ArgumentError(
        fmt::format("the {} of \"{}\" has no derivatives; a family with derivatives was expected",
                    info.source, info.model));
  Experiment experiment{.options = fitted.setup};
  FitOptions& next = experiment.options;
  next.unknowns.shared = known.names;
  if (!next.unknowns.offsets) next.unknowns.offsets = std::vector<std::string>{};
  assign_roles(info, fitted, next);
  for (const models::FamilyCoordinate& c : info.coordinates) {
    // A family may have grown or shrunk since the fit.
    models::Interval& box =
        next.unknowns.box.try_emplace(c.name, models::Interval{c.lower, c.upper}).first->second;
    box = {std::max(box.lower, c.lower), std::min(box.upper, c.upper)};
    if (!(box.lower < box.upper)) box = {c.lower, c.upper};
  }
  set_outputs(info, fitted, known, options, experiment);
  set_times(info, fitted, options, experiment);
  experiment.capture = blank_capture(info, experiment);
  set_coordinates(info, fitted, options, experiment);
  return experiment;
}

}  // namespace samara::identification
