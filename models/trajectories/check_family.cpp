#include "samara/models/trajectories/check_family.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <exception>
#include <functional>
#include <random>
#include <thread>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"

namespace samara::models {

namespace {

std::span<const double> span_of(const Eigen::VectorXd& q) {
  return {q.data(), static_cast<std::size_t>(q.size())};
}

bool same_bits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::equal(a.data(), a.data() + a.size(), b.data(), [](double x, double y) {
           return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
         });
}

bool same(const FamilyTrajectory& a, const FamilyTrajectory& b) {
  return a.outcome.status == b.outcome.status && same_bits(a.values, b.values) &&
         same_bits(a.derivatives, b.derivatives);
}

double largest(const Eigen::MatrixXd& values) {
  return values.size() == 0 ? 0.0 : values.cwiseAbs().maxCoeff();
}

/// Column by column, relative to the largest value of the column of `expected`.
bool nearly_equal(const Eigen::MatrixXd& values, const Eigen::MatrixXd& expected, double tolerance) {
  if (values.rows() != expected.rows() || values.cols() != expected.cols()) return false;
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    if (!(largest(values.col(c) - expected.col(c)) <= tolerance * largest(expected.col(c)))) return false;
  }
  return true;
}

/// The checks of one family, with the findings so far.
class Checks {
 public:
  Checks(const TrajectoryFamily& family, const CheckFamilyOptions& options)
      : family_(family),
        info_(family.info()),
        options_(options),
        times_(options.times),
        outputs_(output_names(info_)),
        derivatives_(info_.has_derivatives ? Derivatives::yes : Derivatives::no) {
    if (times_.empty()) {
      const double end = std::isfinite(info_.end_time) ? info_.end_time : 1.0;
      for (int k = 0; k <= 10; ++k) times_.push_back(end * k / 10.0);
    }
  }

  std::vector<std::string> run() {
    check_info();
    if (!findings_.empty()) return findings_;  // nothing can be asked of a family without names or a box
    draw_points();
    check_outcomes();
    if (!findings_.empty()) return findings_;
    check_repeats();
    check_parts();
    if (derivatives_ == Derivatives::yes) attempt("asking for differences", [&] { check_derivatives(); });
    check_batches();
    check_threads();
    check_refusals();
    check_outside();
    return findings_;
  }

 private:
  template <class... Arguments>
  void find(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
    findings_.push_back(fmt::format(text, std::forward<Arguments>(arguments)...));
  }

  /// A call that must go through.
  void attempt(const std::string& what, const std::function<void()>& call) {
    try {
      call();
    } catch (const std::exception& error) {
      find("{}: an exception, \"{}\"", what, error.what());
    }
  }

  FamilyTrajectory asked(const Eigen::VectorXd& q) const {
    return trajectory(family_, span_of(q), times_, outputs_, derivatives_);
  }

  void check_info() {
    if (info_.model.empty()) find("the family has no name of a model");
    if (info_.source.empty()) find("the family has no words on its source");
    if (info_.outputs.empty()) find("the family has no outputs");
    if (!(info_.end_time > 0.0)) find("the family ends at {} s", info_.end_time);
    std::vector<std::string> seen;
    const auto look = [&](const std::string& name, const std::string& unit) {
      if (name.empty()) find("a name is empty");
      if (unit.empty()) find("\"{}\" has no unit (\"1\" if it is dimensionless)", name);
      if (std::ranges::count(seen, name) > 0) find("the name \"{}\" is used twice", name);
      seen.push_back(name);
    };
    for (const FamilyCoordinate& c : info_.coordinates) {
      look(c.name, c.unit);
      if (!(std::isfinite(c.lower) && std::isfinite(c.upper) && c.lower < c.upper)) {
        find("the box of \"{}\" goes from {} to {}", c.name, c.lower, c.upper);
      }
      if (info_.fixed.contains(c.name)) find("\"{}\" is both free and held", c.name);
    }
    seen.clear();
    for (const FamilyOutput& output : info_.outputs) look(output.name, output.unit);
    const auto need_output = [&](const std::string& name, const char* list) {
      if (std::ranges::count(outputs_, name) == 0) find("\"{}\" of {} is no output", name, list);
    };
    for (const std::string& name : info_.translations) need_output(name, "translations");
    for (const std::string& name : info_.attitude) need_output(name, "attitude");
    if (!info_.attitude.empty() && info_.attitude.size() != 4) {
      find("the attitude has {} outputs, not four", info_.attitude.size());
    }
  }

