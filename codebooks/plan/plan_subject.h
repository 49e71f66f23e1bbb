#pragma once

#include <map>
#include <memory>
#include <string>

#include "samara/codebooks/plan/plan.h"
#include "samara/io/toml_document.h"

/// Internal to codebooks/: what the names in a plan mean.
namespace samara::codebooks {

/// What a plan is about, a model, a field or a command: the names it may use, with their units.
struct PlanSubject {
  std::string name;  ///< for messages
  std::shared_ptr<const models::Model> model;
  std::string what_settable, what_output;       ///< what it calls them, for messages
  std::map<std::string, std::string> settable;  ///< what may be fixed or free
  std::map<std::string, std::string> outputs;
  std::string time_unit = "s";
  const models::FieldModel* field = nullptr;

  /// That of the model or the field; null of a command.
  const models::ModelInfo* info() const {
    return field != nullptr ? &field->info : model ? &model->info() : nullptr;
  }
};

PlanSubject subject_of(std::shared_ptr<const models::Model> model);
PlanSubject subject_of(const PlannedCommand& command);

/// The model or the field that a plan names, or brings along.
/// @throws InputError
PlanSubject read_subject(const io::TomlTable& root);

/// The unit of a name in a table.
/// @param what the subject calls such things, for the message
/// @throws InputError for a name that is not among `units`
const std::string& unit_of(const io::TomlTable& table, const std::string& key,
                           const std::map<std::string, std::string>& units, const PlanSubject& subject,
                           const std::string& what);

/// Initial values have no bounds of meaning.
/// @throws InputError for a value beyond those of its parameter
void check_meaning(const io::TomlTable& table, const std::string& key, const PlanSubject& subject,
                   double value);

}  // namespace samara::codebooks
