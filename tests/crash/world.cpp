// SPDX-License-Identifier: Apache-2.0
#include "world.hpp"

#include "verified.hpp"

#include <handover/common/random.hpp>

#include <signal.h>

#include <algorithm>
#include <fstream>
#include <thread>

namespace handover::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

const std::string kBin = HANDOVER_BINARY_DIR "/bin/";
constexpr auto kLook = 5ms;  // at each client, one after the other

// Of a client: for a daemon to show up or come back, and to be answered.
constexpr int kWaitS = 20, kDeadlineS = 10;
/// Beyond its own time, on a busy machine; and the most that it is stopped.
constexpr auto kProgram = 20s;

/// Lines without room for cached files: whoever writes one is told so.
const std::string kOnFullDisk = "trap '' XFSZ; ulimit -f 0; exec \"$@\"";

class Daemon {
 public:
  Daemon(std::string cell, int domain) : cell_(std::move(cell)), domain_(domain) {
    fs::copy(HANDOVER_BINARY_DIR "/test-cache/handover", folder_ / "handover",
             fs::copy_options::recursive);
    stepClock(0);
    start(false);
  }

  void start(bool on_full_disk) {
    std::vector<std::string> command;
    if (on_full_disk) command = {"/bin/sh", "-c", kOnFullDisk, "sh"};
    for (const std::string& word :
         words(kBin + "handoverd serve --cell " + cell_ + " --root " HANDOVER_SOURCE_DIR +
               " --domain " + std::to_string(domain_))) {
      command.push_back(word);
    }
    std::vector<std::string> environment{"XDG_CACHE_HOME=" + folder_.path().string()};
    if (const std::string library = fakeTimeLibrary(); !library.empty()) {
      environment.insert(environment.end(),
                         {"LD_PRELOAD=" + library, "FAKETIME_NO_CACHE=1", "DONT_FAKE_MONOTONIC=1",
                          "FAKETIME_DONT_FAKE_MONOTONIC=1",
                          "FAKETIME_TIMESTAMP_FILE=" + (folder_ / "clock").string()});
    }
    process_ = std::make_unique<Process>(std::move(command), std::move(environment));
  }

  void kill() {
    process_->signal(SIGKILL);
    (void)process_->wait(5s);
  }

  /// Waits until it does.
  bool serves() { return process_->waitForOutput("serving", 60s); }

  void signal(int number) const { process_->signal(number); }

  void stepClock(std::int64_t seconds) const {
    clock_s_ += seconds;
    std::ofstream(folder_ / "clock.new") << (clock_s_ < 0 ? "" : "+") << clock_s_ << "s\n";
    fs::rename(folder_ / "clock.new", folder_ / "clock");
  }

  /// Of a grasp set: those are made again within seconds.
  void flipBits(std::uint64_t seed) const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder_ / "handover" / "grasps")) {
      if (entry.path().string().find(cell_ == "butler" ? "cup-crichton" : "") != std::string::npos)
        files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    SeededRandom random(seed);
    const fs::path file = files.at(random.index(static_cast<std::uint32_t>(files.size())));
    std::string text = textOf(file);
    for (int i = 0; i < 8; ++i)
      text[random.index(static_cast<std::uint32_t>(text.size()))] ^=
          static_cast<char>(1u << random.index(8));
    std::ofstream(file, std::ios::binary) << text;
  }

  /// What is wrong with how it lived and stops; empty for nothing.
  std::string stop() {
    process_->signal(SIGCONT);
    process_->signal(SIGTERM);
    const auto code = process_->wait(20s);
    if (!code) return "the daemon of " + cell_ + " does not stop";
    if (*code != 0)
      return "the daemon of " + cell_ + " ends with " + std::to_string(*code) + ":\n" +
             process_->err();
    return "";
  }

 private:
  const std::string cell_;
  const int domain_;
  const TemporaryFolder folder_;
  mutable std::int64_t clock_s_ = 0;
  std::unique_ptr<Process> process_;
};

class Asking {
 public:
  Asking(const std::string& cell, int number, int domain)
      : until_(Clock::now() + std::chrono::seconds(2 * kWaitS + kDeadlineS) + kProgram),
        process_(words(kBin + "handoverctl plan --json --mode first --no-fix --cell " + cell +
                       " --seed " + std::to_string(number) + " --wait " + std::to_string(kWaitS) +
                       " --deadline " + std::to_string(kDeadlineS) + " --domain " +
                       std::to_string(domain) + " --output " + (folder_ / "plan.json").string())) {}

  /// True once it has ended, or should have.
  bool over() {
    code_ = process_.wait(kLook);
    return code_ || Clock::now() > until_;
  }

  void kill() {
    killed_ = true;
    process_.signal(SIGKILL);
  }

  void signal(int number) const { process_.signal(number); }

  /// @pre over().
  void report(RunReport& to) const {
    if (killed_) {
      ++to.killed;
      return;
    }
    if (!code_)
      return to.faults.push_back("a client waits beyond its own time limit: " + process_.err());
    if (std::string fault = clientFault(*code_, process_.out()); !fault.empty()) {
      to.faults.push_back("client: " + fault + "\n" + process_.err());
    }
    if (*code_ != 0) return;
    ++to.done;
    if (const auto valid = verifiedFile(folder_ / "plan.json", HANDOVER_SOURCE_DIR); !valid) {
      to.faults.push_back(std::string("an invalid plan: ") + valid.message());
    }
  }

