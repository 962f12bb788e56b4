// The live service: wires sources, stages, publisher and recorder. service.cpp is the one orchestrating file.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <deque>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <zmq.hpp>

#include "capture/wire/curve_gate.h"
#include "daemon/config.h"
#include "daemon/control_server.h"
#include "daemon/notices.h"
#include "daemon/pipeline_thread.h"
#include "daemon/publisher.h"
#include "daemon/recorder.h"
#include "daemon/session_recorder.h"
#include "daemon/shown_streams.h"
#include "daemon/slip_monitor.h"
#include "daemon/stream_input.h"

namespace risorius {

class Service {
 public:
  /// Binds every address and opens the recording; throws UserError. `allocation_probe` is for tests.
  explicit Service(const Config& config, PipelineThread::AllocationProbe allocation_probe = nullptr);
  ~Service();

  /// Before run(): what to do with Notices, called on the I/O thread.
  void on_notice(std::function<void(const std::string& line)> notice) { notice_ = std::move(notice); }
  /// Runs the I/O thread's event loop in the calling thread until SIGINT, SIGTERM, SIGHUP, a stop command or stop();
  /// then works off everything that was admitted and completes the recording. Once.
  void run();
  /// From any thread.
  void stop();

  /// All counters, as the `status` topic has them. After run() has returned they are final.
  nlohmann::json status() const;

  std::string input_endpoint(std::size_t stream) const { return inputs_[stream].endpoint(); }
  const std::string& publish_endpoint() const { return publisher_->endpoint(); }
  const std::string& control_endpoint() const { return control_->endpoint(); }
  std::uint64_t allocations_in_frames() const { return pipeline_->allocations_in_frames(); }
  /// The first problem of the dataset, else of the session's file; empty if there was none.
  std::string recording_problem() const;

 private:
  nlohmann::json answer(const nlohmann::json& request);
  nlohmann::json capture_neutral(const nlohmann::json& request);
  nlohmann::json go_to(const nlohmann::json& request);
  nlohmann::json release(const nlohmann::json& request);
  std::uint32_t stream_of(const nlohmann::json& request) const;
  void begin_recording();
  void serve_events();
  void arm_status_timer();
  void look_for_silence();

  Config config_;
  zmq::context_t zmq_;
  boost::asio::io_context io_;
  boost::asio::signal_set signals_;
  boost::asio::steady_timer status_timer_, shown_timer_;
  bool shown_armed_ = false;
  std::function<void(const std::string& line)> notice_;
  Notices notices_;

  Channel<AdmittedItem> admitted_;
  Channel<OutputItem> to_publish_;
  Channel<Continuation> continuations_;
  std::unique_ptr<Channel<OutputItem>> to_record_;

  std::unique_ptr<SessionRecorder> session_;  ///< before what records into it
  std::deque<StreamInput> inputs_;
  std::deque<PipelineStream> streams_;
  std::deque<SlipMonitor> slips_;  ///< by stream
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<ShownStreams> shown_;
  Counter refused_connections_;
  std::optional<CurveGate> gate_;  ///< of zmq_, whose guarded sockets are below
  std::unique_ptr<Publisher> publisher_;
  std::unique_ptr<PipelineThread> pipeline_;
  std::unique_ptr<ControlServer> control_;
};

}  // namespace risorius
