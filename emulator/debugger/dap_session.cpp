#include "debugger/dap_session.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace debugger::dap {

namespace core_ns = machine::debug;
using core_ns::DebugError;
using core_ns::Debugger;
using core_ns::Step;
using core_ns::Stop;

namespace {

bool flag_of(const Json& from, std::string_view key) {
  const auto found = from.find(key);
  return found != from.end() && found->is_boolean() && found->get<bool>();
}

}  // namespace

const std::map<std::string, Session::Request, std::less<>>& Session::requests() {
  static const std::map<std::string, Request, std::less<>> all{
      {"initialize", &Session::initialize},
      {"launch", &Session::launch},
      {"attach", &Session::attach},
      {"configurationDone", &Session::configuration_done},
      {"disconnect", &Session::disconnect},
      {"terminate", &Session::terminate},
      {"continue", &Session::go},
      {"pause", &Session::pause},
      {"next", &Session::next},
      {"stepIn", &Session::step_in},
      {"stepOut", &Session::step_out},
      {"stepBack", &Session::step_back},
      {"reverseContinue", &Session::reverse_continue},
      {"setBreakpoints", &Session::set_breakpoints},
      {"setFunctionBreakpoints", &Session::set_function_breakpoints},
      {"setInstructionBreakpoints", &Session::set_instruction_breakpoints},
      {"setExceptionBreakpoints", &Session::set_exception_breakpoints},
      {"dataBreakpointInfo", &Session::data_breakpoint_info},
      {"setDataBreakpoints", &Session::set_data_breakpoints},
      {"breakpointLocations", &Session::breakpoint_locations},
      {"threads", &Session::threads},
      {"stackTrace", &Session::stack_trace},
      {"scopes", &Session::scopes},
      {"variables", &Session::variables},
      {"setVariable", &Session::set_variable},
      {"evaluate", &Session::evaluate},
      {"disassemble", &Session::disassemble},
      {"readMemory", &Session::read_memory},
      {"writeMemory", &Session::write_memory},
      {"source", &Session::source},
      {"loadedSources", &Session::loaded_sources},
      {"exceptionInfo", &Session::exception_info},
  };
  return all;
}

Session::Session(Send send, Launch launch) : send_(std::move(send)), launch_(std::move(launch)) {}
Session::Session(Send send, Debugger& debugger) : send_(std::move(send)), attached_(true) { use(debugger); }
Session::~Session() {
  if (debugger_ != nullptr) debugger_->output = {}, debugger_->progress = {};
}

void Session::use(Debugger& debugger) {
  debugger_ = &debugger;
  debugger.output = [this](const std::string& text) { output(text + "\n"); };
  debugger.progress = [this](machine::Time, machine::Time, machine::Time) {
    if (meanwhile) meanwhile();
  };
}

Debugger& Session::core() {
  if (debugger_ == nullptr) throw DebugError("there is no debuggee yet: launch or attach comes first");
  return *debugger_;
}

void Session::event(const std::string& name, Json body) {
  send_({{"seq", ++sequence_}, {"type", "event"}, {"event", name}, {"body", std::move(body)}});
}

void Session::output(const std::string& text, const char* category) {
  event("output", {{"category", category}, {"output", text}});
}

void Session::handle(const std::string& text) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object()) return output("a message that is not a JSON object\n", "important");
  const auto sequence = message.find("seq");
  const std::string command = text_of(message, "command");
  Json answer{
      {"seq", 0},
      {"type", "response"},
      {"request_seq", sequence != message.end() && sequence->is_number_integer() ? sequence->get<std::int64_t>() : 0},
      {"command", command},
      {"success", true}};
  const auto refuse = [&](const std::string& why) {
    answer["success"] = false;
    answer["message"] = why;
    answer["body"] = {{"error", {{"id", 1}, {"format", why}, {"showUser", true}}}};
  };
  if (text_of(message, "type") != "request") return;  // answers to requests that this side never sends
  after_ = {};
  try {
    const auto request = requests().find(command);
    if (request == requests().end()) throw DebugError(fmt::format("the request {} is unknown", command));
    const auto arguments = message.find("arguments");
    Json body =
        (this->*request->second)(arguments != message.end() && arguments->is_object() ? *arguments : Json::object());
    if (!body.is_null()) answer["body"] = std::move(body);
  } catch (const Json::exception& error) {
    refuse(fmt::format("{}: arguments that do not fit: {}", command, error.what()));
  } catch (const std::exception& error) {
    refuse(error.what());
  }
  answer["seq"] = ++sequence_;
  send_(answer);
  if (after_) std::exchange(after_, {})();
}