 private:
  const TemporaryFolder folder_;
  const Clock::time_point until_;
  Process process_;
  std::optional<int> code_;
  bool killed_ = false;
};

class World {
 public:
  explicit World(const WorldSettings& settings) : settings_(settings), recorder_(domain_) {
    for (const std::string& cell : settings.daemons)
      daemons_.push_back(std::make_unique<Daemon>(cell, domain_));
  }

  RunReport run(const std::vector<Fault>& faults) {
    for (const auto& daemon : daemons_) {
      if (!daemon->serves()) report_.faults.push_back("a daemon does not serve");
    }
    began_ = Clock::now();
    for (const Fault& fault : faults) later(fault.at, [this, fault] { begin(fault); });
    while (Clock::now() < began_ + settings_.length || !clients_.empty() || !due_.empty()) {
      happen();
      tendClients();
    }
    for (const auto& daemon : daemons_) {
      if (std::string fault = daemon->stop(); !fault.empty()) report_.faults.push_back(fault);
    }
    checkWire();
    return std::move(report_);
  }

 private:
  struct Due {
    Clock::time_point at;
    std::function<void()> what;
  };

  void later(std::chrono::milliseconds at, std::function<void()> what) {
    due_.push_back({began_ + at, std::move(what)});
  }

  void happen() {
    for (std::size_t i = 0; i < due_.size();) {
      if (Clock::now() < due_[i].at) {
        ++i;
        continue;
      }
      const std::function<void()> what = std::move(due_[i].what);
      due_.erase(due_.begin() + static_cast<std::ptrdiff_t>(i));
      what();
    }
  }

  void begin(const Fault& fault) {
    Daemon& daemon = *daemons_[static_cast<std::size_t>(fault.target) % daemons_.size()];
    const auto end = fault.at + fault.lasts;
    switch (fault.kind) {
      case FaultKind::kKillDaemon:
        return restart(daemon, end, false);
      case FaultKind::kStopDaemon:
        daemon.signal(SIGSTOP);
        return later(end, [&daemon] { daemon.signal(SIGCONT); });
      case FaultKind::kFullDisk:
        return restart(daemon, end, true);
      case FaultKind::kFlipBits:
        daemon.flipBits(static_cast<std::uint64_t>(fault.amount));
        return restart(daemon, end, false);
      case FaultKind::kClockStep:
        return daemon.stepClock(fault.amount);
      case FaultKind::kSlowReader:
        readers_.push_back(std::make_unique<Process>(std::vector<std::string>{
            HANDOVER_BINARY_DIR "/tests/sleeping_reader", std::to_string(domain_)}));
        return later(end, [this] { readers_.pop_front(); });
      case FaultKind::kKillClient:
      case FaultKind::kStopClient:
        return disturb(fault, end);
    }
  }

  void restart(Daemon& daemon, std::chrono::milliseconds at, bool on_full_disk) {
    daemon.kill();
    later(at, [&daemon, on_full_disk] {
      daemon.kill();  // another fault may have started it meanwhile
      daemon.start(on_full_disk);
    });
  }

  void disturb(const Fault& fault, std::chrono::milliseconds end) {
    if (clients_.empty()) return;
    const auto client = clients_[static_cast<std::size_t>(fault.target) % clients_.size()];
    if (fault.kind == FaultKind::kKillClient) return client->kill();
    client->signal(SIGSTOP);
    later(end, [client] { client->signal(SIGCONT); });
  }

  void tendClients() {
    for (std::size_t i = 0; i < clients_.size();) {
      if (!clients_[i]->over()) {
        ++i;
        continue;
      }
      clients_[i]->report(report_);
      clients_.erase(clients_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    while (Clock::now() < began_ + settings_.length &&
           static_cast<int>(clients_.size()) < settings_.clients) {
      const std::string& cell =
          settings_.daemons[static_cast<std::size_t>(report_.asked) % settings_.daemons.size()];
      clients_.push_back(std::make_shared<Asking>(cell, ++report_.asked, domain_));
    }
  }

  void checkWire() {
    const std::vector<HeardEvent> heard = recorder_.heard();
    for (std::string& fault : wireFaults(heard)) report_.faults.push_back("wire: " + fault);
    report_.answers =
        static_cast<int>(std::count_if(heard.begin(), heard.end(), [](const HeardEvent& each) {
          return std::holds_alternative<Outcome>(each.event.payload);
        }));
  }

  const WorldSettings settings_;
  const int domain_ = freeDomain();
  WireRecorder recorder_;
  Clock::time_point began_;
  std::vector<Due> due_;
  std::vector<std::unique_ptr<Daemon>> daemons_;
  std::vector<std::shared_ptr<Asking>> clients_;
  std::deque<std::unique_ptr<Process>> readers_;
  RunReport report_;
};

}  // namespace

std::string fakeTimeLibrary() {
  for (const char* folder : {"/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu"}) {
    const fs::path library = fs::path(folder) / "faketime" / "libfaketimeMT.so.1";
    if (fs::exists(library)) return library.string();
  }
  return {};
}

RunReport runWorld(const WorldSettings& settings, const std::vector<Fault>& faults) {
  return World(settings).run(faults);
}

}  // namespace handover::test
