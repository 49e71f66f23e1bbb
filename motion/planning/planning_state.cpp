#include "samara/motion/planning/planning_state.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/version.h"
#include "samara/codebooks/book/codebook.h"
#include "samara/io/checksum.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/hdf5_writer.h"
#include "samara/motion/sweeps/sweep.h"

namespace samara::motion {

namespace {

constexpr const char* kPlanningFormat = "samara-planning";
constexpr const char* kPlanningVersion = "0.3";

/// Numbers one after the other: what is put in comes out in the same order.
struct NumberTape {
  std::vector<double> numbers;
  std::size_t at = 0;
  const io::Hdf5Reader* file = nullptr;

  double next() {
    if (at == numbers.size()) throw file->error("/state", "ends too early: the file is damaged");
    return numbers[at++];
  }
  /// A count of things that take `least` numbers each, or more.
  std::size_t count(std::size_t least = 1) {
    const double value = next();
    const double most = static_cast<double>(numbers.size() - at) / static_cast<double>(least);
    if (!(value >= 0.0) || value != std::floor(value) || value > most)
      throw file->error("/state",
                        fmt::format("has a count of {}, which it does not hold: the file is damaged", value));
    return static_cast<std::size_t>(value);
  }
  int whole() {
    const double value = next();
    if (!(std::abs(value) < 1e9) || value != std::floor(value))
      throw file->error("/state", fmt::format("has {} for a whole number: the file is damaged", value));
    return static_cast<int>(value);
  }
  /// Of anything that is counted.
  long natural() {
    const double value = next();
    if (!(value >= 0.0 && value < 1e15) || value != std::floor(value))
      throw file->error("/state", fmt::format("has {} for a count: the file is damaged", value));
    return static_cast<long>(value);
  }
};

/// One description of each struct for both ways: `put` and `take` differ in what `number` does.
class Putter {
 public:
  explicit Putter(NumberTape& tape) : tape_(tape) {}
  void number(double& value) { tape_.numbers.push_back(value); }
  void number(int& value) { tape_.numbers.push_back(value); }
  void number(long& value) { tape_.numbers.push_back(static_cast<double>(value)); }
  void number(std::size_t& value) { tape_.numbers.push_back(static_cast<double>(value)); }
  void flag(bool& value) { tape_.numbers.push_back(value ? 1.0 : 0.0); }
  template <class List>
  void size(List& list) {
    tape_.numbers.push_back(static_cast<double>(list.size()));
  }

 private:
  NumberTape& tape_;
};

class Taker {
 public:
  explicit Taker(NumberTape& tape) : tape_(tape) {}
  void number(double& value) { value = tape_.next(); }
  void number(int& value) { value = tape_.whole(); }
  void number(long& value) { value = tape_.natural(); }
  void number(std::size_t& value) { value = static_cast<std::size_t>(tape_.natural()); }
  void flag(bool& value) { value = tape_.next() != 0.0; }
  template <class List>
  void size(List& list) {
    list.resize(tape_.count());
  }

