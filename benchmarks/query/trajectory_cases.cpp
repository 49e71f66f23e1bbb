// Plates and a body: a codebook against Runge-Kutta by hand, CVODES, and the matrix product of the machine.
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "cases.h"
#include "hand_rk4.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "samara/models/integrators/integrate.h"

namespace samara::benchmarks {

namespace {

using codebooks::Codebook;
using codebooks::Precision;
using codebooks::Query;
using codebooks::QueryOptions;
using codebooks::TrajectoryQuery;

struct Case {
  std::string name;
  std::string plan;
  std::vector<std::string> outputs;  ///< of points and trajectories
  std::vector<std::string> seen;     ///< of residuals
  std::unique_ptr<HandRk4> (*rk4)(const models::ParametricModel&) = nullptr;
  long grid = 14;  ///< nodes per parameter of the table that the codebook replaces
};

constexpr int kTrajectoryTimes = 101, kFrames = 30, kBatch = 4096;

std::vector<double> equidistant(double end, int count, bool from_zero) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(from_zero ? end * i / (count - 1) : end * (i + 1) / count);
  return times;
}

/// Points of the box, coordinates x count.
Eigen::MatrixXd random_points(const Codebook& book, int count) {
  std::srand(7);
  Eigen::MatrixXd points =
      Eigen::MatrixXd::Random(static_cast<Eigen::Index>(book.parameters().size()), count);
  for (Eigen::Index k = 0; k < points.rows(); ++k) {
    const codebooks::Coordinate& c = book.parameters()[static_cast<std::size_t>(k)];
    points.row(k) = (0.5 * (c.upper + c.lower) + 0.5 * (c.upper - c.lower) * points.row(k).array()).matrix();
  }
  return points;
}

class Run {
 public:
  Run(const Case& test_case, bool quick)
      : case_(test_case),
        rounds_(quick ? 7 : 41),
        result_(codebooks::build(codebooks::parse_plan(test_case.plan, test_case.name))),
        book_(result_.book),
        model_(codebooks::model_of(book_)),
        rk4_(test_case.rk4(model_)),
        points_(random_points(book_, kBatch)),
        end_(book_.coordinates().front().upper) {
    if (!result_.met) throw std::runtime_error(case_.name + ": " + result_.message);
    for (const codebooks::OutputError& error : book_.certificate()->outputs) range_.push_back(error.range);
    check_rates();
    print({kQuery, case_.name, "certificate_max", book_.certificate()->max_error});
  }

  void all() {
    point();
    trajectory();
    batch();
    residuals();
    gradient();
    size();
  }

 private:
  void check_rates();
  Frames frames(const std::vector<double>& times, const std::vector<std::string>& outputs) const;
  int fewest_steps(const Frames& wanted);
  double error_of(const Frames& wanted, const std::function<void(const double*, double*)>& trajectory);
  void point();
  void trajectory();
  void batch();
  void residuals();
  void gradient();
  void size();
  void say(const std::string& metric, const Pair& pair, const std::string& baseline) const {
    print({kQuery, case_.name, metric, pair.ours, "s", baseline, pair.ratio()});
  }
  /// Another point at every call.
  const double* next_point() { return points_.col(next_++ % 64).data(); }
  std::span<const double> next_q() { return {next_point(), 3}; }

  Case case_;
  int rounds_;
  codebooks::BuildResult result_;
  const Codebook& book_;
  models::ParametricModel model_;
  std::unique_ptr<HandRk4> rk4_;
  Eigen::MatrixXd points_;
  double end_;
  std::vector<double> range_;
  Eigen::Index next_ = 0;
};

/// The law written by hand must be the model.
void Run::check_rates() {
  models::ParametricModel::Workspace workspace = model_.make_workspace();
  std::vector<double> x(static_cast<std::size_t>(model_.state_count())), f(x.size()), g(x.size());
  for (int j = 0; j < 20; ++j) {
    const std::span<const double> q = next_q();
    model_.initial(q, x);
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] += 0.1 * std::sin(1.0 + static_cast<double>(j) + 2.0 * static_cast<double>(i));
    model_.rhs(0.0, x, q, f, workspace);
    rk4_->rate(q.data(), x.data(), g.data());
    for (std::size_t i = 0; i < x.size(); ++i)
      if (!(std::abs(f[i] - g[i]) <= 1e-9 * (1.0 + std::abs(f[i]))))
        throw std::runtime_error("the baseline solves another law");
  }
}

