#include "samara/identification/design/film_worth.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <ranges>

#include "samara/base/parallel.h"

namespace samara::identification {

namespace {

/// So many frames of a film are looked at, equally spaced, in what takes one evaluation or more each.
constexpr int kMostFrames = 200;

/// What each frame of one capture adds, for one draw.
struct FrameNormals {
  Eigen::MatrixXd beforehand;
  std::vector<Eigen::MatrixXd> frames;
  int coefficients = 0;

  FrameNormals(const CaptureRows& rows, int frame_count)
      : beforehand(rows.normal([](int, int) { return false; })),
        frames(static_cast<std::size_t>(frame_count),
               Eigen::MatrixXd::Zero(rows.unknowns(), rows.unknowns())),
        coefficients(rows.coefficients) {
    for (int row = 0; row < rows.seen(); ++row) {
      const auto derivative = rows.by_unknowns.row(row);
      frames[static_cast<std::size_t>(rows.frames[static_cast<std::size_t>(row)])] +=
          derivative.transpose() * derivative;
    }
  }
};

/// All captures by frames: sums of frames, and what they leave open.
class FilmFrames {
 public:
  using Sums = std::vector<Eigen::MatrixXd>;  ///< normal matrices, in the order of the parts

  FilmFrames(const RowsOfCaptures& captures, int frame_count, const Precision& precision)
      : precision_(precision) {
    for (const std::vector<CaptureRows>& capture : captures) {
      for (std::size_t draw = 0; draw < capture.size(); ++draw) {
        if (capture[draw].unknowns() == 0) continue;
        parts_.emplace_back(capture[draw], frame_count);
        draws_.push_back(draw);
      }
    }
  }

  Sums none() const {
    Sums sums;
    for (const FrameNormals& part : parts_) sums.push_back(part.beforehand);
    return sums;
  }
  void add_frame(int frame, double sign, Sums& sums) const {
    for (std::size_t k = 0; k < parts_.size(); ++k)
      sums[k] += sign * parts_[k].frames[static_cast<std::size_t>(frame)];
  }
  Informations left(const Sums& sums) const {
    Informations result = precision_.so_far();
    for (std::size_t k = 0; k < parts_.size(); ++k)
      result[draws_[k]] += eliminated(sums[k], parts_[k].coefficients);
    return result;
  }

