#include "samara/codebooks/composition/mixed_trajectories.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/codebooks/book/book_model.h"
#include "samara/codebooks/composition/shared_queries.h"
#include "samara/models/trajectories/derived_outputs.h"

namespace samara::codebooks {

namespace {

/// Where a coordinate of the codebook comes from.
struct CoverCoordinate {
  std::optional<std::size_t> from = {};  ///< of the family's coordinates
  double value = 0.0;                    ///< if the family holds it
  double lower = 0.0, upper = 0.0;
};

/// How the answers of a codebook become those of the family.
struct Cover {
  const Codebook* book = nullptr;
  std::vector<CoverCoordinate> coordinates;
  double end_time = 0.0;

  bool contains(std::span<const double> q) const {
    return std::ranges::all_of(coordinates, [&](const CoverCoordinate& c) {
      const double value = c.from ? q[*c.from] : c.value;
      return value >= c.lower && value <= c.upper;
    });
  }
};

Cover cover_of(const Codebook& book, const models::FamilyInfo& direct) {
  if (book.model().name != direct.model) {
    throw ArgumentError(fmt::format("the codebook is of \"{}\", the {} of \"{}\"; one model was expected",
                                    book.model().name, direct.source, direct.model));
  }
  Cover cover{&book, {}, book.time("a family of trajectories").upper};
  for (std::size_t k = 1; k < book.coordinates().size(); ++k) {
    const Coordinate& c = book.coordinates()[k];
    CoverCoordinate place{.from = position(direct.coordinates, c.name), .lower = c.lower, .upper = c.upper};
    if (!place.from) {
      const auto held = direct.fixed.find(c.name);
      if (held == direct.fixed.end()) {
        throw ArgumentError(fmt::format("the codebook has the coordinate \"{}\", which the {} does not name",
                                        c.name, direct.source));
      }
      place.value = held->second;
    }
    cover.coordinates.push_back(place);
  }
  return cover;
}

bool same(double held, double value) {
  return std::abs(held - value) <= 1e-12 * std::abs(value);
}

/// Whether the motion does not depend on the start of that name.
bool is_place(const models::FamilyInfo& direct, const std::string& name) {
  return std::ranges::any_of(direct.translations,
                             [&](const std::string& output) { return output + "(0)" == name; });
}

/// What the codebook holds must be held by the family at the same value, unless the motion does not depend on
/// it.
void check_held(const Codebook& book, const models::FamilyInfo& direct) {
  for (const auto& [name, value] : book.model().fixed) {
    if (is_place(direct, name)) continue;
    const auto held = direct.fixed.find(name);
    if (held != direct.fixed.end() && same(held->second, value)) continue;
    throw ArgumentError(fmt::format(
        "the codebook holds \"{}\" at {}; the {} {}", name, value, direct.source,
        held == direct.fixed.end() ? std::string("does not") : fmt::format("holds it at {}", held->second)));
  }
}

/// All parameters of the model and all starts, at a point of the codebook's box.
std::map<std::string, double> values_of_model(const models::ParametricModel& model,
                                              const std::vector<double>& q) {
  const models::ModelInfo& info = model.model().info();
  const std::vector<double> parameters = model.parameters(q);
  std::vector<double> starts(info.states.size());
  model.initial(q, starts);
  std::map<std::string, double> values;
  for (std::size_t j = 0; j < parameters.size(); ++j) values[info.parameters[j].name] = parameters[j];
  for (std::size_t i = 0; i < starts.size(); ++i) values[info.states[i].name + "(0)"] = starts[i];
  return values;
}

/// Null where the codebook's model is not known, or needs more than the codebook names.
std::optional<models::ParametricModel> known_equations(const Codebook& book) {
  try {
    return model_of(book);
  } catch (const ArgumentError&) {
    return std::nullopt;
  }
}

/// Ends of the codebook's box, and a point that has another share of every interval: defaults that follow from what is
/// free differ from point to point.
std::vector<std::vector<double>> points_of_box(const Codebook& book) {
  std::vector<std::vector<double>> points(3);
  for (std::size_t k = 0; k < book.parameters().size(); ++k) {
    const Coordinate& c = book.parameters()[k];
    const double share = std::fmod(static_cast<double>(k + 1) * std::numbers::phi, 1.0);
    points[0].push_back(c.lower);
    points[1].push_back(c.upper);
    points[2].push_back(c.lower + share * (c.upper - c.lower));
  }
  return points;
}

/// Whether the motion depends on which of two values a parameter has: none does on `nu` where forces do not depend on
/// the Reynolds number, nor on what outputs alone ask for. Every start may.
bool acts(const models::ParametricModel& model, const std::string& name, double one, double other,
          const std::vector<std::vector<double>>& points) {
  const models::ModelInfo& info = model.model().info();
  if (std::ranges::count(info.parameters, name, &models::ParameterInfo::name) == 0) return true;
  std::vector<std::string> free;
  for (const models::FreeCoordinate& c : model.free()) free.push_back(c.name);
  const auto with = [&](double value) {
    std::map<std::string, double> fixed = model.fixed();
    fixed[name] = value;
    return models::ParametricModel(model.shared_model(), fixed, free);
  };
  const models::ParametricModel first = with(one), then = with(other);
  models::ParametricModel::Workspace of_first = first.make_workspace(), of_then = then.make_workspace();
  std::vector<double> x(info.states.size()), f(x.size()), g(x.size());
  int number = 0;
  for (const std::vector<double>& q : points) {
    const models::Scales scales = first.scales(q);
    first.initial(q, x);
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] += std::fmod(++number * std::numbers::phi, 1.0) * models::state_scale(info.states[i], scales);
    first.rhs(0.0, x, q, f, of_first);
    then.rhs(0.0, x, q, g, of_then);
    if (f != g) return true;
  }
  return false;
}

/// What the codebook leaves to the model's defaults the family must not free, nor hold at another value, if it acts.
void check_defaults(const Codebook& book, const models::FamilyInfo& direct) {
  const auto is_default = [&](const std::string& name) {
    return !is_place(direct, name) && !book.model().fixed.contains(name) &&
           std::ranges::count(book.coordinates(), name, &Coordinate::name) == 0;
  };
  const std::optional<models::ParametricModel> model = known_equations(book);
  const std::vector<std::vector<double>> points = points_of_box(book);
  for (const models::FamilyCoordinate& c : direct.coordinates) {
    if (!is_default(c.name) || (model && !acts(*model, c.name, c.lower, c.upper, points))) continue;
    throw ArgumentError(fmt::format("\"{}\" is free in the {}; a coordinate of the codebook was expected",
                                    c.name, direct.source));
  }
  if (!model) return;
  for (const std::vector<double>& q : points) {
    const std::map<std::string, double> values = values_of_model(*model, q);
    for (const auto& [name, held] : direct.fixed) {
      const auto value = values.find(name);
      if (!is_default(name) || value == values.end() || same(held, value->second)) continue;
      if (!acts(*model, name, held, value->second, points)) continue;
      throw ArgumentError(
          fmt::format("the {} holds \"{}\" at {}; {} was expected, the default of the codebook",
                      direct.source, name, held, value->second));
    }
  }
}

/// An output that the family may shift, by how much.
struct Shift {
  Eigen::Index output = 0;
  std::optional<std::size_t> coordinate = {};  ///< of the family, whose value is the start
  double held = 0.0;                           ///< or the family's start
  double codebook_start = 0.0;                 ///< what the codebook starts from
};

/// The state that an output is; of one that no equations know the default is 0.
models::StateInfo state_of(const models::ParametricModel* equations, const std::string& output) {
  models::StateInfo unknown{.name = output, .unit = {}};
  if (equations == nullptr) return unknown;
  const std::vector<models::StateInfo>& states = equations->model().info().states;
  const auto state = std::ranges::find(states, output, &models::StateInfo::name);
  return state == states.end() ? unknown : *state;
}

/// @param equations of the family, null if it has none
std::vector<Shift> shifts_of(const Codebook& book, const models::FamilyInfo& direct,
                             const models::ParametricModel* equations,
                             const std::vector<std::string>& outputs) {
  std::vector<Shift> shifts;
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const std::string start = outputs[o] + "(0)";
    const bool moves = std::ranges::count(direct.translations, outputs[o]) > 0;
    const bool is_axis =
        std::ranges::any_of(book.coordinates(), [&](const Coordinate& c) { return c.name == start; });
    if (!moves || is_axis) continue;
    const models::StateInfo state = state_of(equations, outputs[o]);
    shifts.push_back({static_cast<Eigen::Index>(o), position(direct.coordinates, start),
                      models::held_start(state, direct.fixed),
                      models::held_start(state, book.model().fixed)});
  }
  return shifts;
}

