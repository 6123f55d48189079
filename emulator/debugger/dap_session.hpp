#pragma once
/// A client's session: answers requests of the Debug Adapter Protocol with the debug core.
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "debugger/dap_stream.hpp"
#include "machine/debug/debugger.hpp"

namespace debugger::dap {

/// The result of `launch`; `owner` holds the debuggee.
struct Launched {
  std::shared_ptr<void> owner;
  machine::debug::Debuggee* debuggee = nullptr;
};
/// Launches from the arguments of `launch`. Its exceptions become the answer.
using Launch = std::function<Launched(const Json& arguments)>;

class Session {
 public:
  using Send = std::function<void(const Json&)>;
  /// For `launch`.
  Session(Send send, Launch launch);
  /// For `attach`, to an existing debugger.
  Session(Send send, machine::debug::Debugger& debugger);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Handles any message. Long work ends early if `asked` reports that another message needs this.
  void handle(const std::string& message);
  /// The machine has to run: call run_on().
  bool runs() const { return runs_; }
  /// Runs until a stop, or until `Debugger::interrupt`; reports a stop to the client.
  void run_on();
  /// The client has ended the session, or the run.
  bool over() const { return over_; }
  /// With `disconnect`: the debuggee ends with the session.
  bool terminates() const { return terminates_; }
  machine::debug::Debugger* debugger() { return debugger_; }
  /// Called from time to time during long work.
  std::function<void()> meanwhile;

 private:
  using Request = Json (Session::*)(const Json& arguments);
  static const std::map<std::string, Request, std::less<>>& requests();

  // dap_session.cpp: the session, and running
  Json initialize(const Json&);
  Json launch(const Json&);
  Json attach(const Json&);
  Json configuration_done(const Json&);
  Json disconnect(const Json&);
  Json terminate(const Json&);
  Json go(const Json&);
  Json pause(const Json&);
  Json next(const Json&);
  Json step_in(const Json&);
  Json step_out(const Json&);
  Json step_back(const Json&);
  Json reverse_continue(const Json&);

  // dap_breakpoints.cpp: stop conditions
  Json set_breakpoints(const Json&);
  Json set_function_breakpoints(const Json&);
  Json set_instruction_breakpoints(const Json&);
  Json set_exception_breakpoints(const Json&);
  Json data_breakpoint_info(const Json&);
  Json set_data_breakpoints(const Json&);
  Json breakpoint_locations(const Json&);

  // dap_views.cpp: views
  Json threads(const Json&);
  Json stack_trace(const Json&);
  Json scopes(const Json&);
  Json variables(const Json&);
  Json set_variable(const Json&);
  Json evaluate(const Json&);
  Json disassemble(const Json&);
  Json read_memory(const Json&);
  Json write_memory(const Json&);
  Json source(const Json&);
  Json loaded_sources(const Json&);
  Json exception_info(const Json&);

  machine::debug::Debugger& core();
  std::size_t chip_of(const Json& arguments) const;
  std::size_t chip_of_frame(const Json& arguments) const;
  /// Memory of a chip.
  struct Place {
    std::size_t chip = 0;
    machine::debug::Address address = 0;
  };
  /// The text by which the client names it: 0x00300000, or of several chips 1:0x00300000.
  std::string reference(Place place) const;
  /// A place that this session or a user named; without a chip of the one that stopped.
  Place place_of(const Json& arguments, std::string_view key) const;
  Json source_of(std::size_t chip, const std::string& file);
  machine::debug::FilesNamed files_of(const Json& source);
  // The client's lines and columns, from 0 or 1, and its paths
  int to_client(int line) const { return lines_from_one_ ? line : line - 1; }
  int from_client(const Json& line) const;
  std::string path_to_client(const std::string& path) const;
  std::string path_from_client(const std::string& path) const;
  void use(machine::debug::Debugger& debugger);
  void event(const std::string& name, Json body = Json::object());
  void tell_stop(const std::string& why = {});
  void output(const std::string& text, const char* category = "console");
  void do_step(const std::function<void()>& step);
  Json add_breakpoint(machine::debug::Trigger trigger, const Json& asked, std::vector<unsigned>& numbers);
  Json add_code_breakpoint(std::vector<machine::debug::CodePlace> places, const Json& asked,
                           std::vector<unsigned>& numbers);
  Json refused_breakpoint(const std::string& why);
  void forget(std::vector<unsigned>& numbers);
  Json variable(const machine::debug::ShownRegister& reg, bool hex, std::size_t chip);

  Send send_;
  Launch launch_;
  std::shared_ptr<void> owner_;
  std::unique_ptr<machine::debug::Debugger> own_;
  machine::debug::Debugger* debugger_ = nullptr;
  bool attached_ = false, configured_ = false, runs_ = false, over_ = false, terminates_ = false,
       stop_on_entry_ = false, stop_at_end_ = false, reported_end_ = false;
  std::function<void()> after_;  ///< the answer has been sent
  std::int64_t sequence_ = 0;
  machine::debug::ShownOutput shown_output_;
  bool lines_from_one_ = true, columns_from_one_ = true, paths_are_uris_ = false;
  unsigned refused_ = 0;
  std::map<std::string, std::vector<unsigned>> by_source_;
  std::vector<unsigned> by_function_, by_instruction_, by_data_, by_exception_;
  /// A file of a chip's program that is not on disk.
  struct BuiltIn {
    std::size_t chip = 0;
    std::string file;
  };
  std::vector<BuiltIn> sources_;  ///< by reference, from 1
  /// The contents of `variables`, by reference from 1; new at every stop.
  std::vector<std::function<Json(bool hex)>> shown_;
  /// A scope whose variables are registers.
  struct RegisterScope {
    std::size_t chip = 0;
    bool of_peripherals = false;
  };
  std::map<std::int64_t, RegisterScope> registers_shown_;  ///< by reference
};

}  // namespace debugger::dap