// ---- beginning and end ----

Json Session::initialize(const Json& arguments) {
  const auto flag = [&](const char* key) { return !arguments.contains(key) || arguments[key] != false; };
  lines_from_one_ = flag("linesStartAt1");
  columns_from_one_ = flag("columnsStartAt1");
  const std::string paths = text_of(arguments, "pathFormat");
  if (!paths.empty() && paths != "path" && paths != "uri")
    throw DebugError(fmt::format("pathFormat \"{}\": path or uri is expected", paths));
  paths_are_uris_ = paths == "uri";
  after_ = [this] {
    if (attached_) event("initialized");
  };
  Json filters = Json::array();
  filters.push_back({{"filter", "fault"}, {"label", "Faults: a chip cannot continue"}, {"default", true}});
  filters.push_back(
      {{"filter", "rule"}, {"label", "Rules of the manual that a program breaks (slow)"}, {"default", false}});
  filters.push_back({{"filter", "miss"}, {"label", "Missed deadlines (dock)"}, {"default", false}});
  filters.push_back({{"filter", "error"}, {"label", "Errors of the controller (dock)"}, {"default", false}});
  return {{"supportsConfigurationDoneRequest", true},
          {"supportsFunctionBreakpoints", true},
          {"supportsConditionalBreakpoints", true},
          {"supportsHitConditionalBreakpoints", true},
          {"supportsEvaluateForHovers", true},
          {"exceptionBreakpointFilters", filters},
          {"supportsStepBack", true},
          {"supportsSetVariable", true},
          {"supportsLogPoints", true},
          {"supportsDataBreakpoints", true},
          {"supportsReadMemoryRequest", true},
          {"supportsWriteMemoryRequest", true},
          {"supportsDisassembleRequest", true},
          {"supportsInstructionBreakpoints", true},
          {"supportsSteppingGranularity", true},
          {"supportsLoadedSourcesRequest", true},
          {"supportsTerminateRequest", true},
          {"supportTerminateDebuggee", true},
          {"supportsExceptionInfoRequest", true},
          {"supportsValueFormattingOptions", true},
          {"supportsBreakpointLocationsRequest", true}};
}

int Session::from_client(const Json& line) const {
  constexpr std::int64_t most = 1'000'000'000;
  const auto number = static_cast<int>(std::clamp<std::int64_t>(line.get<std::int64_t>(), -most, most));
  return lines_from_one_ ? number : number + 1;
}

Json Session::launch(const Json& arguments) {
  if (debugger_ != nullptr) throw DebugError("launch: there is already a debuggee");
  Launched made = launch_(arguments);
  owner_ = std::move(made.owner);
  own_ = std::make_unique<Debugger>(*made.debuggee);
  stop_on_entry_ = flag_of(arguments, "stopOnEntry");
  stop_at_end_ = flag_of(arguments, "stopAtEnd");
  use(*own_);
  after_ = [this] { event("initialized"); };
  return {};
}

Json Session::attach(const Json& arguments) {
  if (!attached_) throw DebugError("attach: nothing runs here; launch is expected");
  stop_at_end_ = flag_of(arguments, "stopAtEnd");
  stop_on_entry_ = true;
  return {};
}

Json Session::configuration_done(const Json&) {
  core();
  configured_ = true;
  after_ = [this] {
    if (stop_on_entry_)
      tell_stop("entry");
    else
      runs_ = true;
  };
  return {};
}

Json Session::disconnect(const Json& arguments) {
  const auto end = arguments.find("terminateDebuggee");
  terminates_ = end != arguments.end() && end->is_boolean() ? end->get<bool>() : !attached_;
  runs_ = false;
  over_ = true;
  return {};
}

Json Session::terminate(const Json&) {
  terminates_ = true;
  runs_ = false;
  after_ = [this] {
    event("terminated");
    over_ = attached_;
  };
  return {};
}

// ---- running ----

void Session::run_on() {
  try {
    if (core().go().reason == Stop::Reason::paused) return;
    runs_ = false;
  } catch (const DebugError& error) {  // a condition that has no value
    runs_ = false;
    output(std::string(error.what()) + "\n", "important");
    return tell_stop("breakpoint");
  }
  tell_stop();
}

