#include "terminal/interrupts.h"

#include <atomic>
#include <csignal>

#include <unistd.h>

#include "terminal/terminal.h"

namespace samara::apps {

namespace {

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a handler may not wait");

void remember(int signal) {
  interrupted.store(true);
  std::signal(signal, SIG_DFL);
}

void end_at_once(int /*signal*/) {
  constexpr char kSentence[] = "\nsamara: interrupted\n";
  // What stderr does not take is lost.
  [[maybe_unused]] const auto written = write(STDERR_FILENO, kSentence, sizeof kSentence - 1);
  _exit(kInterrupted);
}

void handle_interrupts(void (*handler)(int)) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM}) {
    struct sigaction before = {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);  // as nohup has it
  }
}

}  // namespace

void end_when_interrupted() {
  handle_interrupts(end_at_once);
}

void catch_interrupts() {
  handle_interrupts(remember);
}

bool is_interrupted() {
  return interrupted.load();
}

}  // namespace samara::apps
