#include "child.h"

#include <filesystem>
#include <stdexcept>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace samara::benchmarks::doors {

pid_t start_samara(const std::vector<std::string>& arguments) {
  const std::string command =
      std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "apps" / "samara";
  std::vector<char*> words = {const_cast<char*>("samara")};
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child > 0) return child;
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  execv(command.c_str(), words.data());
  _exit(127);
}

int wait_for(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace samara::benchmarks::doors
