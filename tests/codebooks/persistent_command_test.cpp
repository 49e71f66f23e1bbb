#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <thread>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/base/errors.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/source/command_function.h"
#include "samara/codebooks/source/command_program.h"

// Programs that are kept between batches, good ones and nasty ones.

using namespace samara::codebooks;
using Catch::Matchers::Contains;

namespace {

Command kept(std::vector<std::string> run, double timeout = 20.0) {
  return {.run = std::move(run), .inputs = 2, .outputs = 1, .timeout = timeout, .persistent = true};
}

/// The shell, after it has read a batch: its number of points in $n, its lines no longer needed.
Command kept_shell(const std::string& then, double timeout = 20.0) {
  return kept(
      {"/bin/sh", "-c",
       "while read n; do i=0; while [ $i -lt $n ]; do read line; i=$((i+1)); done\n" + then + "\ndone"},
      timeout);
}

Command python(const std::string& program, std::vector<std::string> arguments = {}, double timeout = 20.0) {
  std::vector<std::string> run = {"python3", "-c", "import os, sys, time, random\n" + program};
  run.insert(run.end(), arguments.begin(), arguments.end());
  return kept(std::move(run), timeout);
}

/// The product of the inputs; every start is a line in the file named by the first argument.
const std::string kKeptProduct = R"(
print(os.getpid(), file=open(sys.argv[1], 'a'))
for head in sys.stdin:
    rows = [sys.stdin.readline().split() for _ in range(int(head))]
    print(*(repr(float(a) * float(b)) for a, b in rows), sep='\n', flush=True)
)";

Eigen::MatrixXd points_of(Eigen::Index count) {
  Eigen::MatrixXd points(2, count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const auto x = static_cast<double>(j);
    points.col(j) << std::sin(1.0 + x), 1e-7 * (x + 1.0) / 3.0;
  }
  return points;
}

std::string complaint(const samara::pgd::PointsFunction& function, Eigen::Index points = 3) {
  Eigen::MatrixXd values;
  return error_text<samara::Error>([&] { function(points_of(points), values); });
}

std::vector<int> numbers_in(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<int> numbers;
  for (int number = 0; in >> number;) numbers.push_back(number);
  return numbers;
}

bool is_gone(int process) {
  for (int i = 0; i < 400; ++i) {
    std::ifstream status("/proc/" + std::to_string(process) + "/stat");
    std::string number, name, state;
    // Killed, it is gone as soon as its new parent has looked.
    if (!(status >> number >> name >> state) || state == "Z" || kill(process, 0) != 0) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

}  // namespace

TEST_CASE("a program that is kept is started once, and answers to the last bit") {
  const TemporaryDirectory directory;
  const auto starts = directory / "starts";
  Command command = python(kKeptProduct, {starts.string()});
  command.largest_batch = 700;
  {
    const samara::pgd::PointsFunction function = command_function(command);
    const samara::pgd::PointsFunction copy = function;
    CHECK(numbers_in(starts).empty());  // not before it is needed
    for (const Eigen::Index count : {2000, 1, 5}) {
      const Eigen::MatrixXd points = points_of(count);
      Eigen::MatrixXd values;
      (count == 5 ? copy : function)(points, values);
      REQUIRE(values.cols() == count);
      CHECK(values.row(0) == points.row(0).cwiseProduct(points.row(1)));
    }
    REQUIRE(numbers_in(starts).size() == 1);
    CHECK(kill(numbers_in(starts)[0], 0) == 0);
  }
  CHECK(is_gone(numbers_in(starts)[0]));
}

TEST_CASE("a program that is kept is sampled like any function") {
  const TemporaryDirectory directory;
  const auto result = samara::pgd::sample(
      {{{"a"}, 1.0, 2.0}, {{"b"}, -1.0, 1.0}}, {{"product"}},
      command_function(python(kKeptProduct, {(directory / "s").string()})), {.tolerance = 1e-8});
  INFO(result.message);
  REQUIRE(result.tolerance_met());
  CHECK(std::abs((*result.field)(std::vector{1.5, -0.25})[0] + 0.375) < 1e-8);
  CHECK(numbers_in(directory / "s").size() == 1);
}

TEST_CASE("neither a program that answers while it reads nor one that reads first can block a large batch") {
  const std::string first_all = R"(
for head in sys.stdin:
    rows = [sys.stdin.readline().split() for _ in range(int(head))]
    for a, b in rows: print(float(a) * float(b))
    sys.stdout.flush()
)";
  const std::string line_by_line = R"(
for head in sys.stdin:
    for _ in range(int(head)):
        a, b = sys.stdin.readline().split()
        print(float(a) * float(b))
    sys.stdout.flush()
)";
  // Far more than pipes hold, and complaints as long.
  const std::string complaining = R"(
