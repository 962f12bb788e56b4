// risorius demo: the built-in performer over real sockets through the real daemon, with a live table and a dataset.
#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "replay/commands/commands.h"
#include "replay/commands/number_check.h"
#include "replay/commands/output_check.h"
#include "replay/live/daemon_client.h"
#include "replay/live/live_table.h"

namespace risorius {
namespace {

constexpr const char* kListen = "udp://127.0.0.1:7640";
constexpr const char* kPublish = "tcp://127.0.0.1:7641";
constexpr const char* kControl = "tcp://127.0.0.1:7642";

struct DemoArguments {
  std::string daemon = "risoriusd", output;
  double seconds = 20;
};

/// A child process that is ended and waited for with this object.
class Child {
 public:
  Child(std::string what, const std::vector<std::string>& command) : what_(std::move(what)) {
    std::vector<char*> words;
    for (const auto& word : command) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    id_ = fork();
    if (id_ == 0) {
      execvp(words[0], words.data());
      fmt::print(stderr, "risorius: cannot start {}\n", command[0]);
      _exit(127);
    }
    if (id_ < 0) throw UserError(what_, "cannot be started", "is the machine out of processes?");
  }
  ~Child() {
    if (id_ <= 0) return;
    kill(id_, SIGTERM);
    wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void interrupt() { kill(id_, SIGINT); }
  bool running() {
    if (id_ > 0 && waitpid(id_, &state_, WNOHANG) == id_) id_ = 0;
    return id_ > 0;
  }
  /// Waits for its end; throws if it did not end well.
  void wait_for_success() {
    wait();
    if (!WIFEXITED(state_) || WEXITSTATUS(state_) != 0)
      throw UserError(what_ + " ended with an error; its message stands above");
  }

 private:
  void wait() {
    if (id_ > 0) waitpid(id_, &state_, 0);
    id_ = 0;
  }
  std::string what_;
  pid_t id_ = 0;
  int state_ = 0;
};

std::filesystem::path write_config(const std::filesystem::path& folder, const std::filesystem::path& dataset) {
  const auto path = folder / "demo.toml";
  std::ofstream(path) << fmt::format(
      "[output]\npublish = \"{}\"\ncontrol = \"{}\"\nstatus_interval_s = 0.5\n"
      "[record]\nfolder = \"{}\"\npseudonym = \"synthetic performer\"\nlicence = \"MIT\"\n"
      "[[source]]\nname = \"face\"\nlisten = \"{}\"\nrig = \"builtin\"\n",
      kPublish, kControl, dataset.string(), kListen);
  return path;
}

void wait_until_ready(Child& daemon) {
  for (int attempt = 0; daemon.running(); ++attempt) {
    try {
      ask_daemon(kControl, {{"command", "status"}}, std::chrono::milliseconds(250));
      return;
    } catch (const UserError&) {
      if (attempt == 40) throw;
    }
  }
  daemon.wait_for_success();
}

void run_demo(const DemoArguments& arguments) {
  const std::filesystem::path folder =
      arguments.output.empty() ? fmt::format("build/demo/{:%Y%m%d-%H%M%S}", fmt::localtime(std::time(nullptr)))
                               : arguments.output;
  check_not_sealed(folder);
  std::filesystem::create_directories(folder);
  const auto dataset = folder / "dataset";
  const auto config = write_config(folder, dataset);
  fmt::print("The built-in performer, {:.0f} s at 120 Hz, 55 markers -> {} -> risoriusd -> {}\n\n", arguments.seconds,
             kListen, kPublish);
  std::fflush(stdout);

  Child daemon("risoriusd", {arguments.daemon, "--config", config.string()});
  wait_until_ready(daemon);
  DaemonSubscriber subscriber(kPublish);
  LiveTable table;
  subscriber.receive_for(std::chrono::milliseconds(200), table.view());  // let the subscription arrive
  Child sender("risorius replay", {std::filesystem::read_symlink("/proc/self/exe").string(), "replay", "--quiet",
                                   fmt::format("builtin:{}", arguments.seconds), "--to", kListen});
  while (sender.running() && daemon.running()) {
    subscriber.receive_for(std::chrono::milliseconds(100), table.view());
    table.redraw();
  }
  sender.wait_for_success();
  subscriber.receive_for(std::chrono::milliseconds(300), table.view());
  fmt::print("\n");
  std::fflush(stdout);
  daemon.interrupt();
  daemon.wait_for_success();
  fmt::print("\ndataset: {}\n  try: column -s, -t {}/face-001/episodes.csv | head\n", dataset.string(),
             dataset.string());
}

}  // namespace

void add_demo_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("demo", "stream the built-in take through the daemon and write a dataset");
  auto arguments = std::make_shared<DemoArguments>();
  command->add_option("--daemon", arguments->daemon, "the risoriusd program")->capture_default_str();
  command->add_option("--seconds", arguments->seconds, "length of the performance")
      ->check(number_between(1.0, 3600.0))
      ->capture_default_str();
  command->add_option("-o,--output", arguments->output, "folder to make (default: build/demo/DATE-TIME)");
  command->callback([arguments] { run_demo(*arguments); });
}

}  // namespace risorius