Frames Run::frames(const std::vector<double>& times, const std::vector<std::string>& outputs) const {
  Frames result{times, {}};
  const auto& states = model_.model().info().states;
  for (const std::string& name : outputs) {
    const auto at = std::ranges::find(states, name, &models::StateInfo::name);
    result.outputs.push_back(static_cast<int>(at - states.begin()));
  }
  return result;
}

/// Largest error at 200 points, of ranges.
double Run::error_of(const Frames& wanted, const std::function<void(const double*, double*)>& trajectory) {
  const auto& states = model_.model().info().states;
  models::Integrator reference(model_, {.relative_tolerance = 1e-9}, false);
  Eigen::MatrixXd values(static_cast<Eigen::Index>(wanted.times.size()),
                         static_cast<Eigen::Index>(wanted.outputs.size()));
  double worst = 0.0;
  for (Eigen::Index j = 0; j < 200; ++j) {
    const double* const q = points_.col(j * 20).data();
    trajectory(q, values.data());
    const models::Trajectory exact = reference(std::span(q, 3), wanted.times);
    for (std::size_t o = 0; o < wanted.outputs.size(); ++o) {
      const auto state = static_cast<std::size_t>(wanted.outputs[o]);
      const double range = range_[static_cast<std::size_t>(book_.output_index(states[state].name))];
      const double error =
          (values.col(static_cast<Eigen::Index>(o)) - exact.states.col(static_cast<Eigen::Index>(state)))
              .cwiseAbs()
              .maxCoeff() /
          range;
      worst = std::isnan(error) ? std::numeric_limits<double>::infinity() : std::max(worst, error);
    }
  }
  return worst;
}

/// For which the frames are as good as the codebook.
int Run::fewest_steps(const Frames& wanted) {
  int least = 1, enough = 0;
  const auto suffices = [&](int steps) {
    rk4_->prepare(wanted, steps);
    return error_of(wanted, [&](const double* q, double* values) { rk4_->trajectory(q, values); }) <=
           book_.certificate()->max_error;
  };
  for (enough = 4; !suffices(enough); enough *= 2) least = enough;
  while (enough - least > 1) {
    const int middle = (enough + least) / 2;
    (suffices(middle) ? enough : least) = middle;
  }
  rk4_->prepare(wanted, enough);
  return enough;
}

void Run::point() {
  const Frames wanted = frames({end_}, case_.outputs);
  print({kQuery, case_.name, "rk4_steps_point", static_cast<double>(fewest_steps(wanted))});
  Eigen::VectorXd values(static_cast<Eigen::Index>(case_.outputs.size()));
  const auto by_hand = [&] { rk4_->end_point(next_point(), values.data()); };
  Query query(book_, {.outputs = case_.outputs, .precision = Precision::automatic});
  std::vector<double> x(4, end_);
  say("point_any_time",
      time_both(
          [&] {
            const double* q = next_point();
            std::copy_n(q, 3, x.begin() + 1);
            query.values(x, values);
          },
          by_hand, rounds_),
      "rk4");
  Query held(book_, {.outputs = case_.outputs, .fixed = {{"t", end_}}, .precision = Precision::automatic});
  say("point", time_both([&] { held.values(next_q(), values); }, by_hand, rounds_), "rk4");
  print({kQuery, case_.name, "point_in_single_floats",
         query.precision() == Precision::single_precision ? 1.0 : 0.0});
  Eigen::MatrixXd all(4, kBatch), answers(values.size(), kBatch);
  all.row(0).setConstant(end_);
  all.bottomRows(3) = points_;
  const Pair many = time_both([&] { query.batch(all, answers); },
                              [&] {
                                for (int i = 0; i < kBatch; ++i) by_hand();
                              },
                              std::max(3, rounds_ / 4));
  say("point_batch", {many.ours / kBatch, many.theirs / kBatch}, "rk4");
}

void Run::trajectory() {
  const Frames wanted = frames(equidistant(end_, kTrajectoryTimes, true), case_.outputs);
  print({kQuery, case_.name, "rk4_steps_trajectory", static_cast<double>(fewest_steps(wanted))});
  Eigen::MatrixXd values(kTrajectoryTimes, static_cast<Eigen::Index>(case_.outputs.size()));
  TrajectoryQuery query(book_, wanted.times,
                        QueryOptions{.outputs = case_.outputs, .precision = Precision::automatic});
  say("trajectory",
      time_both([&] { query.values(next_q(), values); },
                [&] { rk4_->trajectory(next_point(), values.data()); }, rounds_),
      "rk4");
}

