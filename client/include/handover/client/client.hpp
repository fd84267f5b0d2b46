// SPDX-License-Identifier: Apache-2.0
// Asking a handover daemon for plans. No DDS type shows here.
#pragma once

#include <handover/common/plan_event.hpp>
#include <handover/common/status.hpp>

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace handover::client {

struct ClientOptions {
  std::optional<int> domain;  ///< DDS domain, 0..232; none: HANDOVER_DOMAIN, else 0
  std::string client_id;      ///< [a-z0-9_-]{1,64}; empty: a random one
  /// For a daemon to show up, to take a request, and to come back after it was lost.
  std::chrono::milliseconds wait{5000};
  /// For an answer to go on: how long it may be silent. A request with a deadline gets no more than
  /// that and `wait`.
  std::chrono::milliseconds silence{600'000};
};

class ClientError : public std::runtime_error {
 public:
  enum class Code {
    kNoDaemon,     ///< nobody there, or nobody took the request, within `wait`
    kDaemonLost,   ///< the daemon went away during the request and did not come back within `wait`
    kTimeLimit,    ///< the answer was silent for `silence`, or is `wait` behind its deadline
    kInterrupted,  ///< interrupt() was called
    kBadStream,    ///< the daemon sent what cannot be read, or an event is missing
    kDds,          ///< the middleware failed
  };

  ClientError(Code code, const std::string& text) : std::runtime_error(text), code_(code) {}

  Code code() const { return code_; }

 private:
  Code code_;
};

/// Called for every event in order, from the client's own thread. It may throw, which ends the
/// request; it must not destroy the client.
using OnEvent = std::function<void(const PlanEvent&)>;

/// Called when another answer to the same request begins, as of a daemon that came back: the events
/// before it are void, the next one has sequence 0. From the client's own thread.
using OnRestart = std::function<void()>;

/// A request on its way. Copies are the same request. Methods of a handle that is none of plan()'s
/// throw std::logic_error, as do those that need the outcome before it is there.
class PlanHandle {
 public:
  RequestId id() const;
  /// Waits for the outcome; every event was delivered before. @throws ClientError, and whatever
  /// left a callback of this request, which ends it; std::logic_error in a callback, where it would
  /// never come.
  Outcome wait() const;
  /// True when wait() would not wait after at most this time.
  bool waitFor(std::chrono::milliseconds most) const;
  /// Asks the daemon to stop; the outcome still comes.
  void cancel() const;
  /// From the write of the request to the arrival of its outcome. After wait() only.
  std::chrono::duration<double> answerTime() const;
  /// From the write of the request to the arrival of the last stage of the first whole plan of the
  /// answer that ended; nullopt if none came. After wait() only.
  std::optional<std::chrono::duration<double>> firstPlanTime() const;
  /// From the write of the request to the arrival of the reason why there is no plan; nullopt if it
  /// did not fail. After wait() only.
  std::optional<std::chrono::duration<double>> failureTime() const;

 private:
  friend class Client;
  struct State;
  State& state() const;
  State& endedState() const;

  std::shared_ptr<State> state_;
};

/// Asks the daemons of one domain; a thread of its own delivers callbacks. Clients of a process and
/// domain share a DDS participant. Safe from any thread.
class Client {
 public:
  /// @throws ClientError (kDds); std::invalid_argument for a bad client id or HANDOVER_DOMAIN.
  explicit Client(const ClientOptions& options = {});
  /// Open requests are cancelled by the daemon when their client is gone.
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  const std::string& clientId() const;

  /// Sends a request and waits until a daemon took it. An empty id gets a random one; client_id is
  /// filled in. A request beyond the wire's bounds is rejected here, as the daemon would. An answer
  /// is one daemon's: where another one begins, what came before is dropped and `on_restart` told;
  /// a leader of the cell that was followed by another is not gone back to while that one is there.
  /// Only participants that announced a daemon are listened to. @throws ClientError;
  /// std::logic_error in a callback, which would wait for itself; std::invalid_argument for an id
  /// that this client is asking for.
  PlanHandle plan(PlanRequest request, OnEvent on_event = {}, OnRestart on_restart = {});

  /// Cancels any request of the domain by its id.
  void cancel(const RequestId& id);

  /// The daemons announced, by id; waits until there is one and a moment for those that show up
  /// with it. @throws ClientError (kNoDaemon).
  std::vector<DaemonStatus> daemons();

  /// True while a daemon is announced; does not wait.
  bool daemonThere() const;

  /// Delivers events of all requests in the domain from now on, and those that daemons still keep,
  /// until the client is gone. A request may have several answers, told apart by answer_id. Once;
  /// `on_event` must not throw.
  void watch(OnEvent on_event);

  /// Ends the waiting in plan() and daemons(), now and later, with kInterrupted; but a request that
  /// a daemon has taken has its handle.
  void interrupt();

  struct Impl;

 private:
  std::shared_ptr<Impl> impl_;
};

/// Sends the middleware's errors to the log (standard error) instead of standard output, for the
/// whole process. Before the first Client.
void routeMiddlewareLog();

}  // namespace handover::client
