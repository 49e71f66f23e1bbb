#pragma once

#include <memory>

#include "samara/models/interface/model.h"

/// The body of dissertation chapter 5 with the equations as printed there, which are wrong: for the tests
/// that show how, and as a law that only the tests know.
std::shared_ptr<const samara::models::Model> immersed_body_printed();
