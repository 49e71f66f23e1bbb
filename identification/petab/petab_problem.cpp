#include "samara/identification/petab/petab_problem.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/limits.h"
#include "samara/base/names.h"
#include "samara/base/text.h"
#include "samara/identification/captures/capture_cleaning.h"
#include "samara/identification/captures/number_cells.h"
#include "samara/identification/petab/petab_cells.h"
#include "samara/identification/petab/petab_config.h"
#include "samara/identification/petab/petab_parameters.h"

namespace samara::identification {

namespace {

using io::DelimitedTable;

/// Everything that is known while the tables are read, one after the other.
class PetabTables {
 public:
  PetabTables(PetabFile file, const ConfigNames& names) : names_(names) { problem_.file = std::move(file); }

  PetabProblem read(const std::vector<std::string>& free) {
    PetabParameters parameters = read_petab_parameters(problem_.file.parameters.front());
    problem_.parameters = std::move(parameters.rows);
    problem_.parameter_columns = std::move(parameters.columns);
    problem_.parameter_cells = std::move(parameters.cells);
    for (const auto& path : problem_.file.observables) read_observables(path);
    for (const auto& path : problem_.file.measurements) read_measurements(path);
    add_captures();
    set_attitude_noise();
    for (const auto& path : problem_.file.conditions) read_conditions(path);
    for (const auto& [condition, captures] : captures_of_) {
      if (!conditions_.contains(condition))
        throw InputError(problem_.file.conditions.front().string(),
                         fmt::format("there is no condition {}", in_quotes(condition)));
    }
    bind_conditions();
    bind_parameters();
    for (const std::string& name : free) {
      if (!settings_.held.contains(name) && !settings_.known.contains(name) && !is_bound(name))
        throw InputError(
            problem_.file.parameters.front().string(),
            fmt::format("nothing is said of \"{}\", which is free in the codebook; a row for it was expected",
                        name));
    }
    problem_.config = petab_config(problem_, settings_);
    return std::move(problem_);
  }

 private:
  struct Cell {
    std::string text;
    int line;
  };
  using Key = std::pair<std::string, std::string>;               ///< condition and replicate
  using Rows = std::map<double, std::map<std::string, double>>;  ///< by time and output
  struct Series {
    std::filesystem::path file;  ///< of its first row
    std::vector<Rows> replicates = {};
  };

  void read_observables(const std::filesystem::path& path) {
    const DelimitedTable table = read_tsv(path, {"observableId", "observableFormula", "noiseFormula"});
    const auto ids = table.texts("observableId"), formulas = table.texts("observableFormula"),
               noises = table.texts("noiseFormula");
    const auto transformations = cells_or_empty(table, "observableTransformation"),
               distributions = cells_or_empty(table, "noiseDistribution");
    std::vector<std::string> outputs;
    for (const auto& [name, unit] : names_.outputs) outputs.push_back(name);
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const std::string& id = ids[row];
      require_word(table, row, "observableTransformation", transformations[row], {"lin"});
      require_word(table, row, "noiseDistribution", distributions[row], {"normal"});
      if (!names_.outputs.contains(formulas[row]))
        throw table.error(
            row, fmt::format("the observable {} is {}; the name of one output was expected{}", in_quotes(id),
                             in_quotes(formulas[row]), suggestion(formulas[row], outputs)));
      if (output_of_.contains(id) || problem_.observables.contains(formulas[row]))
        throw table.error(row, fmt::format("the observable {} stands there twice, or the output {} has two",
                                           in_quotes(id), in_quotes(formulas[row])));
      output_of_[id] = formulas[row];
      noise_formula_[id] = {noises[row], table.line_of_row(row)};
      problem_.observables[formulas[row]] = id;
    }
  }