for head in sys.stdin:
    for _ in range(int(head)):
        a, b = sys.stdin.readline().split()
        print(float(a) * float(b), flush=True)
        print('careful' * 10, file=sys.stderr)
)";
  for (const std::string& program : {first_all, line_by_line, complaining}) {
    Command command = python(program, {}, 60.0);
    command.largest_batch = 30'000;
    const samara::pgd::PointsFunction function = command_function(command);
    const Eigen::MatrixXd points = points_of(30'000);
    Eigen::MatrixXd values;
    for (int i = 0; i < 2; ++i) {
      function(points, values);
      CHECK(values.row(0) == points.row(0).cwiseProduct(points.row(1)));
    }
  }
}

TEST_CASE("whatever a program that is kept does wrong is told") {
  const auto told = [](const Command& command) { return complaint(command_function(command)); };
  CHECK_THAT(told(kept_shell("echo gone >&2; exit 3")), Contains("ended with the code 3; it said \"gone\""));
  CHECK_THAT(told(kept_shell("echo 1; exit 0")), Contains("ended after 1 lines for 3 points"));
  CHECK_THAT(told(kept_shell("kill -TERM $$")), Contains("was ended by signal 15"));
  CHECK_THAT(told(kept({"/no/such/program"})), Contains("cannot be started: No such file"));
  CHECK_THAT(told(kept_shell("sleep 600", 0.3)),
             Contains("did not answer within 0.3 s and was killed after 0 lines"));
  CHECK_THAT(told(kept_shell("echo 1; echo 2", 0.3)), Contains("after 2 lines for 3 points"));
  CHECK_THAT(told(kept_shell("printf '1\\n2\\n3'", 0.3)),
             Contains("within 0.3 s"));  // no line yet: it may go on
  CHECK_THAT(told(kept_shell("printf '1\\n2\\n3\\n4\\n'")), Contains("printed 4 lines for 3 points"));
  CHECK_THAT(told(kept_shell("printf '1\\n2\\n3\\n4'")), Contains("printed 4 lines for 3 points"));
  CHECK_THAT(told(kept_shell("printf '1\\none\\n3\\n'")), Contains("printed \"one\", expected numbers"));
  CHECK_THAT(told(kept_shell("printf '1\\n2 2\\n3\\n'")), Contains("\"2 2\" with 2 numbers, expected 1"));
  CHECK_THAT(told(kept_shell("printf '\\001\\377\\n1\\n1\\n'")), Contains("printed \"\\x01\\xff\""));
  CHECK_THAT(told(kept_shell("trap '' PIPE; yes ''")), Contains("prints far more"));
  CHECK_THAT(told(kept_shell("exec >&-; sleep 600")),
             Contains("closed its output after 0 lines for 3 points"));
  CHECK_THAT(told(kept({"/bin/sh", "-c", "exec <&-; sleep 600"})), Contains("closed its input"));
  CHECK_THAT(told(kept({"/bin/sh", "-c", "exit 0"})), Contains("ended after 0 lines"));
  // One that is not made for it takes the number of points for a point, or waits for the end of its input.
  CHECK_THAT(told(kept({"awk", "{ print $1 * $2 }"}, 0.3)),
             Contains("must flush its output after every batch"));
}

TEST_CASE("what a program that is kept prints beyond its answers is told with the next batch") {
  const samara::pgd::PointsFunction function = command_function(
      kept_shell("i=0; while [ $i -lt $n ]; do echo 7; i=$((i+1)); done; sleep 0.1; echo 8"));
  CHECK(complaint(function) == "no exception");
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  CHECK_THAT(complaint(function), Contains("printed \"8\" before it was asked for the next points"));
  const samara::pgd::PointsFunction greeting =
      command_function(kept({"/bin/sh", "-c", "echo hello; while read n; do echo 1; done"}));
  CHECK_THAT(complaint(greeting, 1), Contains("\"hello\""));
}

TEST_CASE("empty lines, carriage returns and words on the standard error are no answers") {
  const samara::pgd::PointsFunction function = command_function(
      kept_shell("echo; i=0; while [ $i -lt $n ]; do printf '7\\r\\n\\n'; echo ok >&2; i=$((i+1)); done"));
  for (int i = 0; i < 3; ++i) CHECK(complaint(function, 4) == "no exception");
}

