#include "samara/motion/bodies/bodies.h"

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "calls.h"
#include "rooms.h"
#include "samara/base/errors.h"
#include "samara/motion/bodies/steady_wind.h"
#include "samara/motion/database/database_file.h"
#include "samara/motion/database/database_report.h"

namespace samara::python {

namespace {

using motion::NextPieces;

/// Bodies, with what they fall by.
struct HeldBodies {
  std::shared_ptr<const NextPieces> pieces;
  motion::Bodies bodies;
  std::mutex mutex = {};

  /// One thread at a time. The interpreter's lock is given up first, or one who waits here would keep it from all.
  template <class Work>
  auto alone(const Work& work) {
    const py::gil_scoped_release release;
    const std::lock_guard guard(mutex);
    return work(bodies);
  }
};

std::shared_ptr<NextPieces> pieces_of(const motion::Sweep& sweep, const py::object& report, int threads) {
  Failure failure;
  return unlocked(failure, [&] {
    return std::make_shared<NextPieces>(
        motion::build_database(sweep, {.threads = threads, .progress = progress_to(report, failure)}));
  });
}

py::tuple segments_of(const NextPieces& pieces) {
  const motion::MotionDatabase& database = pieces.database();
  std::vector<std::string> kinds;
  std::vector<Eigen::Index> runs;
  Eigen::VectorXd durations(database.segment_count());
  for (Eigen::Index n = 0; n < database.segment_count(); ++n) {
    const motion::MotionSegment& segment = database.segments[static_cast<std::size_t>(n)];
    kinds.push_back(to_string(segment.kind));
    runs.push_back(segment.run);
    durations[n] = segment.duration;
  }
  return py::make_tuple(kinds, runs, copied(durations), copied(database.starts), copied(database.ends));
}

Eigen::Vector3d vector_of(const Array& values, const std::string& what) {
  if (shape_of(values) != Shape{3})
    throw ArgumentError(
        fmt::format("{} has the shape {}, expected (3,)", what, shape_text(shape_of(values))));
  return Eigen::Map<const Eigen::Vector3d>(values.data());
}

std::unique_ptr<HeldBodies> bodies_of(const std::shared_ptr<const NextPieces>& pieces, Eigen::Index count,
                                      bool by_graph, double step, double ramp, std::optional<double> ground,
                                      int tries, const std::optional<Array>& wind, std::uint64_t seed) {
  motion::BodiesOptions options;
  options.choice = by_graph ? motion::BodiesOptions::Choice::graph : motion::BodiesOptions::Choice::chain;
  options.step = step;
  options.ramp = ramp;
  options.ground = ground;
  options.tries = tries;
  if (wind) options.wind = motion::steady_wind(vector_of(*wind, "wind"));
  options.seed = seed;
  return std::unique_ptr<HeldBodies>(new HeldBodies{pieces, motion::Bodies(*pieces, count, options)});
}

py::tuple poses_of(HeldBodies& held, const py::object& positions, const py::object& rotations) {
  const py::ssize_t count = held.bodies.count();
  py::array_t<double> places = room_for({count, 3}, positions), turns = room_for({count, 4}, rotations);
  const std::span all_places(places.mutable_data(), static_cast<std::size_t>(3 * count)),
      all_turns(turns.mutable_data(), static_cast<std::size_t>(4 * count));
  held.alone([&](const motion::Bodies& bodies) { bodies.read_poses(all_places, all_turns); });
  return py::make_tuple(places, turns);
}

std::vector<int> states_of(HeldBodies& held) {
  return held.alone([](const motion::Bodies& bodies) {
    std::vector<int> all;
    for (Eigen::Index n = 0; n < bodies.count(); ++n) all.push_back(static_cast<int>(bodies.status(n)));
    return all;
  });
}

}  // namespace

void add_bodies(py::module_& module) {
  py::class_<NextPieces, std::shared_ptr<NextPieces>>(module, "Motions")
      .def_static(
          "open",
          [](const std::filesystem::path& path) {
            return std::make_shared<NextPieces>(motion::load_database(path));
          },
          py::arg("path"))
      .def_static("of", &pieces_of, py::arg("sweep"), py::arg("progress"), py::arg("threads"))
      .def(
          "save",
          [](const NextPieces& pieces, const std::filesystem::path& path) {
            save(pieces.database(), pieces.graph(), path);
          },
          py::arg("path"))
      .def("report",
           [](const NextPieces& pieces) {
             return motion::database_json(pieces.database(), pieces.graph(), kind_chain(pieces.database()));
           })
      .def("state_names", [](const NextPieces& pieces) { return pieces.database().state_names; })
      .def("segments", &segments_of);
  py::class_<HeldBodies>(module, "Bodies")
      .def_static("of", &bodies_of, py::arg("motions"), py::arg("count"), py::arg("by_graph"),
                  py::arg("step"), py::arg("ramp"), py::arg("ground"), py::arg("tries"), py::arg("wind"),
                  py::arg("seed"))
      .def(
          "release",
          [](HeldBodies& held, Eigen::Index body, const Array& place, double yaw) {
            const Eigen::Vector3d at = vector_of(place, "place");
            held.alone([&](motion::Bodies& bodies) { bodies.release(body, at, yaw); });
          },
          py::arg("body"), py::arg("place"), py::arg("yaw"))
      .def(
          "advance",
          [](HeldBodies& held, double dt) {
            held.alone([&](motion::Bodies& bodies) { bodies.advance(dt); });
          },
          py::arg("dt"))
      .def("counts",
           [](HeldBodies& held) {
             const motion::BodyCounts counts =
                 held.alone([](const motion::Bodies& bodies) { return motion::BodyCounts(bodies.counts()); });
             py::dict all;
             all["events"] = counts.events;
             all["planned"] = counts.planned;
             all["kept"] = counts.kept;
             all["drawn"] = counts.drawn;
             all["taken"] = counts.taken;
             all["redrawn"] = counts.redrawn;
             return all;
           })
      .def("falling",
           [](HeldBodies& held) {
             return held.alone([](const motion::Bodies& bodies) { return bodies.falling(); });
           })
      .def("poses", &poses_of, py::arg("positions"), py::arg("rotations"))
      .def("states", &states_of);
}

}  // namespace samara::python