class MixedSource final : public models::TrajectorySource {
 public:
  MixedSource(const Cover& cover, const SharedQueries& queries,
              std::unique_ptr<models::TrajectorySource> direct, const models::FamilyInfo& family,
              const models::ParametricModel* equations, const std::vector<double>& times,
              const std::vector<std::string>& outputs)
      : cover_(cover),
        direct_(std::move(direct)),
        shifts_(shifts_of(*cover.book, family, equations, outputs)),
        outputs_(static_cast<Eigen::Index>(outputs.size())),
        coordinates_(family.coordinates.size()),
        q_(cover.coordinates.size()) {
    if (times.empty() || times.back() > cover.end_time) return;
    query_ = queries.at(times, outputs);
    values_.resize(static_cast<Eigen::Index>(times.size()), outputs_);
    derivatives_.resize(static_cast<Eigen::Index>(times.size()),
                        outputs_ * static_cast<Eigen::Index>(q_.size()));
  }

  models::TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                     Eigen::MatrixXd* derivatives) override {
    models::check_point(q, coordinates_);
    if (!query_ || !cover_.contains(q)) return direct_->evaluate(q, values, derivatives);
    try {
      ask(q);
    } catch (const OutsideBoxError&) {  // in a gap between pieces
      return direct_->evaluate(q, values, derivatives);
    }
    values = values_;
    if (derivatives) spread(*derivatives);
    for (const Shift& shift : shifts_) {
      const double start = shift.coordinate ? q[*shift.coordinate] : shift.held;
      values.col(shift.output).array() += start - shift.codebook_start;
    }
    return {};
  }

 private:
  /// The codebook at q, with derivatives whether they are wanted or not: a descent that asks for values at a point
  /// mostly asks for its derivatives next.
  void ask(std::span<const double> q) {
    bool is_known = std::exchange(is_answered_, false);
    for (std::size_t k = 0; k < q_.size(); ++k) {
      const CoverCoordinate& c = cover_.coordinates[k];
      const double value = c.from ? q[*c.from] : c.value;
      is_known = is_known && q_[k] == value;
      q_[k] = value;
    }
    if (!is_known) (*query_)->values(q_, values_, derivatives_);
    is_answered_ = true;
  }

  /// Derivatives by the codebook's coordinates to their places among the family's; by the start of what is
  /// shifted they are one.
  void spread(Eigen::MatrixXd& derivatives) const {
    derivatives.setZero();
    for (std::size_t k = 0; k < q_.size(); ++k) {
      const std::optional<std::size_t> to = cover_.coordinates[k].from;
      if (!to) continue;
      derivatives.middleCols(outputs_ * static_cast<Eigen::Index>(*to), outputs_) =
          derivatives_.middleCols(outputs_ * static_cast<Eigen::Index>(k), outputs_);
    }
    for (const Shift& shift : shifts_) {
      if (!shift.coordinate) continue;
      derivatives.col(shift.output + outputs_ * static_cast<Eigen::Index>(*shift.coordinate)).setOnes();
    }
  }

  const Cover& cover_;
  std::unique_ptr<models::TrajectorySource> direct_;
  std::vector<Shift> shifts_;
  Eigen::Index outputs_;
  std::size_t coordinates_;  ///< of the family
  std::optional<SharedQueries::Query> query_;
  std::vector<double> q_;     ///< the codebook's coordinates
  bool is_answered_ = false;  ///< whether what follows is of q_
  Eigen::MatrixXd values_;
  Eigen::MatrixXd derivatives_;  ///< by the codebook's coordinates
};