TEST_CASE("a program that is kept is killed with all that it started, when it fails and when it is done") {
  const TemporaryDirectory directory;
  const auto file = directory / "pids";
  const std::string start = "sleep 600 & echo $! >> " + file.string() + "; echo $$ >> " + file.string() + ";";
  CHECK_THAT(complaint(command_function(kept_shell(start + "sleep 600", 0.3))), Contains("did not answer"));
  REQUIRE(numbers_in(file).size() == 2);
  for (const int process : numbers_in(file)) CHECK(is_gone(process));
  // It leaves a process behind, and does not care for signals or the end of its input.
  const std::string stays = "trap '' TERM HUP INT PIPE; " + start +
                            "while read n; do for i in 1 2 3; do read line; echo 5; done; done; sleep 600";
  {
    const samara::pgd::PointsFunction function = command_function(kept({"/bin/sh", "-c", stays}));
    CHECK(complaint(function) == "no exception");
    REQUIRE(numbers_in(file).size() == 4);
    CHECK(kill(numbers_in(file)[2], 0) == 0);
  }
  for (const int process : numbers_in(file)) CHECK(is_gone(process));
}

TEST_CASE("a program that is kept is told the end of its input and may tidy up") {
  const TemporaryDirectory directory;
  const auto file = directory / "tidy";
  const std::string script =
      "while read n; do for i in 1 2 3; do read line; echo 5; done; done; echo 1 > " + file.string();
  CHECK(complaint(command_function(kept({"/bin/sh", "-c", script}))) == "no exception");
  CHECK(numbers_in(file) == std::vector<int>{1});
}

TEST_CASE("a program that fails at a point is started again to find it, and what there was before is kept") {
  const TemporaryDirectory directory;
  const std::string program = R"(
print(os.getpid(), file=open(sys.argv[1], 'a'))
for head in sys.stdin:
    rows = [float(sys.stdin.readline().split()[0]) for _ in range(int(head))]
    if max(rows) > 0.97: sys.exit('too large')
    print(*rows, sep='\n', flush=True)
)";
  const auto result = samara::pgd::sample({{{"a"}, 0.0, 1.0}, {{"b"}, 0.0, 1.0}}, {{"f"}},
                                          command_function(python(program, {(directory / "s").string()})));
  CHECK(result.status == samara::Termination::failed);
  REQUIRE(result.bad_point.size() == 2);
  CHECK(result.bad_point[0] > 0.97);
  CHECK_THAT(result.message, Contains("ended with the code 1; it said \"too large\""));
  CHECK(numbers_in(directory / "s").size() == 2);
  for (const int process : numbers_in(directory / "s")) CHECK(is_gone(process));
}

TEST_CASE("numbers that a program prints after its last answer make all its answers doubtful") {
  const auto ended_with = [](const std::string& word) {
    CommandProgram program(kept({"/bin/sh", "-c", "while read n; do read row; echo 1; done; echo " + word}));
    CHECK(program.answers(Eigen::MatrixXd::Zero(1, 1), 1)(0, 0) == 1.0);
    return error_text<samara::Error>([&] { program.finish(); });
  };
  CHECK(ended_with("bye") == "no exception");
  CHECK(ended_with("") == "no exception");
  CHECK_THAT(ended_with("7.5"), Contains("printed \"7.5\" after its last answer"));
  // A build that such a program has answered has no result.
  const Plan plan = parse_plan(
      "[command]\nrun = ['python3', '-c', \"\"\"import sys\nfor head in sys.stdin:\n  for _ in "
      "range(int(head)): "
      "print(sys.stdin.readline().strip())\n  sys.stdout.flush()\nprint(3)\"\"\"]\ninputs = { a = '1' }\n"
      "outputs = { p = '1' }\npersistent = true\n[box]\na = [1, 2]\n[tolerance]\nassurance = 0.9\n",
      "p.toml");
  CHECK_THAT(error_text<samara::NoResultError>([&] { build(plan); }), Contains("after its last answer"));
}

