#include "samara/codebooks/source/command_function.h"

#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <thread>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/base/errors.h"

// Programs in the language of the shell and awk.

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

Command shell(const std::string& script, int inputs = 2, int outputs = 1, double timeout = 20.0) {
  return {.run = {"/bin/sh", "-c", script}, .inputs = inputs, .outputs = outputs, .timeout = timeout};
}

const std::string kProduct = "awk '{ printf \"%.17g %.17g\\n\", $1 * $2, $1 + $2 }'";

/// What is said about a command at three points.
std::string complaint(const Command& command) {
  Eigen::MatrixXd values;
  const Eigen::MatrixXd points = Eigen::MatrixXd::Constant(command.inputs, 3, 0.5);
  return error_text<samara::Error>([&] { command_function(command)(points, values); });
}

}  // namespace

TEST_CASE("a command gets a line per point and answers with a line per point, to the last bit") {
  Command command = shell(kProduct, 2, 2);
  command.largest_batch = 700;
  Eigen::MatrixXd points(2, 2000), values;
  for (int j = 0; j < points.cols(); ++j) points.col(j) << std::sin(1.0 + j), 1e-7 * (j + 1) / 3.0;
  command_function(command)(points, values);
  REQUIRE(values.rows() == 2);
  REQUIRE(values.cols() == 2000);
  CHECK(values.row(0) == points.row(0).cwiseProduct(points.row(1)));
  CHECK(values.row(1) == points.row(0) + points.row(1));
}

TEST_CASE("a command is sampled like any function") {
  const auto result = samara::pgd::sample({{{"a"}, 1.0, 2.0}, {{"b"}, -1.0, 1.0}}, {{"product"}, {"sum"}},
                                          command_function(shell(kProduct, 2, 2)), {.tolerance = 1e-8});
  INFO(result.message);
  REQUIRE(result.tolerance_met());
  const Eigen::VectorXd value = (*result.field)(std::vector{1.5, -0.25});
  CHECK(std::abs(value[0] + 0.375) < 1e-8);
  CHECK(std::abs(value[1] - 1.25) < 1e-8);
}

TEST_CASE("a command that fails is quoted with its code and its last words") {
  CHECK_THAT(complaint(shell("echo first >&2; echo 'no licence' >&2; exit 3")),
             StartsWith("the command \"/bin/sh\" ended with the code 3; it said \"no licence\""));
  CHECK_THAT(complaint(shell("kill -TERM $$")), Contains("was ended by signal 15"));
  CHECK_THAT(complaint({.run = {"/no/such/program"}, .inputs = 2}),
             StartsWith("the command \"/no/such/program\" cannot be started: No such file"));
  // It may end without reading a word: no signal of a broken pipe reaches us, however long the input.
  Eigen::MatrixXd values;
  const Eigen::MatrixXd many = Eigen::MatrixXd::Constant(2, 1000, 1.0 / 3.0);
  CHECK_THAT(error_text<samara::Error>([&] { command_function(shell("exit 1"))(many, values); }),
             Contains("ended with the code 1"));
}

TEST_CASE("a command that hangs is killed with all that it started") {
  const TemporaryDirectory directory;
  const auto file = directory / "pid";
  const std::string script = "sleep 600 & echo $! > " + file.string() + "; cat > /dev/null; wait";
  CHECK_THAT(complaint(shell(script, 2, 1, 0.5)), Contains("did not end within 0.5 s and was killed"));
  // One that closes its output and goes on hangs as well.
  CHECK_THAT(complaint(shell("exec >&- 2>&-; sleep 600", 2, 1, 0.3)), Contains("did not end within 0.3 s"));
  pid_t sleeper = 0;
  std::ifstream(file) >> sleeper;
  REQUIRE(sleeper > 0);
  // Killed, it is gone as soon as its new parent has looked.
  bool is_gone = false;
  for (int i = 0; i < 200 && !is_gone; ++i) {
    std::ifstream status("/proc/" + std::to_string(sleeper) + "/stat");
    std::string number, name, state;
    is_gone = !(status >> number >> name >> state) || state == "Z" || kill(sleeper, 0) != 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(is_gone);
}

TEST_CASE("wrong numbers of lines or of numbers, and what is no number, are told") {
  CHECK_THAT(complaint(shell("echo 1; echo 2")), Contains("printed 2 lines for 3 points"));
  CHECK_THAT(complaint(shell("for i in 1 2 3 4; do echo 1; done")), Contains("printed 4 lines for 3 points"));
  CHECK_THAT(complaint(shell("cat > /dev/null")), Contains("printed 0 lines for 3 points"));
  CHECK_THAT(complaint(shell("for i in 1 2 3; do echo 1 2; done")),
             Contains("printed the line \"1 2\" with 2 numbers, expected 1"));
  CHECK_THAT(complaint(shell("for i in 1 2 3; do echo one; done")),
             Contains("printed \"one\", expected numbers"));
  CHECK_THAT(complaint(shell("for i in 1 2 3; do echo 1.5x; done")), Contains("printed \"1.5x\""));
  CHECK_THAT(complaint(shell("printf '\\001\\377\\n1\\n1\\n'")), Contains("printed \"\\x01\\xff\""));
  CHECK_THAT(complaint(shell("yes 1")), Contains("prints far more than the 1 outputs of every point"));
}

TEST_CASE("a command that fails at a point ends a sampling there, and what there was before is kept") {
  const auto result = samara::pgd::sample(
      {{{"a"}, 0.0, 1.0}, {{"b"}, 0.0, 1.0}}, {{"f"}},
      command_function(
          shell("awk '$1 > 0.97 { print \"too large\" > \"/dev/stderr\"; exit 4 } { print $1 }'")));
  CHECK(result.status == samara::Termination::failed);
  REQUIRE(result.bad_point.size() == 2);
  CHECK(result.bad_point[0] > 0.97);
  CHECK_THAT(result.message, Contains("ended with the code 4; it said \"too large\""));
}

TEST_CASE("a command without words or with numbers that are not positive is refused") {
  CHECK_THROWS_AS(command_function({}), samara::ArgumentError);
  CHECK_THROWS_AS(command_function({.run = {""}}), samara::ArgumentError);
  CHECK_THAT(complaint(shell("cat", 0)), Contains("inputs is 0; at least 1"));
  CHECK_THAT(complaint(shell("cat", 1, 0)), Contains("outputs is 0; at least 1"));
  CHECK_THAT(complaint(shell("cat", 1, 1, 0.0)), Contains("timeout [s] is 0; a positive"));
  CHECK_THAT(complaint(shell("cat", 1)), StartsWith("no exception"));
  Eigen::MatrixXd values;
  CHECK_THROWS_AS(command_function(shell("cat", 2))(Eigen::MatrixXd::Zero(3, 1), values),
                  samara::ArgumentError);
}
