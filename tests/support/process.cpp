#include "support/process.h"

#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <poll.h>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

namespace risorius::test {
namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

std::filesystem::path program(const std::string& name) {
  return std::filesystem::path(RISORIUS_BINARY_DIR) / "bin" / name;
}

Process::Process(const std::vector<std::string>& command) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  std::vector<char*> words;
  for (const auto& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  id_ = fork();
  if (id_ == 0) {
    dup2(ends[1], STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    execvp(words[0], words.data());
    _exit(127);
  }
  close(ends[1]);
  pipe_ = ends[0];
  if (id_ < 0) throw std::runtime_error("cannot start " + command[0]);
}

Process::~Process() {
  if (id_ > 0) {
    kill(id_, SIGKILL);
    waitpid(id_, nullptr, 0);
  }
  close(pipe_);
}

bool Process::read_some(double seconds) {
  pollfd readable{pipe_, POLLIN, 0};
  if (poll(&readable, 1, static_cast<int>(seconds * 1000)) <= 0) return true;
  char bytes[4096];
  const ssize_t count = read(pipe_, bytes, sizeof bytes);
  if (count <= 0) return false;
  output_.append(bytes, static_cast<std::size_t>(count));
  return true;
}

bool Process::wait_for_output(const std::string& text, double seconds) {
  const auto begin = std::chrono::steady_clock::now();
  while (output_.find(text) == std::string::npos) {
    if (seconds_since(begin) > seconds || !read_some(0.1)) return output_.find(text) != std::string::npos;
  }
  return true;
}

void Process::send_signal(int signal) { kill(id_, signal); }

Finished Process::finish(double seconds) {
  const auto begin = std::chrono::steady_clock::now();
  while (read_some(0.1)) {
    if (seconds_since(begin) > seconds) {
      output_ += "\n(ended by the test: it ran too long)\n";
      kill(id_, SIGKILL);
      break;
    }
  }
  int state = 0;
  waitpid(id_, &state, 0);
  id_ = 0;
  return {WIFEXITED(state) ? WEXITSTATUS(state) : -1, output_};
}

Finished run(const std::vector<std::string>& command, double seconds) { return Process(command).finish(seconds); }

}  // namespace risorius::test
