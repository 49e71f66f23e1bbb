#pragma once

#include <string>

#include "samara/base/errors.h"

/// What an expected error says; where there was none, or one of another kind, the text says that instead.
template <typename Expected, typename Call>
std::string error_text(const Call& call) {
  try {
    call();
  } catch (const Expected& error) {
    return error.what();
  } catch (const std::exception& error) {
    return std::string("an exception of another kind: ") + error.what();
  }
  return "no exception";
}
