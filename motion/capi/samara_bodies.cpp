#include "samara/motion/capi/samara_bodies.h"

#include <exception>
#include <memory>
#include <string>

#include "samara/base/errors.h"
#include "samara/motion/bodies/bodies.h"
#include "samara/motion/bodies/steady_wind.h"
#include "samara/motion/database/database_file.h"

struct samara_motions {
  samara::motion::NextPieces pieces;
};

struct samara_bodies {
  samara::motion::Bodies bodies;
};

namespace {

namespace motion = samara::motion;

thread_local std::string bodies_error;

/// Remembers what went wrong. Keeping the sentence may itself run out of memory.
samara_bodies_status failed_with(samara_bodies_status status, const char* sentence) noexcept {
  try {
    bodies_error = sentence;
  } catch (...) {
    bodies_error.clear();
  }
  return status;
}

template <class Run>
samara_bodies_status guarded_run(const Run& run) noexcept {
  try {
    run();
    return SAMARA_BODIES_DONE;
  } catch (const samara::ArgumentError& error) {
    return failed_with(SAMARA_BODIES_WRONG_CALL, error.what());
  } catch (const samara::InputError& error) {
    return failed_with(SAMARA_BODIES_BAD_FILE, error.what());
  } catch (const std::exception& error) {
    return failed_with(SAMARA_BODIES_INTERNAL, error.what());
  } catch (...) {
    return failed_with(SAMARA_BODIES_INTERNAL, "an unknown failure");
  }
}

void require_given(bool given, const char* what) {
  if (!given) throw samara::ArgumentError(std::string(what) + " is null");
}

motion::BodiesOptions options_from(const samara_bodies_options& given) {
  if (given.size != sizeof(samara_bodies_options))
    throw samara::ArgumentError("the options of bodies are of another version: set their size");
  motion::BodiesOptions options;
  options.choice =
      given.by_graph != 0 ? motion::BodiesOptions::Choice::graph : motion::BodiesOptions::Choice::chain;
  options.step = given.step;
  options.ramp = given.ramp;
  options.tries = given.tries;
  if (given.has_ground != 0) options.ground = given.ground;
  const Eigen::Vector3d wind(given.wind[0], given.wind[1], given.wind[2]);
  if (wind != Eigen::Vector3d::Zero()) options.wind = motion::steady_wind(wind);
  options.seed = given.seed;
  return options;
}

}  // namespace

extern "C" {

const char* samara_bodies_error(void) {
  return bodies_error.c_str();
}

samara_motions* samara_motions_open(const char* path) {
  samara_motions* motions = nullptr;
  guarded_run([&] {
    require_given(path != nullptr, "the path");
    motions = new samara_motions{motion::NextPieces(motion::load_database(path))};
  });
  return motions;
}

void samara_motions_close(samara_motions* motions) {
  delete motions;
}

samara_bodies_options samara_bodies_defaults(void) {
  samara_bodies_options options = {};
  options.size = sizeof(samara_bodies_options);
  options.ramp = -1.0;
  options.seed = 1;
  return options;
}

samara_bodies* samara_bodies_open(const samara_motions* motions, size_t count,
                                  const samara_bodies_options* options) {
  samara_bodies* bodies = nullptr;
  guarded_run([&] {
    require_given(motions != nullptr, "the database");
    const samara_bodies_options defaults = samara_bodies_defaults();
    bodies = new samara_bodies{motion::Bodies(motions->pieces, static_cast<Eigen::Index>(count),
                                              options_from(options == nullptr ? defaults : *options))};
  });
  return bodies;
}

void samara_bodies_close(samara_bodies* bodies) {
  delete bodies;
}

samara_bodies_status samara_bodies_release(samara_bodies* bodies, size_t body, const double* place,
                                           double yaw) {
  return guarded_run([&] {
    require_given(bodies != nullptr && place != nullptr, "bodies or the place");
    bodies->bodies.release(static_cast<Eigen::Index>(body), Eigen::Vector3d(place[0], place[1], place[2]),
                           yaw);
  });
}

samara_bodies_status samara_bodies_advance(samara_bodies* bodies, double dt) {
  return guarded_run([&] {
    require_given(bodies != nullptr, "bodies");
    bodies->bodies.advance(dt);
  });
}

samara_bodies_status samara_bodies_poses(const samara_bodies* bodies, double* positions, double* rotations) {
  return guarded_run([&] {
    require_given(bodies != nullptr && positions != nullptr && rotations != nullptr,
                  "bodies or room for poses");
    const auto count = static_cast<std::size_t>(bodies->bodies.count());
    bodies->bodies.read_poses({positions, 3 * count}, {rotations, 4 * count});
  });
}

samara_body_state samara_bodies_state(const samara_bodies* bodies, size_t body) {
  samara_body_state state = SAMARA_BODY_WAITING;
  guarded_run([&] {
    require_given(bodies != nullptr, "bodies");
    state = static_cast<samara_body_state>(bodies->bodies.status(static_cast<Eigen::Index>(body)));
  });
  return state;
}

samara_bodies_counts samara_bodies_count(const samara_bodies* bodies) {
  if (bodies == nullptr) return {};
  const motion::BodyCounts& counts = bodies->bodies.counts();
  return {counts.events, counts.planned, counts.kept, counts.drawn, counts.taken, counts.redrawn};
}

size_t samara_bodies_falling(const samara_bodies* bodies) {
  return bodies == nullptr ? 0 : static_cast<size_t>(bodies->bodies.falling());
}
}
