#pragma once
/// Serves clients: on standard input and output, or on a port of this machine.

#include "debugger/dap_session.hpp"

namespace debugger::dap {

/// How a session ended.
struct Ended {
  bool terminate = false;  ///< the client wants the run to end
  std::string broken;      ///< why the stream broke; empty: it did not
};

/// Serves one client until it disconnects.
Ended serve(int in, int out, Launch launch);
Ended serve(int in, int out, machine::debug::Debugger& debugger);

/// A port on the loopback interface. One client at a time.
class Listener {
 public:
  /// \param port 0: a free one
  /// \throws std::system_error, with what would be right, for a port in use
  explicit Listener(int port);
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  int port() const { return port_; }
  /// A client has connected, and waits.
  bool has_client() const;
  /// Waits for the next client; -1 if a signal came first. The descriptor belongs to the caller.
  int accept();

 private:
  int socket_ = -1, port_ = 0;
};

}  // namespace debugger::dap