void Run::batch() {
  const Frames wanted = frames(equidistant(end_, kTrajectoryTimes, true), case_.outputs);
  fewest_steps(wanted);
  const auto rows = static_cast<Eigen::Index>(kTrajectoryTimes * case_.outputs.size());
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(rows, kBatch);
  for (const Precision precision : {Precision::automatic, Precision::double_precision}) {
    TrajectoryQuery query(book_, wanted.times,
                          QueryOptions{.outputs = case_.outputs, .precision = precision});
    const bool single = query.precision() == Precision::single_precision;
    const Pair one = time_both([&] { query.batch(points_, values); }, [&] { rk4_->batch(points_, values); },
                               std::max(3, rounds_ / 3));
    const std::string suffix = precision == Precision::automatic ? "" : "_double";
    say("batch" + suffix, {one.ours / kBatch, one.theirs / kBatch}, "rk4_simd");
    const double product = gemm_seconds(static_cast<int>(rows), query.inner_size(), kBatch, single);
    print({kQuery, case_.name, "gemm_fraction" + suffix, product / one.ours});
    print({kQuery, case_.name, "gemm_rate" + suffix,
           2.0 * static_cast<double>(rows) * query.inner_size() * kBatch / product * 1e-9, "GFLOP/s"});
    if (precision != Precision::automatic) continue;
    const Pair two = time_both([&] { query.batch(points_, values, 2); },
                               [&] { query.batch(points_, values, 1); }, std::max(3, rounds_ / 3));
    print({kQuery, case_.name, "threads2_over_1", two.ratio()});
  }
}

/// The loosest tolerance of a ladder at which CVODES is as good as the codebook.
double cvodes_tolerance(const std::function<bool(double)>& suffices) {
  for (double tolerance = 1e-2; tolerance > 1e-9; tolerance *= 0.5)
    if (suffices(tolerance)) return tolerance;
  return 1e-9;
}

void Run::residuals() {
  const Frames wanted = frames(equidistant(end_, kFrames, false), case_.seen);
  fewest_steps(wanted);
  const auto outputs = static_cast<Eigen::Index>(case_.seen.size());
  const Eigen::Index rows = kFrames * outputs;
  TrajectoryQuery query(book_, wanted.times,
                        QueryOptions{.outputs = case_.seen, .precision = Precision::automatic});
  const std::vector<double> observed(static_cast<std::size_t>(rows), 0.1), scales(observed.size(), 0.01);
  std::vector<double> residual(observed.size()), jacobian(observed.size() * 3);
  Eigen::MatrixXd values(kFrames, outputs), slopes(kFrames, outputs * 3);
  const auto ours = [&] { query.residuals(next_q(), observed, scales, residual, jacobian); };
  const auto finish = [&] {
    for (std::size_t i = 0; i < residual.size(); ++i) {
      const double weight = 1.0 / scales[i];
      residual[i] = (values.data()[i] - observed[i]) * weight;
      for (std::size_t k = 0; k < 3; ++k)
        jacobian[3 * i + k] = slopes.data()[i + residual.size() * k] * weight;
    }
  };
  say("residual_jacobian",
      time_both(
          ours,
          [&] {
            rk4_->with_tangents(next_point(), values.data(), slopes.data());
            finish();
          },
          rounds_),
      "rk4_tangent");
  const double tolerance = cvodes_tolerance([&](double relative) {
    models::Integrator trial(model_, {.relative_tolerance = relative}, true);
    return error_of(wanted, [&](const double* q, double* out) {
             const models::Trajectory path = trial(std::span(q, 3), wanted.times);
             for (std::size_t o = 0; o < wanted.outputs.size(); ++o)
               for (int i = 0; i < kFrames; ++i)
                 out[static_cast<int>(o) * kFrames + i] = path.states(i, wanted.outputs[o]);
           }) <= book_.certificate()->max_error;
  });
  models::Integrator cvodes(model_, {.relative_tolerance = tolerance}, true);
  say("residual_jacobian",
      time_both(
          ours,
          [&] {
            const models::Trajectory path = cvodes(next_q(), wanted.times);
            for (std::size_t o = 0; o < wanted.outputs.size(); ++o) {
              values.col(static_cast<Eigen::Index>(o)) = path.states.col(wanted.outputs[o]);
              for (std::size_t k = 0; k < 3; ++k)
                slopes.col(static_cast<Eigen::Index>(o) + outputs * static_cast<Eigen::Index>(k)) =
                    path.sensitivities[k].col(wanted.outputs[o]);
            }
            finish();
          },
          std::max(3, rounds_ / 3)),
      "cvodes");
}

