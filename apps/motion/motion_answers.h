#pragma once

#include <string>
#include <vector>

#include "samara/models/interface/parametric_model.h"
#include "samara/motion/patterns/agreement.h"
#include "samara/motion/sweeps/sweep.h"
#include "terminal/output.h"

/// What the commands sweep, patterns and regime say of motions.
namespace samara::apps {

/// "10 deg about 35 deg", or "its own".
std::string release_text(const motion::Sweep& sweep, Eigen::Index release);

/// Falls per pattern, a row for each release.
std::string sweep_counts(const motion::Sweep& sweep);
Json sweep_json(const motion::Sweep& sweep);

/// Rows first, with names of rows and columns; columns without any entry are left out.
std::string confusion_table(const Eigen::MatrixXi& counts, const std::vector<std::string>& rows,
                            const std::vector<std::string>& columns);
Json to_json(const motion::Agreement& agreement);

/// The thresholds of the rule, over several lines.
std::string thresholds_text(const motion::PatternThresholds& thresholds);
Json thresholds_json(const motion::PatternThresholds& thresholds);

/// A body by its model and the values that were set, all others as the model has them.
/// @throws ArgumentError, InputError for what is no model, an unknown name, or a value outside its meaning
models::ParametricModel body_of(const std::string& model, const std::vector<std::string>& set);

/// Number, or null where it is not known.
Json number_or_null(double value);

}  // namespace samara::apps
