// Runs a program as a user would: its own process, its output, its exit status.
#pragma once

#include <filesystem>
#include <string>
#include <sys/types.h>
#include <vector>

namespace risorius::test {

struct Finished {
  int exit_code = -1;  ///< -1 if it was ended by a signal
  std::string output;  ///< stdout and stderr together
};

/// build/bin/NAME
std::filesystem::path program(const std::string& name);

class Process {
 public:
  explicit Process(const std::vector<std::string>& command);
  /// Ends it with SIGKILL if it still runs.
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Reads output until it contains `text`; false if the process ended or `seconds` passed without.
  bool wait_for_output(const std::string& text, double seconds);
  void send_signal(int signal);
  pid_t id() const noexcept { return id_; }
  /// Waits for its end (at most `seconds`, then SIGKILL).
  Finished finish(double seconds = 60);
  const std::string& output() const noexcept { return output_; }

 private:
  bool read_some(double seconds);
  pid_t id_ = 0;
  int pipe_ = -1;
  std::string output_;
};

/// Runs to the end.
Finished run(const std::vector<std::string>& command, double seconds = 120);

}  // namespace risorius::test