  /// Inside the box by more than a difference.
  void draw_points() {
    std::mt19937 random(options_.seed);
    const double margin = 2.0 * options_.difference;
    for (int n = 0; n < options_.points; ++n) {
      Eigen::VectorXd q(static_cast<Eigen::Index>(info_.coordinates.size()));
      for (Eigen::Index k = 0; k < q.size(); ++k) {
        const FamilyCoordinate& c = info_.coordinates[static_cast<std::size_t>(k)];
        const double share = margin + (1.0 - 2.0 * margin) * static_cast<double>(random()) / 4294967296.0;
        q[k] = c.lower + share * (c.upper - c.lower);
      }
      points_.push_back(q);
    }
  }

  /// Keeps the trajectories that are there.
  void check_outcomes() {
    std::vector<Eigen::VectorXd> usable;
    for (std::size_t n = 0; n < points_.size(); ++n) {
      attempt(fmt::format("inside the box, at point {}", n), [&] {
        FamilyTrajectory one = asked(points_[n]);
        check_outcome(one, fmt::format("inside the box, at point {}", n));
        if (!one.outcome) return;
        usable.push_back(points_[n]);
        trajectories_.push_back(std::move(one));
      });
    }
    if (usable.empty() && findings_.empty()) {
      find("there is no trajectory at any of {} points of the box", points_.size());
    }
    points_ = std::move(usable);
  }

  void check_outcome(const FamilyTrajectory& one, const std::string& where) {
    if (one.outcome) {
      if (!one.values.allFinite()) find("{}: the status is done, and values are not finite", where);
      if (!one.derivatives.allFinite()) find("{}: the status is done, and derivatives are not finite", where);
      return;
    }
    if (one.outcome.message.empty()) find("{}: there is no trajectory, and no message says why", where);
    if (!one.values.topRows(rows_reached(one.outcome, times_)).allFinite()) {
      find("{}: values before the time reached are not finite", where);
    }
  }

  void check_repeats() {
    attempt("asking twice", [&] {
      const auto source = family_.at(times_, outputs_);
      for (int pass = 0; pass < 2; ++pass) {
        for (std::size_t n = 0; n < points_.size(); ++n) {
          FamilyTrajectory again = trajectories_[n];
          again.values.setZero();
          again.derivatives.setZero();
          again.outcome = source->evaluate(span_of(points_[n]), again.values,
                                           derivatives_ == Derivatives::yes ? &again.derivatives : nullptr);
          if (same(again, trajectories_[n])) continue;
          return find("asked again, point {} gives other bits", n);
        }
      }
    });
  }

  void check_parts() {
    attempt("asking for parts", [&] {
      const FamilyTrajectory& whole = trajectories_[0];
      const auto width = static_cast<Eigen::Index>(outputs_.size());
      for (Eigen::Index o = 0; o < width; ++o) {
        const std::string& name = outputs_[static_cast<std::size_t>(o)];
        const FamilyTrajectory one = trajectory(family_, span_of(points_[0]), times_, {name});
        if (!nearly_equal(one.values, whole.values.col(o), options_.round_off)) {
          find("\"{}\" alone is not \"{}\" among all outputs", name, name);
        }
      }
      for (Eigen::Index k = 0; derivatives_ == Derivatives::yes && k < points_[0].size(); ++k) {
        const auto source = family_.at(times_, outputs_, {static_cast<int>(k)});
        FamilyTrajectory part = whole;
        part.derivatives.setZero();
        part.outcome = source->evaluate(span_of(points_[0]), part.values, &part.derivatives);
        const auto own = [&](const Eigen::MatrixXd& all) { return all.middleCols(width * k, width); };
        if (part.outcome && nearly_equal(own(part.derivatives), own(whole.derivatives), options_.round_off)) {
          continue;
        }
        find("derivatives by \"{}\" alone are not those among all",
             info_.coordinates[static_cast<std::size_t>(k)].name);
      }
    });
  }

