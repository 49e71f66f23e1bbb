#pragma once

#include <string>
#include <vector>

#include "samara/pgd/sampling/sampling.h"

/// A program as a function. For every batch of points it is started once, gets a line per point on its
/// standard input, the inputs in order with spaces between, and prints a line per point on its standard
/// output: the outputs in order, with spaces, tabs or commas between. Numbers have as many digits as they
/// need. Then it exits with 0.
///
/// One that is kept (`persistent`) is started once. Every batch begins with a line that holds its number of
/// points; the program answers that many lines, flushes its output and waits for the next batch. The end of
/// its input is its end.
///
/// Usage:
///   const PointsFunction drag =
///       command_function({.run = {"python3", "solver.py"}, .inputs = 2, .outputs = 1});
///   const SamplingResult result = pgd::sample(coordinates, outputs, drag);
namespace samara::codebooks {

struct Command {
  std::vector<std::string> run;  ///< program, looked for in PATH, and its arguments; no shell reads them
  int inputs = 1;
  int outputs = 1;
  /// s, for a batch; then the program and all that it started (its process group) are killed.
  double timeout = 60.0;
  int largest_batch = 1000;  ///< points
  /// Whether the program is kept between batches. Copies of the function share it; with the last of them it
  /// is told the end of its input, has two seconds to end by itself, and is killed with all that it started.
  bool persistent = false;
};

/// The function throws Error, with the program's name and the end of what it wrote on the standard error, if it
/// cannot be started, hangs, fails, is killed, or prints another number of lines or numbers, or what is no
/// number. Nothing of such a batch is used, and a program that was kept is killed: the next call starts it
/// again. Calls from several threads wait for each other.
/// @throws ArgumentError for an empty command, or a number that is not positive.
pgd::PointsFunction command_function(Command command);

}  // namespace samara::codebooks
