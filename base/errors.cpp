#include "samara/base/errors.h"

#include "samara/base/names.h"

namespace samara {

namespace {
std::string located(const std::string& file, int line, const std::string& sentence) {
  // Names and sentences may quote what stands in a file.
  return printable(line > 0 ? file + ":" + std::to_string(line) + ": " + sentence : file + ": " + sentence);
}
}  // namespace

InputError::InputError(const std::string& file, int line, const std::string& sentence)
    : Error(located(file, line, sentence)) {}

}  // namespace samara