/// \param why text for the client; empty: the stop's own text
void Session::tell_stop(const std::string& why) {
  shown_.clear();
  registers_shown_.clear();
  const Stop& stop = core().stop();
  if (const std::string sent = shown_output_.news(core().debuggee().output()); !sent.empty()) output(sent, "stdout");
  if (stop.reason == Stop::Reason::over && why.empty()) {
    if (!reported_end_) output(stop.text + "\n", "stdout");
    if (!std::exchange(reported_end_, true) && stop_at_end_)
      return event("stopped", {{"reason", "pause"},
                               {"description", "the run is over"},
                               {"text", stop.text},
                               {"threadId", stop.chip.value_or(0) + 1},
                               {"allThreadsStopped", true}});
    event("exited", {{"exitCode", 0}});
    return event("terminated");
  }
  reported_end_ = false;
  std::string reason = why;
  if (reason.empty()) switch (stop.reason) {
      case Stop::Reason::software_interrupt:
      case Stop::Reason::breakpoint: reason = "breakpoint"; break;
      case Stop::Reason::watchpoint: reason = "data breakpoint"; break;
      case Stop::Reason::fault: reason = "exception"; break;
      case Stop::Reason::event:
        reason = std::ranges::any_of(stop.hits,
                                     [&](const auto& hit) {
                                       return std::ranges::find(by_exception_, hit.trigger) != by_exception_.end();
                                     })
                     ? "exception"
                     : "breakpoint";
        break;
      case Stop::Reason::step: reason = "step"; break;
      case Stop::Reason::start: reason = "entry"; break;
      case Stop::Reason::moved: reason = "goto"; break;
      case Stop::Reason::paused:
      case Stop::Reason::over: reason = "pause"; break;
    }
  Json hit = Json::array();
  for (const auto& one : stop.hits) hit.push_back(one.trigger);
  Json body{{"reason", reason},
            {"threadId", stop.chip.value_or(0) + 1},
            {"allThreadsStopped", true},
            {"hitBreakpointIds", hit}};
  if (!stop.text.empty()) body["text"] = stop.text, body["description"] = stop.text;
  event("stopped", std::move(body));
}

Json Session::go(const Json&) {
  core();
  runs_ = true;
  return {{"allThreadsContinued", true}};
}

Json Session::pause(const Json&) {
  core();
  runs_ = false;
  after_ = [this] { tell_stop("pause"); };
  return {};
}

void Session::do_step(const std::function<void()>& step) {
  core();
  runs_ = false;  // a stop comes
  after_ = [this, step] {
    event("continued", {{"threadId", core().stop().chip.value_or(0) + 1}, {"allThreadsContinued", true}});
    try {
      step();
    } catch (const DebugError& error) {
      output(std::string(error.what()) + "\n", "important");
      return tell_stop("step");
    }
    tell_stop();
  };
}

namespace {

bool by_instruction(const Json& arguments) { return text_of(arguments, "granularity") == "instruction"; }

}  // namespace

Json Session::next(const Json& arguments) {
  const std::size_t chip = chip_of(arguments);
  do_step([this, chip, step = by_instruction(arguments) ? Step::over : Step::next_line] { core().step(chip, step); });
  return {};
}

Json Session::step_in(const Json& arguments) {
  const std::size_t chip = chip_of(arguments);
  do_step([this, chip, step = by_instruction(arguments) ? Step::instruction : Step::line] { core().step(chip, step); });
  return {};
}

Json Session::step_out(const Json& arguments) {
  const std::size_t chip = chip_of(arguments);
  do_step([this, chip] { core().step(chip, Step::out); });
  return {};
}

Json Session::step_back(const Json& arguments) {
  const std::size_t chip = chip_of(arguments);
  do_step([this, chip, step = by_instruction(arguments) ? Step::instruction : Step::next_line] {
    core().step_back(chip, step);
  });
  return {};
}

Json Session::reverse_continue(const Json&) {
  do_step([this] { core().go_back(); });
  return {};
}

std::size_t Session::chip_of(const Json& arguments) const {
  const auto thread = arguments.find("threadId");
  if (debugger_ == nullptr) throw DebugError("there is no debuggee yet: launch or attach comes first");
  if (thread == arguments.end() || !thread->is_number_integer())
    throw DebugError("threadId is missing; a number from 1 on is expected");
  const auto number = thread->get<std::int64_t>();
  const auto chips = static_cast<std::int64_t>(debugger_->programs().size());
  if (number < 1 || number > chips)
    throw DebugError(fmt::format("threadId {}: there are threads 1 to {}", number, chips));
  return static_cast<std::size_t>(number - 1);
}

}  // namespace debugger::dap