  void check_derivatives() {
    const auto width = static_cast<Eigen::Index>(outputs_.size());
    for (std::size_t n = 0; n < points_.size(); ++n) {
      for (Eigen::Index k = 0; k < points_[n].size(); ++k) {
        const FamilyCoordinate& c = info_.coordinates[static_cast<std::size_t>(k)];
        const double step = options_.difference * (c.upper - c.lower);
        Eigen::VectorXd lower = points_[n], upper = points_[n];
        lower[k] -= step;
        upper[k] += step;
        const FamilyTrajectory a = trajectory(family_, span_of(lower), times_, outputs_);
        const FamilyTrajectory b = trajectory(family_, span_of(upper), times_, outputs_);
        if (!a.outcome || !b.outcome) continue;
        const Eigen::MatrixXd quotient = (b.values - a.values) / (upper[k] - lower[k]);
        for (Eigen::Index o = 0; o < width; ++o) {
          const Eigen::VectorXd derivative = trajectories_[n].derivatives.col(o + width * k);
          const double scale =
              largest(derivative) + largest(trajectories_[n].values.col(o)) / (c.upper - c.lower);
          const double error = largest(derivative - quotient.col(o));
          if (error <= options_.derivative_tolerance * scale) continue;
          return find("the derivative of \"{}\" by \"{}\" is off by {:.3g} of its size at point {}",
                      outputs_[static_cast<std::size_t>(o)], c.name, error / scale, n);
        }
      }
    }
  }

  void check_batches() {
    attempt("a batch", [&] {
      Eigen::MatrixXd points(std::ssize(points_), points_[0].size());
      for (Eigen::Index n = 0; n < points.rows(); ++n) {
        points.row(n) = points_[static_cast<std::size_t>(n)].transpose();
      }
      const FamilyBatch one = family_.batch(points, times_, outputs_, {derivatives_, 1});
      const FamilyBatch many = family_.batch(points, times_, outputs_, {derivatives_, options_.threads});
      const std::size_t derivatives = derivatives_ == Derivatives::yes ? points_.size() : 0;
      if (one.outcomes.size() != points_.size() || one.values.size() != points_.size() ||
          one.derivatives.size() != derivatives) {
        return find("a batch of {} points has {} outcomes, {} values and {} derivatives", points_.size(),
                    one.outcomes.size(), one.values.size(), one.derivatives.size());
      }
      for (std::size_t n = 0; n < points_.size(); ++n) {
        const FamilyTrajectory& single = trajectories_[n];
        if (one.outcomes[n].status != single.outcome.status ||
            !nearly_equal(one.values[n], single.values, options_.round_off) ||
            (derivatives > 0 && !nearly_equal(one.derivatives[n], single.derivatives, options_.round_off))) {
          return find("in a batch, point {} has another trajectory than alone", n);
        }
        if (!same_bits(one.values[n], many.values[n]) ||
            (derivatives > 0 && !same_bits(one.derivatives[n], many.derivatives[n]))) {
          return find("a batch depends on the number of threads, at point {}", n);
        }
      }
    });
  }