  /// The noise of an observable: a level in a measurement's cell, where its formula asks for that; else its formula.
  void take_noise(const DelimitedTable& table, std::size_t row, const std::string& id,
                  const std::string& cell) {
    const std::string& formula = noise_formula_.at(id).text;
    const bool from_measurement = formula == fmt::format("noiseParameter1_{}", id);
    const std::string& text = from_measurement ? cell : formula;
    if (!from_measurement && !cell.empty())
      throw table.error(row, fmt::format("noiseParameters are {}, but noiseFormula of {} is {}",
                                         in_quotes(cell), in_quotes(id), in_quotes(formula)));
    PetabParameter* const parameter = find(text);
    const std::optional<double> number = parameter != nullptr ? parameter->nominal : number_in(text);
    if (parameter == nullptr && !number)
      throw table.error(row, fmt::format("the noise of {} is {}; a number or a parameter was expected",
                                         in_quotes(id), in_quotes(text)));
    if (number && !(*number > 0.0))
      throw table.error(
          row, fmt::format("the noise of {} is {}; more than 0 was expected", in_quotes(id), *number));
    if (number) in_size(table, row, fmt::format("the noise of {}", in_quotes(id)), *number);
    const std::string& output = output_of_.at(id);
    const auto [known, is_new] = noise_text_.emplace(id, text);
    if (known->second != text)
      throw table.error(row, fmt::format("the noise of {} is {} here and {} before; one level was expected",
                                         in_quotes(id), in_quotes(text), in_quotes(known->second)));
    if (!is_new) return;
    if (number) settings_.noise[output] = *number;
    if (parameter == nullptr) return;
    if (parameter->estimated && !parameter->prior.empty())
      throw InputError(
          problem_.file.parameters.front().string(), parameter->line,
          fmt::format("{} is a noise level, which is estimated without a prior; {} is not understood",
                      in_quotes(parameter->id), in_quotes(parameter->prior)));
    if (parameter->estimated) settings_.estimated_noise[output] = parameter->id;
    parameter->noise_of = output;
  }

  /// An attitude is compared by its turn, which is twice as far as its four numbers go: they have one noise.
  void set_attitude_noise() {
    const auto has_level = [&](const std::string& part) { return settings_.noise.contains(part); };
    if (!std::ranges::all_of(kQuaternionChannels, has_level)) return;
    const std::string& first = kQuaternionChannels.front();
    const double level = settings_.noise.at(first);
    for (const std::string& part : kQuaternionChannels) {
      if (settings_.noise.at(part) == level) continue;
      const std::string& id = problem_.observables.at(part);
      throw InputError(problem_.file.observables.front().string(), noise_formula_.at(id).line,
                       fmt::format("the noise of {} is {}, that of {} {}; one level of the four numbers of "
                                   "an attitude was expected",
                                   in_quotes(id), settings_.noise.at(part),
                                   in_quotes(problem_.observables.at(first)), level));
    }
    settings_.attitude_noise = 2.0 * level;
    for (const std::string& part : kQuaternionChannels) settings_.noise.erase(part);
  }

  void read_measurements(const std::filesystem::path& path) {
    const DelimitedTable table =
        read_tsv(path, {"observableId", "simulationConditionId", "measurement", "time"});
    const auto observables = table.texts("observableId"), conditions = table.texts("simulationConditionId");
    const auto before = cells_or_empty(table, "preequilibrationConditionId"),
               parameters = cells_or_empty(table, "observableParameters"),
               noises = cells_or_empty(table, "noiseParameters"),
               replicates = cells_or_empty(table, "replicateId");
    const Eigen::VectorXd values = table.numbers("measurement"), times = table.numbers("time");
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const auto at = static_cast<Eigen::Index>(row);
      if (!output_of_.contains(observables[row]))
        throw table.error(row, fmt::format("there is no observable {}", in_quotes(observables[row])));
      if (!before[row].empty())
        throw table.error(row, "preequilibration is not understood: fits begin at time 0");
      if (!parameters[row].empty())
        throw table.error(row,
                          "observableParameters are not understood: an observable is an output as it is");
      if (!(times[at] >= 0.0 && times[at] <= kLargestInput))
        throw table.error(row, fmt::format("the time is {}; 0 to {} was expected", times[at], kLargestInput));
      take_noise(table, row, observables[row], noises[row]);
      const std::pair key{conditions[row], replicates[row]};
      if (std::isnan(values[at])) {
        if (!table.is_empty(row, "measurement")) ++words_[key];
        continue;
      }
      if (std::abs(values[at]) > kLargestInput)
        throw table.error(row, fmt::format("the measurement is {}; at most {} in size was expected",
                                           values[at], kLargestInput));
      if (!series_.contains(key)) order_.push_back(key);
      Series& series = series_.try_emplace(key, Series{.file = path}).first->second;
      const std::string& output = output_of_.at(observables[row]);
      // A measurement that stands again at the same time is of another replicate.
      const auto place = std::ranges::find_if(series.replicates, [&](const Rows& rows) {
        const auto frame = rows.find(times[at]);
        return frame == rows.end() || !frame->second.contains(output);
      });
      Rows& rows = place == series.replicates.end() ? series.replicates.emplace_back() : *place;
      rows[times[at]][output] = values[at];
    }
  }