 private:
  NumberTape& tape_;
};

template <class Way>
void pass(Way& way, double& value) {
  way.number(value);
}

template <class Way>
void pass(Way& way, int& value) {
  way.number(value);
}

template <class Way>
void pass(Way& way, FallPoint& point);
template <class Way>
void pass(Way& way, CourseKnot& knot);
template <class Way>
void pass(Way& way, BeamNode& node);
template <class Way>
void pass(Way& way, PlanningStep& step);

template <class Way, class Item>
void pass(Way& way, std::vector<Item>& list) {
  way.size(list);
  for (Item& item : list) pass(way, item);
}

template <class Way>
void pass(Way& way, FallPoint& point) {
  for (double* value :
       {&point.t, &point.height, &point.square_time, &point.deviation.x(), &point.deviation.y(),
        &point.deviation.z(), &point.acceleration_square, &point.changes, &point.turbulence, &point.kinds})
    way.number(*value);
  way.number(point.events);
  pass(way, point.state);
  pass(way, point.coefficients);
  pass(way, point.heading_for);
  pass(way, point.past);
}

template <class Way>
void pass(Way& way, CourseKnot& knot) {
  way.number(knot.t);
  way.number(knot.ramp);
  pass(way, knot.values);
}

template <class Way>
void pass(Way& way, BeamNode& node) {
  pass(way, node.point);
  pass(way, node.target);
  way.number(node.parent);
  way.number(node.t_from);
  way.number(node.rank);
}

/// The stage is "windows", or else "beam".
template <class Way>
void pass(Way& way, PlanningStep& step) {
  bool is_of_windows = step.stage == "windows";
  way.flag(is_of_windows);
  step.stage = is_of_windows ? "windows" : "beam";
  way.number(step.cost);
  way.number(step.depth);
  way.number(step.pieces);
}

template <class Way>
void pass(Way& way, BeamState::Finished& one) {
  way.number(one.round);
  way.number(one.index);
  way.number(one.cost);
}

template <class Way>
void pass(Way& way, RefiningState& state) {
  pass(way, state.knots);
  pass(way, state.best.knots);
  pass(way, state.best.end);
  way.number(state.best.cost);
  way.number(state.sweep);
  way.number(state.first);
  way.flag(state.has_improved);
  way.number(state.use.windows);
  way.number(state.use.served);
  way.number(state.use.asked);
  pass(way, state.history);
}

template <class Way>
void pass(Way& way, PlanningState& state) {
  pass(way, state.beam.rounds);
  pass(way, state.beam.ended);
  pass(way, state.beam.finished);
  pass(way, state.beam.history);
  way.number(state.beam.pieces);
  way.number(state.beam.lowest);
  way.number(state.beam.sunk_in);
  bool refines = state.refining.has_value();
  way.flag(refines);
  if (refines) {
    if (!state.refining) state.refining.emplace();
    pass(way, *state.refining);
  }
}

/// A hash of numbers: databases are too large to be written down.
class Digest {
 public:
  void add(double value) { hash_ = io::fnv1a(std::as_bytes(std::span(&value, 1)), hash_); }
  void add(const Eigen::Ref<const Eigen::MatrixXd>& values) {
    for (const double value : values.reshaped()) add(value);
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = io::fnv1a(std::string_view());
};

std::string sequence_text(const MotionSequence& sequence) {
  std::string text =
      fmt::format("sequence {} {} {}\n", sequence.weight, sequence.origin, sequence.is_of_places);
  for (const AskedSegment& one : sequence.segments)
    text += one.kind ? to_string(*one.kind) + "\n" : to_string(*one.pattern) + "\n";
  if (sequence.chain) {
    Digest digest;
    digest.add(sequence.chain->counts());
    text += fmt::format("chain {} {}\n", sequence.chain->order(), digest.value());
  }
  return text;
}

/// A search looks into lists by the numbers of its points, which in a damaged file may be any.
bool fits(const FallPoint& point, const MotionPlan& plan) {
  const auto is_kind = [](int kind) { return kind >= 0 && kind < static_cast<int>(kEventKinds); };
  return point.events >= 0 && point.state.size() == plan.model->info().states.size() &&
         point.coefficients.size() == plan.box.size() && point.heading_for.size() == plan.box.size() &&
         std::ssize(point.past) <= MarkovChain::kMostOrder && std::ranges::all_of(point.past, is_kind);
}

bool fits(const BeamState& beam, const MotionPlan& plan) {
  if (beam.rounds.empty() || beam.rounds.size() != beam.ended.size()) return false;
  for (std::size_t round = 0; round < beam.rounds.size(); ++round) {
    // The first one has no parent.
    const auto has_parent = [&](const BeamNode& node) {
      return round == 0 || (node.parent >= 0 && node.parent < std::ssize(beam.rounds[round - 1]));
    };
    for (const auto* nodes : {&beam.rounds[round], &beam.ended[round]}) {
      for (const BeamNode& node : *nodes)
        if (!fits(node.point, plan) || node.target.size() != plan.box.size() || !has_parent(node))
          return false;
    }
  }
  return std::ranges::all_of(beam.finished, [&](const BeamState::Finished& one) {
    if (one.round < 0 || one.round >= std::ssize(beam.rounds)) return false;
    const auto round = static_cast<std::size_t>(one.round);
    return one.index >= 0 && one.index < std::ssize(beam.rounds[round]) + std::ssize(beam.ended[round]);
  });
}

bool fits(const RefiningState& refining, const MotionPlan& plan) {
  const auto is_whole = [&](const CourseKnot& knot) {
    return std::isfinite(knot.t) && std::isfinite(knot.ramp) && knot.values.size() == plan.box.size();
  };
  return refining.sweep >= 0 && fits(refining.best.end, plan) &&
         std::ranges::all_of(refining.knots, is_whole) && std::ranges::all_of(refining.best.knots, is_whole);
}

/// By where it comes from and its box.
std::string codebook_text(const codebooks::Codebook& book) {
  std::string text = fmt::format("codebook {}\n{}\n", book.provenance().created, book.provenance().plan);
  for (const codebooks::Coordinate& c : book.coordinates())
    text += fmt::format("{} {} {}\n", c.name, c.lower, c.upper);
  return text;
}

}  // namespace

std::string identity_of(const MotionPlan& plan) {
  std::string text =
      fmt::format("samara {}\n{}\n{}", version(), plan.model->info().name, model_text(plan.model->info()));
  for (const auto& [name, value] : plan.fixed) text += fmt::format("{} {}\n", name, value);
  for (const SteeredCoefficient& c : plan.box)
    text += fmt::format("box {} {} {} {}\n", c.name, c.lower, c.upper, c.natural);
  if (plan.sketch) {
    Digest digest;
    digest.add(plan.sketch->points());
    digest.add(plan.sketch->times());
    text += fmt::format("sketch of {} points, {}\n", plan.sketch->points().rows(), digest.value());
  }
  if (plan.landing) text += fmt::format("landing {} {}\n", plan.landing->x(), plan.landing->y());
  text += fmt::format("ground {} duration {} turbulence {}\n", plan.ground, plan.duration.value_or(0.0),
                      plan.turbulence);
  if (plan.database) {
    Digest digest;
    digest.add(plan.database->starts);
    for (const MotionRun& run : plan.database->runs) {
      digest.add(run.coefficients);
      digest.add(static_cast<double>(run.pattern));
    }
    for (const MotionSegment& segment : plan.database->segments) {
      digest.add(static_cast<double>(segment.run));
      digest.add(static_cast<double>(segment.kind));
      digest.add(segment.is_steady ? 1.0 : 0.0);
    }
    text += fmt::format("database of {} segments, {}\n", plan.database->segment_count(), digest.value());
  }
  if (plan.codebook) text += codebook_text(*plan.codebook);
  if (plan.sequence) text += sequence_text(*plan.sequence);
  const MotionSearch& search = plan.search;
  return text + fmt::format("search {} {} {} {} {} {}\n", search.beam, search.children, search.sweeps,
                            search.step, search.ramp, search.seed);
}

void save_state(const PlanningState& state, const MotionPlan& plan, const std::filesystem::path& path) {
  NumberTape tape;
  Putter way(tape);
  PlanningState copy = state;
  pass(way, copy);
  io::Hdf5Writer file(path);
  file.write_text_attribute("/", "format", kPlanningFormat);
  file.write_text_attribute("/", "format_version", kPlanningVersion);
  file.write_texts("/plan", {identity_of(plan)});
  file.write_vector("/state", Eigen::Map<const Eigen::VectorXd>(
                                  tape.numbers.data(), static_cast<Eigen::Index>(tape.numbers.size())));
  file.commit();
}

bool is_planning_state(const std::filesystem::path& file) {
  return io::is_hdf5_with(file, kPlanningFormat);
}

PlanningState load_state(const MotionPlan& plan, const std::filesystem::path& path) {
  const io::Hdf5Reader file(path);
  if (!file.has_attribute("/", "format") || file.text_attribute("/", "format") != kPlanningFormat ||
      file.text_attribute("/", "format_version") != kPlanningVersion)
    throw file.error("/", "is no search for a motion that was interrupted, of this version");
  if (file.texts("/plan") != std::vector<std::string>{identity_of(plan)})
    throw InputError(
        path.string(),
        "the search belongs to another plan, or to another version of this program, expected one of "
        "this plan");
  const Eigen::VectorXd numbers = file.vector("/state", {.finite = false});
  NumberTape tape{.numbers = {numbers.begin(), numbers.end()}, .file = &file};
  Taker way(tape);
  PlanningState state;
  pass(way, state);
  if (tape.at != tape.numbers.size() || !fits(state.beam, plan) ||
      (state.refining && !fits(*state.refining, plan)))
    throw file.error("/state", "does not hold a search: the file is damaged");
  return state;
}

}  // namespace samara::motion