void Run::gradient() {
  Query query(book_, {.outputs = case_.outputs, .precision = Precision::automatic});
  Eigen::VectorXd values(query.output_count());
  Eigen::MatrixXd slopes(query.output_count(), 4);
  std::vector<double> x(4, end_);
  const auto load = [&] {
    const double* q = next_point();
    std::copy_n(q, 3, x.begin() + 1);
  };
  const Pair pair = time_both(
      [&] {
        load();
        query.values(x, values);
      },
      [&] {
        load();
        query.values(x, values, slopes);
      },
      rounds_);
  print({kQuery, case_.name, "gradient_over_value", pair.ratio()});
}

void Run::size() {
  double bytes = 0.0;
  for (const codebooks::Piece& piece : book_.pieces())
    for (const codebooks::FieldGroup& group : piece.groups())
      bytes += 8.0 * static_cast<double>(group.entries());
  const double table = 8.0 * kTrajectoryTimes * std::pow(static_cast<double>(case_.grid), 3) *
                       static_cast<double>(book_.output_count());
  print({kQuery, case_.name, "bytes", bytes, "B"});
  print({kQuery, case_.name, "bytes_over_table", bytes / table});
}

Case plate(const std::string& name, double tolerance) {
  return {name,
          fmt::format("model = \"falling_plate_nd\"\n[fixed]\n\"theta(0)\" = 0.4\n[box]\nC_T = [0.8, 1.4]\n"
                      "C_R = [2.0, 4.0]\nA = [1.0, 1.8]\n[time]\nend = 5.0\n[tolerance]\nrelative = {}\n"
                      "[builder]\nkind = \"pgd\"\nstrategy = \"slabs\"\n",
                      tolerance),
          {"vx", "vy", "w", "theta", "x", "y"},
          {"x", "y", "theta"},
          plate_rk4};
}

}  // namespace

void run_plates(const Options& options) {
  if (options.wants("plate3_1e-3")) Run(plate("plate3_1e-3", 1e-3), options.quick).all();
  if (options.wants("plate3_1e-4")) Run(plate("plate3_1e-4", 1e-4), options.quick).all();
}

void run_body(const Options& options) {
  if (!options.wants("body3d")) return;
  // The card of 7 cm x 4 cm x 0.2 mm, steadily descending, released 10 degrees about an oblique axis.
  const double half = 5.0 * std::numbers::pi / 180.0;
  Case body{
      "body3d",
      fmt::format("model = \"immersed_body\"\n[fixed]\na = 0.035\nb = 0.02\nc = 1e-4\ndensity = 1200.0\n"
                  "C_D0 = 0.05\nC_w = 2.0\nspeed_floor = 1e-3\n\"qw(0)\" = {:.17g}\n\"qx(0)\" = {:.17g}\n"
                  "\"qy(0)\" = {:.17g}\n[box]\nC_D90 = [1.448, 2.172]\nC_T = [0.248, 0.372]\n"
                  "C_R = [0.248, 0.372]\n[time]\nend = 0.5\n[tolerance]\nrelative = 1e-3\n"
                  "absolute = {{ x = 0.1, y = 0.1, z = 0.1, qw = 1.0, qx = 1.0, qy = 1.0, qz = 1.0, "
                  "ux = 0.1, uy = 0.1, uz = 0.1, wx = 5.0, wy = 5.0, wz = 5.0 }}\n"
                  "[builder]\nkind = \"pgd\"\nstrategy = \"slabs\"\n",
                  std::cos(half), std::sin(half) * 0.8253356149096783, std::sin(half) * 0.5646424733950354),
      {"x", "y", "z", "ux", "uy", "uz"},
      {"x", "y", "z"},
      body_rk4};
  Run(body, options.quick).all();
}

}  // namespace samara::benchmarks