  void check_threads() {
    std::vector<int> wrong(static_cast<std::size_t>(options_.threads), 0);
    std::vector<std::thread> threads;
    for (int& count : wrong) {
      threads.emplace_back([&, this] {
        try {
          for (std::size_t n = 0; n < points_.size(); ++n)
            count += same(asked(points_[n]), trajectories_[n]) ? 0 : 1;
        } catch (const std::exception&) {
          ++count;
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
    if (std::ranges::any_of(wrong, [](int count) { return count > 0; })) {
      find("asked from {} threads at once, points give other bits or throw", options_.threads);
    }
  }

  /// @param call must be refused by an exception of Samara's
  void refuse(const std::string& what, const std::function<void()>& call) {
    try {
      call();
    } catch (const Error&) {
      return;
    } catch (const std::exception& error) {
      return find("{} is refused by an exception that is no samara::Error: {}", what, error.what());
    }
    find("{} is not refused", what);
  }

  void check_refusals() {
    const Eigen::VectorXd& q = points_[0];
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      for (const double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        Eigen::VectorXd wrong = q;
        wrong[k] = value;
        refuse(fmt::format("a point whose \"{}\" is {}", info_.coordinates[static_cast<std::size_t>(k)].name,
                           value),
               [&] { asked(wrong); });
      }
    }
    refuse("a point with a number too many", [&] {
      Eigen::VectorXd wrong(q.size() + 1);
      wrong << q, 0.0;
      // The matrices have the sizes of a right one: what is written at all fits.
      FamilyTrajectory one = trajectories_[0];
      family_.at(times_, outputs_)->evaluate(span_of(wrong), one.values, nullptr);
    });
    const double end = times_.back();
    refuse("times that decrease", [&] { family_.at({end, 0.5 * end}, outputs_); });
    refuse("a time before 0", [&] { family_.at({-0.1 * end, end}, outputs_); });
    refuse("a time that is not finite", [&] { family_.at({0.0, std::nan("")}, outputs_); });
    if (std::isfinite(info_.end_time)) {
      refuse("a time after the end", [&] { family_.at({0.0, 1.5 * info_.end_time}, outputs_); });
    }
    refuse("an output that there is not", [&] { family_.at(times_, {"no such output"}); });
    if (derivatives_ == Derivatives::no && q.size() > 0) {
      refuse("asking for derivatives that there are not",
             [&] { trajectory(family_, span_of(q), times_, outputs_, Derivatives::yes); });
    }
  }

  void check_outside() {
    for (Eigen::Index k = 0; k < points_[0].size(); ++k) {
      const FamilyCoordinate& c = info_.coordinates[static_cast<std::size_t>(k)];
      Eigen::VectorXd q = points_[0];
      q[k] = c.upper + 3.0 * (c.upper - c.lower);
      const std::string where = fmt::format("with \"{}\" outside the box", c.name);
      try {
        check_outcome(asked(q), where);
      } catch (const Error&) {
        continue;  // says what is wrong
      } catch (const std::exception& error) {
        find("{}: an exception that is no samara::Error, \"{}\"", where, error.what());
      }
    }
  }

  const TrajectoryFamily& family_;
  const FamilyInfo& info_;
  const CheckFamilyOptions& options_;
  std::vector<double> times_;
  std::vector<std::string> outputs_;
  Derivatives derivatives_;
  std::vector<Eigen::VectorXd> points_;
  std::vector<FamilyTrajectory> trajectories_;  ///< at the points
  std::vector<std::string> findings_;
};

}  // namespace

Check check_family(const TrajectoryFamily& family, const CheckFamilyOptions& options) {
  require(options.points >= 1, "points", options.points, "at least 1", "check_family");
  require(options.threads >= 1, "threads", options.threads, "at least 1", "check_family");
  require(options.difference > 0.0 && options.difference < 0.25, "difference", options.difference,
          "more than 0 and less than 0.25", "check_family");
  require_positive(options.derivative_tolerance, "derivative_tolerance", "check_family");
  require_not_negative(options.round_off, "round_off", "check_family");
  if (!options.times.empty()) {
    check_times(options.times);
    require_positive(options.times.back(), "the last of the times", "check_family");
  }
  return {Checks(family, options).run()};
}

}  // namespace samara::models