 private:
  const Precision& precision_;
  std::vector<FrameNormals> parts_;
  std::vector<std::size_t> draws_;  ///< of each part
};

double time_of(const Experiment& experiment, int frame) {
  return experiment.capture.times[frame];
}

void add_outputs(const RowsOfCaptures& captures, const Experiment& experiment, const Precision& precision,
                 Design& design) {
  for (std::size_t o = 0; o < experiment.outputs.size(); ++o) {
    const auto index = static_cast<int>(o);
    const auto is_it = [&](int /*frame*/, int output) { return output == index; };
    const auto is_other = [&](int /*frame*/, int output) { return output != index; };
    const SeenOutput& output = experiment.outputs[o];
    design.outputs.push_back({.output = output.name,
                              .unit = output.unit,
                              .noise = output.noise,
                              .alone = precision.error(with_captures(precision, captures, is_it)),
                              .without = precision.error(with_captures(precision, captures, is_other))});
  }
  std::ranges::stable_sort(design.outputs, std::greater<>(), &OutputWorth::without);
}

/// Frame by frame, or every so many of a long film; the last one always.
void add_lengths(const FilmFrames& film, const Experiment& experiment, const Precision& precision,
                 Design& design) {
  const int every = (experiment.frames + kMostFrames - 1) / kMostFrames;
  FilmFrames::Sums sums = film.none();
  for (int frame = 0; frame < experiment.frames; ++frame) {
    film.add_frame(frame, 1.0, sums);
    if ((experiment.frames - 1 - frame) % every == 0)
      design.lengths.push_back({time_of(experiment, frame), precision.error(film.left(sums)), 0.0});
  }
  // Precision is one over the variance.
  const double added = std::pow(design.lengths.back().error, -2.0) - 1.0;
  constexpr double kSufficient = 0.9;
  design.sufficient_duration = experiment.duration;
  for (FilmLength& length : std::views::reverse(design.lengths)) {
    length.share = added > 0.0 ? (std::pow(length.error, -2.0) - 1.0) / added : 0.0;
    if (length.share >= kSufficient) design.sufficient_duration = length.duration;
  }
}

void add_frame_counts(const FilmFrames& film, const Experiment& experiment, const Precision& precision,
                      Design& design) {
  constexpr int kFewest = 3;
  for (const int every : {2, 4, 8}) {
    const int count = (experiment.frames - 1) / every + 1;
    if (count < kFewest) return;
    FilmFrames::Sums sums = film.none();
    for (int frame = 0; frame < experiment.frames; frame += every) film.add_frame(frame, 1.0, sums);
    design.frame_counts.push_back({count, precision.error(film.left(sums))});
  }
}

/// Frames in a set, and what it leaves open.
struct FrameSet {
  std::vector<int> frames;
  double log_variance = 0.0;
};

/// Each frame for another one, as long as that gains.
FrameSet exchanged(const FilmFrames& film, const std::vector<int>& all, const Precision& precision,
                   std::vector<int> frames) {
  constexpr int kMostSweeps = 30;
  constexpr double kLeastGain = 1e-6;
  FilmFrames::Sums sums = film.none();
  for (const int frame : frames) film.add_frame(frame, 1.0, sums);
  double best = precision.log_variance(film.left(sums));
  bool moved = true;
  for (int sweep = 0; moved && sweep < kMostSweeps; ++sweep) {
    moved = false;
    for (int& frame : frames) {
      FilmFrames::Sums others = sums;
      film.add_frame(frame, -1.0, others);
      std::vector<double> trials(all.size(), best);
      parallel_for(all.size(), [&](std::size_t k) {
        if (std::ranges::count(frames, all[k]) > 0) return;
        FilmFrames::Sums trial = others;
        film.add_frame(all[k], 1.0, trial);
        trials[k] = precision.log_variance(film.left(trial));
      });
      const auto least = std::ranges::min_element(trials);
      if (!(*least < best - kLeastGain)) continue;
      best = *least;
      frame = all[static_cast<std::size_t>(least - trials.begin())];
      film.add_frame(frame, 1.0, others);
      sums = std::move(others);
      moved = true;
    }
  }
  std::ranges::sort(frames);
  return {std::move(frames), best};
}

/// The best of exchanges that begin with frames over all of the film, its first half, and its first quarter.
void add_times(const FilmFrames& film, const Experiment& experiment, const Precision& precision, int count,
               Design& design) {
  // Of a long film every so many, but never fewer than are asked for.
  const int every =
      std::max(1, std::min((experiment.frames + kMostFrames - 1) / kMostFrames, experiment.frames / count));
  std::vector<int> all;
  for (int frame = 0; frame < experiment.frames; frame += every) all.push_back(frame);
  const auto size = static_cast<int>(all.size());
  std::optional<FrameSet> best;
  for (const int part : {1, 2, 4}) {
    const int end = std::max(count, size / part);
    std::vector<int> frames;
    for (int k = 0; k < count; ++k)
      frames.push_back(all[static_cast<std::size_t>(count == 1 ? end / 2 : k * (end - 1) / (count - 1))]);
    FrameSet found = exchanged(film, all, precision, std::move(frames));
    if (!best || found.log_variance < best->log_variance) best = std::move(found);
  }
  FilmFrames::Sums sums = film.none();
  for (const int frame : best->frames) {
    film.add_frame(frame, 1.0, sums);
    design.times.push_back(time_of(experiment, frame));
  }
  design.times_error = precision.error(film.left(sums));
}

}  // namespace

void add_film_worth(const RowsOfCaptures& captures, const Experiment& experiment, const Precision& precision,
                    const DesignOptions& options, Design& design) {
  add_outputs(captures, experiment, precision, design);
  const FilmFrames film(captures, experiment.frames, precision);
  add_lengths(film, experiment, precision, design);
  add_frame_counts(film, experiment, precision, design);
  if (options.times > 0) add_times(film, experiment, precision, options.times, design);
}

}  // namespace samara::identification
