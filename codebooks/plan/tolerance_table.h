#pragma once

#include <string>

#include "samara/codebooks/plan/plan.h"
#include "samara/codebooks/plan/plan_subject.h"
#include "samara/io/toml_document.h"

/// Internal to codebooks/: the keys of the table [tolerance], read, checked and written.
namespace samara::codebooks {

/// @throws InputError with file and line
void read_tolerance(const io::TomlTable& root, const PlanSubject& subject, Plan& plan);

/// A command may be called no more often for the certificate than for the build, whose table has been read.
/// @throws InputError with file and line
void check_assurance_is_allowed(const io::TomlTable& root, const Plan& plan);

std::string tolerance_text(const BuildRequest& request);

}  // namespace samara::codebooks