class MixedTrajectories final : public models::TrajectoryFamily {
 public:
  MixedTrajectories(const Codebook& book, std::unique_ptr<models::TrajectoryFamily> direct)
      : book_(book),
        direct_(std::move(direct)),
        info_(direct_->info()),
        cover_(cover_of(book, info_)),
        queries_(book) {
    check_held(book, info_);
    check_defaults(book, info_);
    info_.source = fmt::format("codebook and {}", info_.source);
    if (equations() == nullptr) return;
    // What is derived follows from the states, whoever gives them.
    for (const models::OutputInfo& derived : equations()->model().info().outputs)
      std::erase_if(info_.outputs, [&](const auto& output) { return output.name == derived.name; });
  }

  const models::FamilyInfo& info() const override { return info_; }
  const models::ParametricModel* equations() const override { return direct_->equations(); }

  std::unique_ptr<models::TrajectoryFamily> finer() const override {
    std::unique_ptr<models::TrajectoryFamily> direct = direct_->finer();
    return direct ? std::make_unique<MixedTrajectories>(book_, std::move(direct)) : nullptr;
  }

  std::unique_ptr<models::TrajectorySource> at(const std::vector<double>& times,
                                               const std::vector<std::string>& outputs) const override {
    return mixed(direct_->at(times, outputs), times, outputs);
  }
  std::unique_ptr<models::TrajectorySource> at(const std::vector<double>& times,
                                               const std::vector<std::string>& outputs,
                                               const std::vector<int>& wanted) const override {
    return mixed(direct_->at(times, outputs, wanted), times, outputs);
  }

 private:
  std::unique_ptr<models::TrajectorySource> mixed(std::unique_ptr<models::TrajectorySource> direct,
                                                  const std::vector<double>& times,
                                                  const std::vector<std::string>& outputs) const {
    return std::make_unique<MixedSource>(cover_, queries_, std::move(direct), info_, equations(), times,
                                         outputs);
  }

  const Codebook& book_;
  std::unique_ptr<models::TrajectoryFamily> direct_;
  models::FamilyInfo info_;
  Cover cover_;
  SharedQueries queries_;
};

}  // namespace

std::unique_ptr<models::TrajectoryFamily> mixed_trajectories(
    const Codebook& book, std::unique_ptr<models::TrajectoryFamily> direct) {
  return models::with_derived_outputs(std::make_unique<MixedTrajectories>(book, std::move(direct)));
}

}  // namespace samara::codebooks
