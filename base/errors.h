#pragma once

#include <stdexcept>
#include <string>

/// The exceptions of Samara. They report mistakes of the caller, of a file, or of a query; each carries one
/// sentence that names the thing, its value, and what was expected. Numerical outcomes (a tolerance missed,
/// an iteration that stagnates) are never exceptions: they come back in the result, with a status.
namespace samara {

/// Base of the family.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The call was wrong: an unknown name, a size that does not match, a value outside its meaning, NaN.
class ArgumentError : public Error {
 public:
  using Error::Error;
};

/// A file (or the text of one) is missing, malformed, or says something impossible.
class InputError : public Error {
 public:
  /// @param file the path as the user gave it
  /// @param line line number from 1, or 0 where lines mean nothing (binary files)
  /// @param sentence what was found and what was expected
  InputError(const std::string& file, int line, const std::string& sentence);
  /// For a file as a whole.
  InputError(const std::string& file, const std::string& sentence) : InputError(file, 0, sentence) {}
};

/// A point outside the box of a codebook was asked for.
class OutsideBoxError : public Error {
 public:
  using Error::Error;
};

/// Work ended before there was any result to give: the sentence says why. (Where there is one, its status
/// says so instead.)
class NoResultError : public Error {
 public:
  using Error::Error;
};

}  // namespace samara
