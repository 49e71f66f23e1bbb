#include "samara/codebooks/query/derived_query.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/codebooks/book/argument_checks.h"
#include "samara/codebooks/book/book_model.h"
#include "samara/models/trajectories/derived_outputs.h"

namespace samara::codebooks {

namespace {

/// Where an output wanted comes from: what the query of stored outputs answers, or what is derived.
struct OutputPlace {
  bool is_derived = false;
  Eigen::Index index = 0;

  bool operator==(const OutputPlace&) const = default;
};

template <class Items>
Eigen::Index index_in(const Items& items, const std::string& name) {
  return std::ranges::find(items, name) - std::ranges::begin(items);
}

const pgd::OutputLabel& label_of(const std::vector<pgd::OutputLabel>& outputs, const std::string& name) {
  const auto found = std::ranges::find(outputs, name, &pgd::OutputLabel::name);
  if (found != outputs.end()) return *found;
  std::vector<std::string> known;
  for (const pgd::OutputLabel& output : outputs) known.push_back(output.name);
  throw ArgumentError(fmt::format("the codebook has no output \"{}\"{}", name, suggestion(name, known)));
}

}  // namespace

struct DerivedQuery::Impl {
  std::vector<pgd::OutputLabel> labels;
  std::vector<OutputPlace> places;
  Query stored;
  // Of what is derived: how it is worked out, and where the states stand among what is stored.
  std::optional<models::ParametricModel> model;
  std::optional<models::DerivedOutputs> evaluator;
  std::vector<Eigen::Index> states;
  std::vector<int> free;        ///< per free coordinate, which one of the model; -1: time
  std::vector<double> point;    ///< all coordinates of the codebook, those that are held included
  std::vector<std::size_t> at;  ///< per free coordinate, its place in the point
  Eigen::VectorXd own_values, derived_values, state_values;
  Eigen::MatrixXd own_slopes, derived_slopes, state_slopes;

  Impl(const Codebook& book, const QueryOptions& options, std::vector<std::string> own_names,
       std::vector<pgd::OutputLabel> wanted, std::vector<OutputPlace> wanted_places)
      : labels(std::move(wanted)),
        places(std::move(wanted_places)),
        stored(book, {own_names, options.fixed, options.precision, options.as_stored}) {
    own_values.resize(stored.output_count());
    own_slopes.resize(stored.output_count(), std::ssize(stored.coordinates()));
    if (std::ranges::none_of(places, &OutputPlace::is_derived)) return;
    model.emplace(model_of(book));
    evaluator.emplace(*model);
    for (const models::StateInfo& state : model->model().info().states)
      states.push_back(index_in(own_names, state.name));
    for (const Coordinate& c : book.coordinates()) {
      const auto held = options.fixed.find(c.name);
      if (held == options.fixed.end()) {
        at.push_back(point.size());
        free.push_back(static_cast<int>(point.size()) - 1);  // time first
      }
      point.push_back(held == options.fixed.end() ? 0.0 : held->second);
    }
    state_values.resize(std::ssize(states));
    state_slopes.resize(std::ssize(states), own_slopes.cols());
    derived_values.resize(evaluator->count());
    derived_slopes.resize(evaluator->count(), own_slopes.cols());
  }

  /// After the query of what is stored.
  void derive(std::span<const double> x, bool with_slopes) {
    for (std::size_t k = 0; k < x.size(); ++k) point[at[k]] = x[k];
    evaluator->set(std::span<const double>(point).subspan(1));
    state_values = own_values(states);
    const std::span<const double> in(state_values.data(), states.size());
    const std::span<double> out(derived_values.data(), static_cast<std::size_t>(derived_values.size()));
    if (!with_slopes) return evaluator->evaluate(point[0], in, out);
    state_slopes = own_slopes(states, Eigen::all);
    evaluator->evaluate(point[0], in, state_slopes, free, out, derived_slopes);
  }
};

DerivedQuery::DerivedQuery(const Codebook& book, const QueryOptions& options) {
  const std::vector<pgd::OutputLabel> derived = derived_outputs(book);
  std::vector<pgd::OutputLabel> all = book.outputs();
  all.insert(all.end(), derived.begin(), derived.end());
  std::vector<pgd::OutputLabel> wanted;
  if (options.outputs.empty()) wanted = all;
  for (const std::string& name : options.outputs) wanted.push_back(label_of(all, name));
  std::vector<std::string> own;
  std::vector<OutputPlace> places;
  for (const pgd::OutputLabel& label : wanted) {
    const auto found = std::ranges::find(derived, label.name, &pgd::OutputLabel::name);
    if (found != derived.end()) {
      const OutputPlace place{true, found - derived.begin()};
      if (std::ranges::find(places, place) != places.end())
        throw ArgumentError(fmt::format("output \"{}\" is chosen twice", label.name));
      places.push_back(place);
      continue;
    }
    places.push_back({false, std::ssize(own)});
    own.push_back(label.name);
  }
  if (std::ranges::any_of(places, &OutputPlace::is_derived)) {
    for (const models::StateInfo& state : known_model(book.model())->info().states)
      if (std::ranges::find(own, state.name) == own.end()) own.push_back(state.name);
  }
  impl_ = std::make_unique<Impl>(book, options, std::move(own), std::move(wanted), std::move(places));
}
DerivedQuery::~DerivedQuery() = default;
DerivedQuery::DerivedQuery(DerivedQuery&&) noexcept = default;
DerivedQuery& DerivedQuery::operator=(DerivedQuery&&) noexcept = default;

const std::vector<Coordinate>& DerivedQuery::coordinates() const {
  return impl_->stored.coordinates();
}
const std::vector<pgd::OutputLabel>& DerivedQuery::outputs() const {
  return impl_->labels;
}
Precision DerivedQuery::precision() const {
  return impl_->stored.precision();
}

void DerivedQuery::values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values) {
  Impl& impl = *impl_;
  const auto count = std::ssize(impl.places);
  require_size("values", size_of(values), {count, 1});
  impl.stored.values(x, impl.own_values);
  if (impl.evaluator) impl.derive(x, false);
  for (Eigen::Index o = 0; o < count; ++o) {
    const OutputPlace& place = impl.places[static_cast<std::size_t>(o)];
    values[o] = (place.is_derived ? impl.derived_values : impl.own_values)[place.index];
  }
}

void DerivedQuery::values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                          Eigen::Ref<Eigen::MatrixXd> gradient) {
  Impl& impl = *impl_;
  const auto count = std::ssize(impl.places);
  require_size("values", size_of(values), {count, 1});
  require_size("derivatives", size_of(gradient), {count, impl.own_slopes.cols()});
  impl.stored.values(x, impl.own_values, impl.own_slopes);
  if (impl.evaluator) impl.derive(x, true);
  for (Eigen::Index o = 0; o < count; ++o) {
    const OutputPlace& place = impl.places[static_cast<std::size_t>(o)];
    values[o] = (place.is_derived ? impl.derived_values : impl.own_values)[place.index];
    gradient.row(o) = (place.is_derived ? impl.derived_slopes : impl.own_slopes).row(place.index);
  }
}

}  // namespace samara::codebooks