  /// Rows of a condition may stand in several files, an observable in each.
  void add_captures() {
    for (const Key& key : order_) {
      const std::size_t first = problem_.captures.size();
      const Series& series = series_.at(key);
      for (const Rows& rows : series.replicates) add_capture(series.file, key.first, rows);
      if (const auto count = words_.find(key); count != words_.end())
        problem_.captures[first].notes.push_back(
            fmt::format("{} cells with NaN or NA count as not seen", count->second));
    }
  }

  void add_capture(const std::filesystem::path& path, const std::string& condition, const Rows& rows) {
    Capture capture;
    const std::size_t number = captures_of_[condition].size();
    capture.id = number == 0 ? condition : fmt::format("{} ({})", condition, number + 1);
    capture.file = path.string();
    capture.labels[kPetabCondition] = condition;
    capture.times.resize(std::ssize(rows));
    std::map<std::string, Eigen::VectorXd> columns;
    Eigen::Index frame = 0;
    for (const auto& [time, values] : rows) {
      capture.times[frame] = time;
      for (const auto& [output, value] : values) {
        auto& column = columns.try_emplace(output, Eigen::VectorXd::Constant(std::ssize(rows), std::nan("")))
                           .first->second;
        column[frame] = value;
      }
      ++frame;
    }
    // Every capture has every output: one that was not seen is missing throughout.
    for (const auto& [output, id] : problem_.observables) {
      const auto column = columns.find(output);
      capture.channels.push_back({output, names_.outputs.at(output),
                                  column == columns.end()
                                      ? Eigen::VectorXd::Constant(std::ssize(rows), std::nan(""))
                                      : column->second});
    }
    captures_of_[condition].push_back(problem_.captures.size());
    problem_.captures.push_back(std::move(capture));
  }

  void read_conditions(const std::filesystem::path& path) {
    const DelimitedTable table = read_tsv(path, {"conditionId"});
    const auto ids = table.texts("conditionId");
    for (std::size_t row = 0; row < table.rows(); ++row) {
      if (!conditions_.insert(ids[row]).second)
        throw table.error(row, fmt::format("the condition {} stands there twice", in_quotes(ids[row])));
    }
    for (const std::string& column : table.header()) {
      if (column == "conditionId" || column == "conditionName") continue;
      const std::string name = coordinate_named(column);
      if (name.empty())
        throw InputError(table.file(), table.line_of_header(),
                         fmt::format("the column {} is no parameter of the model, and none of its states",
                                     in_quotes(column)));
      const auto cells = table.texts(column);
      for (std::size_t row = 0; row < table.rows(); ++row) {
        if (const auto number = number_in(cells[row])) in_size(table, row, name, *number);
        set_in_conditions_[name][ids[row]] = {cells[row], table.line_of_row(row)};
      }
    }
  }

  /// A parameter by its name, a state by its initial value; empty if there is none.
  std::string coordinate_named(const std::string& id) const {
    if (names_.coordinates.contains(id)) return id;
    if (names_.coordinates.contains(id + "(0)")) return id + "(0)";
    if (id.ends_with("_0") && names_.coordinates.contains(id.substr(0, id.size() - 2) + "(0)"))
      return id.substr(0, id.size() - 2) + "(0)";
    return "";
  }

  /// What conditions set, for those that were measured: held alike in all, known of each, or estimated.
  void bind_conditions() {
    for (const auto& [name, cells] : set_in_conditions_) {
      std::map<std::string, double> numbers;
      std::map<std::string, PetabParameter*> estimated;
      int line = 0;
      for (const auto& [condition, captures] : captures_of_) {
        const auto cell = cells.find(condition);
        if (cell == cells.end() || cell->second.text.empty()) continue;
        line = cell->second.line;
        PetabParameter* const parameter = find(cell->second.text);
        const auto number =
            parameter != nullptr && !parameter->estimated ? parameter->nominal : number_in(cell->second.text);
        if (number) {
          numbers[condition] = *number;
        } else if (parameter != nullptr) {
          estimated[condition] = parameter;
        } else {
          throw condition_error(line, fmt::format("{} is {}; a number or a parameter was expected", name,
                                                  in_quotes(cell->second.text)));
        }
      }
      if (numbers.empty() && estimated.empty()) continue;
      if (std::max(numbers.size(), estimated.size()) < captures_of_.size())
        throw condition_error(
            line,
            fmt::format("{} is a number in some conditions, and estimated or not told of in others", name));
      numbers.empty() ? bind_estimated(name, estimated, line) : bind_numbers(name, numbers);
    }
  }

  InputError condition_error(int line, const std::string& sentence) const {
    return InputError(problem_.file.conditions.front().string(), line, sentence);
  }