TEST_CASE("a build keeps one program from its pilots to its certificate, and ends it when it is cancelled") {
  const std::string program = R"(
import math, os, sys
print(os.getpid(), file=open(sys.argv[1], 'a'))
for head in sys.stdin:
    for _ in range(int(head)):
        a, *times = map(float, sys.stdin.readline().split())
        print(*(repr(math.exp(-a * t)) for t in times))
    sys.stdout.flush()
)";
  const TemporaryDirectory directory;
  for (const std::string stage : {"", "pilots", "sampling", "certificate"}) {
    const auto starts = directory / ("starts" + stage);
    const Plan plan =
        parse_plan("[command]\nrun = ['python3', '-c', \"\"\"" + program + "\"\"\", '" + starts.string() +
                       "']\ninputs = { a = '1/s' }\noutputs = { p = '1' }\npersistent = true\n"
                       "[box]\na = [1, 2]\n[time]\nend = 1\n[tolerance]\nrelative = 1e-5\n",
                   "p.toml");
    BuildOptions options;
    options.progress = [&](const samara::Progress& report) { return report.stage != stage; };
    INFO("cancelled in stage \"" << stage << '"');
    try {
      const BuildResult result = build(plan, options);
      CHECK(result.met == stage.empty());
    } catch (const samara::NoResultError&) {
      CHECK(stage != "");
    }
    const std::vector<int> processes = numbers_in(starts);
    CHECK(processes.size() == (stage == "pilots" ? 0 : 1));  // which is asked before the first call
    for (const int process : processes) CHECK(is_gone(process));
  }
}

TEST_CASE("threads that call one program wait for each other") {
  const TemporaryDirectory directory;
  const samara::pgd::PointsFunction function =
      command_function(python(kKeptProduct, {(directory / "s").string()}));
  const Eigen::MatrixXd points = points_of(50);
  std::vector<int> right(4, 0);
  {
    std::vector<std::jthread> threads;
    for (int& count : right) {
      threads.emplace_back([&] {
        Eigen::MatrixXd values;
        for (int i = 0; i < 20; ++i) {
          function(points, values);
          count += values.row(0) == points.row(0).cwiseProduct(points.row(1)) ? 1 : 0;
        }
      });
    }
  }
  CHECK(right == std::vector<int>(4, 20));
  CHECK(numbers_in(directory / "s").size() == 1);
}

TEST_CASE(
    "programs that misbehave at random are answered by right values or one sentence, and never by silence") {
  // Each start does a few batches right and then something else; what, follows from its seed and the count of
  // starts.
  const std::string program = R"(
import signal, subprocess
seed, starts = sys.argv[1], sys.argv[2]
print(os.getpid(), file=open(starts, 'a'))
random.seed(seed + str(len(open(starts).readlines())))
good = random.randrange(4)
def die(): sys.exit(random.randrange(3))
def crash(): os.kill(os.getpid(), signal.SIGSEGV)
def hang(): time.sleep(600)
def stubborn():
    for s in (signal.SIGPIPE, signal.SIGTERM, signal.SIGINT): signal.signal(s, signal.SIG_IGN)
    while True: time.sleep(600)
def short(): print(*answers[:-1], sep='\n', flush=True); hang()
def long(): os.write(1, ('\n'.join(answers) + '\n3\n').encode()); hang()
def rubbish(): print(*answers[:-1], 'no', sep='\n', flush=True)
def binary(): os.write(1, os.urandom(200))
def flood(): os.write(1, b'\n' * 10**6); hang()
def cut(): os.write(1, '\n'.join(answers)[:-1].encode()); die()
def deaf(): os.close(0); hang()
def mute(): os.close(1); hang()
def orphan(): subprocess.Popen(['sleep', '600']); die()
def noise(): os.write(2, b'x' * 10**6); die()
for head in sys.stdin:
    rows = [sys.stdin.readline().split() for _ in range(int(head))]
    answers = [repr(float(a) * float(b)) for a, b in rows]
    if good == 0: random.choice([die, crash, hang, stubborn, short, long, rubbish, binary, flood, cut, deaf, mute, orphan, noise])()
    good -= 1
    print(*answers, sep='\n', flush=True)
)";
  const TemporaryDirectory directory;
  for (const std::string seed : {"1", "2", "3", "4"}) {
    const auto starts = directory / ("starts" + seed);
    int right = 0, told = 0;
    {
      const samara::pgd::PointsFunction function =
          command_function(python(program, {seed, starts.string()}, 2.0));
      for (int call = 0; call < 25; ++call) {
        const Eigen::MatrixXd points = points_of(1 + call * call);
        Eigen::MatrixXd values;
        const std::string text = error_text<samara::Error>([&] { function(points, values); });
        if (text == "no exception") {
          ++right;
          CHECK(values.row(0) == points.row(0).cwiseProduct(points.row(1)));
        } else {
          ++told;
          CHECK_THAT(text, Contains("the command \"python3\" "));
        }
      }
    }
    CHECK(right > 5);
    CHECK(told > 5);
    for (const int process : numbers_in(starts)) CHECK(is_gone(process));
  }
}