  void bind_numbers(const std::string& name, const std::map<std::string, double>& numbers) {
    const double first = numbers.begin()->second;
    if (std::ranges::all_of(numbers, [&](const auto& entry) { return entry.second == first; })) {
      settings_.held[name] = first;
      return;
    }
    auto& interval = settings_.known[name];
    interval = {first, first};
    for (const auto& [condition, value] : numbers) {
      interval.lower = std::min(interval.lower, value);
      interval.upper = std::max(interval.upper, value);
      for (const std::size_t capture : captures_of_.at(condition))
        problem_.captures[capture].labels[name] = fmt::format("{}", value);
    }
  }

  void bind_estimated(const std::string& name, const std::map<std::string, PetabParameter*>& estimated,
                      int line) {
    PetabParameter* const first = estimated.begin()->second;
    if (std::ranges::all_of(estimated, [&](const auto& entry) { return entry.second == first; }))
      return bind(*first, name, "");
    std::set<PetabParameter*> all;
    for (const auto& [condition, parameter] : estimated) {
      const bool is_alone = all.insert(parameter).second && captures_of_.at(condition).size() == 1;
      if (!is_alone)
        throw condition_error(
            line, fmt::format("{} has a value of its own in each condition, but {} is of several captures",
                              name, in_quotes(parameter->id)));
      if (parameter->lower != first->lower || parameter->upper != first->upper ||
          parameter->prior != first->prior || parameter->prior_numbers != first->prior_numbers)
        throw condition_error(
            line, fmt::format("{} is {} and {} in different conditions: bounds and priors that are the "
                              "same were expected",
                              name, in_quotes(first->id), in_quotes(parameter->id)));
      bind(*parameter, name, condition);
    }
  }

  void bind(PetabParameter& parameter, const std::string& name, const std::string& condition) {
    if (!parameter.coordinate.empty())
      throw InputError(problem_.file.parameters.front().string(), parameter.line,
                       fmt::format("{} stands for {} and for {}; one was expected", in_quotes(parameter.id),
                                   parameter.coordinate, name));
    parameter.coordinate = name;
    parameter.condition = condition;
  }

  bool is_bound(const std::string& name) const {
    return std::ranges::count(problem_.parameters, name, &PetabParameter::coordinate) > 0;
  }

  /// Parameters that no condition and no noise took, by their own names.
  void bind_parameters() {
    std::vector<std::string> known;
    for (const auto& [name, unit] : names_.coordinates) known.push_back(name);
    for (PetabParameter& p : problem_.parameters) {
      if (!p.coordinate.empty() || !p.noise_of.empty() || is_in_a_condition(p.id)) continue;
      const std::string name = coordinate_named(p.id);
      if (name.empty() || set_in_conditions_.contains(name) || is_bound(name))
        throw InputError(problem_.file.parameters.front().string(), p.line,
                         name.empty() ? fmt::format("{} is no parameter of the model, and no initial value{}",
                                                    in_quotes(p.id), suggestion(p.id, known))
                                      : fmt::format("{} is told of twice: once was expected", name));
      if (p.estimated) {
        p.coordinate = name;
      } else {
        settings_.held[name] = *p.nominal;
      }
    }
  }

  bool is_in_a_condition(const std::string& id) const {
    return std::ranges::any_of(set_in_conditions_, [&](const auto& column) {
      return std::ranges::any_of(column.second, [&](const auto& cell) { return cell.second.text == id; });
    });
  }

  PetabParameter* find(const std::string& id) {
    const auto found = std::ranges::find(problem_.parameters, id, &PetabParameter::id);
    return found == problem_.parameters.end() ? nullptr : &*found;
  }

  const ConfigNames& names_;
  PetabProblem problem_;
  PetabSettings settings_;
  std::map<std::string, std::string> output_of_, noise_text_;  ///< by observable
  std::map<std::string, Cell> noise_formula_;
  std::map<Key, Series> series_;
  std::vector<Key> order_;
  std::map<Key, int> words_;                                     ///< cells that say that nothing was seen
  std::map<std::string, std::vector<std::size_t>> captures_of_;  ///< of measured conditions
  std::set<std::string> conditions_;
  std::map<std::string, std::map<std::string, Cell>> set_in_conditions_;  ///< coordinate, condition
};

}  // namespace

PetabProblem read_petab(const std::filesystem::path& path, const ConfigNames& names,
                        const std::vector<std::string>& free) {
  return PetabTables(read_petab_file(path), names).read(free);
}

}  // namespace samara::identification
