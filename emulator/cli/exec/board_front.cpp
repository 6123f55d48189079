#include "cli/exec/board_front.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "io/print.hpp"
#include "io/stop.hpp"
#include "state/sha256.hpp"

namespace cli {
namespace {

using machine::BoardDevices;
using machine::DeviceDescription;
using machine::DeviceKind;

/// NAME=FILE, or CHIP.NAME=FILE in a network.
struct Assignment {
  std::string chip, device, file;
};

Assignment assignment_of(std::string_view option, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    throw InputError(
        fmt::format("{}: \"{}\" is not NAME=FILE, with the name of a [[device]] of the board", option, text));
  return {{}, text.substr(0, equals), text.substr(equals + 1)};
}

[[noreturn]] void no_device(std::string_view option, const std::string& name, const std::vector<std::string>& known) {
  throw InputError(
      known.empty()
          ? fmt::format("{}: there is no device {}; no board has a device that takes or sends words", option, name)
          : fmt::format("{}: there is no device {} that takes or sends words; {} is expected", option, name,
                        fmt::join(known, ", ")));
}

/// The device of this name, with or without the chip's name before it.
template <class Board, class Find>
auto find_device(std::string_view option, const std::vector<std::pair<std::string, Board*>>& boards,
                 const std::string& name, Find&& names_of) {
  std::vector<std::string> known;
  using Found = decltype(names_of(*boards.front().second).front().second);
  std::vector<Found> found;
  for (const auto& [chip, board] : boards) {
    if (board == nullptr) continue;
    for (const auto& [device, each] : names_of(*board)) {
      const std::string full = boards.size() > 1 ? chip + "." + device : device;
      known.push_back(full);
      if (name == full || name == device) found.push_back(each);
    }
  }
  if (found.empty()) no_device(option, name, known);
  if (found.size() > 1)
    throw InputError(
        fmt::format("{}: several chips have a device {}; {} is expected", option, name, fmt::join(known, ", ")));
  return found.front();
}

bool takes_words(DeviceKind kind) {
  return kind == DeviceKind::console || kind == DeviceKind::fifo || kind == DeviceKind::mailbox;
}

std::vector<std::pair<std::string, DeviceDescription*>> inputs_of(machine::BoardDescription& board) {
  std::vector<std::pair<std::string, DeviceDescription*>> all;
  for (DeviceDescription& device : board.devices)
    if (takes_words(device.kind)) all.emplace_back(device.name, &device);
  return all;
}

std::vector<std::pair<std::string, const BoardDevices::Place*>> outputs_of(const BoardDevices& devices) {
  std::vector<std::pair<std::string, const BoardDevices::Place*>> all;
  for (const BoardDevices::Place& place : devices.places())
    if (place.device->sent() != nullptr) all.emplace_back(place.described.name, &place);
  return all;
}

machine::DeviceInput input_from(std::string_view option, const std::string& file, DeviceKind kind, bool script) {
  try {
    if (file != "-") return machine::read_device_input(file, kind, script);
    return machine::device_input(std::string(std::istreambuf_iterator<char>(std::cin), {}), "standard input", kind,
                                 script);
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("{}: {}", option, error.what()));
  }
}

DeviceDescription& console_of(const NamedBoards& boards) {
  std::vector<DeviceDescription*> all;
  for (const auto& [chip, board] : boards)
    for (DeviceDescription& device : board->devices)
      if (device.kind == DeviceKind::console) all.push_back(&device);
  if (all.empty())
    throw InputError(fmt::format("--console-input: board {} has no [[device]] of kind \"console\"",
                                 boards.empty() ? "default" : boards.front().second->board.name));
  if (boards.size() > 1 && all.size() > 1)
    throw InputError("--console-input: several chips have a console; --device-input CHIP.NAME=FILE says which");
  return *all.front();
}

constexpr std::string_view live = "live";

bool is_standard_input(std::string_view file) {
  return file == "-" || file == "/dev/stdin" || file == "/dev/fd/0" || file == "/proc/self/fd/0";
}

}  // namespace

std::optional<std::string> reader_of_standard_input(const ExecOptions& options) {
  const auto& console = options.console_input;
  if (console && (is_standard_input(*console) || *console == live)) return "--console-input " + *console;
  for (const auto& [option, texts] :
       {std::pair{"--device-input", &options.device_inputs}, {"--device-script", &options.device_scripts}})
    for (const std::string& text : *texts)
      if (is_standard_input(assignment_of(option, text).file)) return fmt::format("{} {}", option, text);
  return {};
}

void add_inputs(const NamedBoards& boards, const ExecOptions& options) {
  std::map<const DeviceDescription*, std::string> inputs;  // of each device the option that gives its input
  std::string reader;                                      // the option that reads standard input
  const auto claim = [](std::string& by, const std::string& option, std::string_view what) {
    if (!by.empty()) throw InputError(fmt::format("{}: {} {} already", option, by, what));
    by = option;
  };
  if (options.console_input) {
    const std::string option = "--console-input " + *options.console_input;
    DeviceDescription& console = console_of(boards);
    if (is_standard_input(*options.console_input) || *options.console_input == live) reader = option;
    if (*options.console_input != live) {
      inputs[&console] = option;
      console.input = input_from("--console-input", *options.console_input, DeviceKind::console, false);
    }
  } else if (options.console_record) {
    throw InputError("--console-record: needs --console-input, whose characters it records");
  }
  for (const auto& [option, texts, script] : {std::tuple{"--device-input", &options.device_inputs, false},
                                              {"--device-script", &options.device_scripts, true}})
    for (const std::string& text : *texts) {
      const Assignment given = assignment_of(option, text);
      DeviceDescription& device = *find_device(option, boards, given.device, inputs_of);
      const std::string whole = fmt::format("{} {}", option, text);
      claim(inputs[&device], whole, fmt::format("gives the input of {}", device.name));
      if (is_standard_input(given.file)) claim(reader, whole, "reads standard input");
      device.input = input_from(option, given.file, device.kind, script);
    }
}

void add_device_files(const ExecOptions& options, io::FileRoles& files) {
  const auto reads = [&files](const std::string& option, const std::string& file) {
    files.reads(option, file == "-" || file == live ? "/dev/stdin" : file);  // which may be led to a file
  };
  if (options.console_input) reads("--console-input", *options.console_input);
  for (const std::string& text : options.device_inputs)
    reads("--device-input", assignment_of("--device-input", text).file);
  for (const std::string& text : options.device_scripts)
    reads("--device-script", assignment_of("--device-script", text).file);
  for (const std::string& text : options.device_outputs)
    files.writes("--device-output", assignment_of("--device-output", text).file);
  files.writes("--console-record", options.console_record.value_or(""));
}

BoardConsole::BoardConsole(std::vector<std::pair<std::string, BoardDevices*>> boards, const ExecOptions& options,
                           bool shows)
    : boards_(std::move(boards)), shows_(shows) {
  for (const auto& [chip, devices] : boards_) {
    if (devices == nullptr) continue;
    if (options.console_input == live && devices->console_at() != nullptr) live_ = devices;
    if (shows_)
      devices->on_output = [this](char c) {
        io::print("{}", c);
        at_line_begin_ = c == '\n';
        if (at_line_begin_ || is_live()) std::fflush(stdout);
      };
  }
  for (const std::string& text : options.device_outputs) {
    const Assignment given = assignment_of("--device-output", text);
    outputs_.push_back({find_device("--device-output", boards_, given.device, outputs_of),
                        std::make_unique<io::OutputFile>(given.file)});
  }
  if (options.console_record) record_.emplace(*options.console_record);
}

bool BoardConsole::empty() const {
  return std::ranges::all_of(boards_,
                             [](const auto& board) { return board.second == nullptr || board.second->empty(); });
}

constexpr std::size_t most_typed = std::size_t{1} << 20;

void BoardConsole::listen(c40::Cycles now, bool waits) {
  constexpr int look_ms = 200;  // a signal that comes right before poll() is seen then
  if (!may_be_typed()) return;
  std::array<char, 256> typed;
  pollfd ready{STDIN_FILENO, POLLIN, 0};
  while (poll(&ready, 1, waits ? look_ms : 0) <= 0)
    if (!waits || io::stop_asked()) return;
  const ssize_t count = read(STDIN_FILENO, typed.data(), typed.size());
  at_end_ = count <= 0;
  if (at_end_) return;
  // A pipe without an end that the program does not read would fill the memory.
  typed_characters_ += static_cast<std::size_t>(count);
  if (typed_characters_ > most_typed) {
    at_end_ = true;
    io::note_lost(
        fmt::format("--console-input live: what came behind the first {} MiB was not read", most_typed >> 20));
    return;
  }
  typed_.push_back(live_->type({typed.data(), static_cast<std::size_t>(count)}, now));
}

void BoardConsole::run_ended(const std::vector<std::string>& states) {
  if (empty()) return;
  std::string inputs;
  const BoardDevices::Place* recorded = nullptr;  // the console of --console-input
  for (const auto& [chip, devices] : boards_) {
    if (devices == nullptr) continue;
    if (recorded == nullptr) recorded = devices->console_at();
    for (const BoardDevices::Place& place : devices->places()) {
      std::string script = place.described.input ? machine::to_text(place.described.input->steps) : std::string();
      if (is_live() && &place == live_->console_at()) script += machine::to_text(typed_);
      inputs += machine::configuration_of(place.described) + script;
      if (record_ && &place == recorded) record_->stream() << script;
    }
  }
  for (const std::string& state : states) inputs += state::sha256(state);
  hash_ = state::sha256(inputs);
  for (Output& output : outputs_) {
    const bool characters = output.place->described.kind == DeviceKind::console;
    for (const c40::Word word : *output.place->device->sent())
      if (characters)
        output.file->stream() << static_cast<char>(word);
      else
        output.file->stream() << fmt::format("{:08X}\n", word);
    output.file->commit_or_note();
  }
  if (record_) record_->commit_or_note();
}

std::string BoardConsole::called(const std::string& chip, const std::string& device) const {
  return boards_.size() > 1 ? fmt::format("{} of chip {}", device, chip) : device;
}

std::string BoardConsole::text() const {
  constexpr std::size_t most_changes = 100, most_words = 8;
  std::string out = at_line_begin_ ? "" : "\n";
  for (const auto& [chip, devices] : boards_) {
    if (devices == nullptr) continue;
    if (!shows_ && !devices->console().empty())
      out += fmt::format("console of chip {}:\n{}{}", chip, devices->console(),
                         devices->console().ends_with('\n') ? "" : "\n");
    const auto& changes = devices->changes();
    for (std::size_t n = 0; n < std::min(changes.size(), most_changes); ++n)
      out += fmt::format("led {}: {:X}h at cycle {}\n", called(chip, changes[n].device), changes[n].value,
                         changes[n].cycle);
    if (devices->change_count() > most_changes)
      out += called(chip, fmt::format("led: {} more changes", devices->change_count() - most_changes)) + '\n';
    for (const auto& [described, device] : devices->places()) {
      const auto* sent = device->sent();
      if (sent != nullptr && described.kind != DeviceKind::console && !sent->empty()) {
        out += fmt::format("{} {}: sent {} words:", machine::name(described.kind), called(chip, described.name),
                           sent->size());
        for (std::size_t n = 0; n < std::min(sent->size(), most_words); ++n) out += fmt::format(" {:08X}", (*sent)[n]);
        out += sent->size() > most_words ? " ...\n" : "\n";
      }
      for (const auto& request : device->not_modelled())
        out += fmt::format("{} {}: asked for and not modelled: {} (first at cycle {})\n", machine::name(described.kind),
                           called(chip, described.name), request.what, request.cycle);
      if (described.input)
        out += fmt::format("input of {}: {}, sha256 {}\n", called(chip, described.name), described.input->source,
                           described.input->sha256);
    }
  }
  return out;
}

std::string BoardConsole::hash_text() const { return hash_.empty() ? "" : fmt::format("hash {}\n", hash_); }

void BoardConsole::add_to(nlohmann::ordered_json& root) const {
  if (empty()) return;
  using Json = nlohmann::ordered_json;
  const bool one = boards_.size() == 1;
  std::uint64_t led_changes = 0;
  Json leds = Json::array(), sent = Json::array(), inputs = Json::array(), consoles = Json::array(),
       missing = Json::array();
  for (const auto& [chip, devices] : boards_) {
    if (devices == nullptr) continue;
    const auto entry = [&, &chip = chip](const std::string& device) {
      Json out = {{"name", device}};
      if (!one) out["chip"] = chip;
      return out;
    };
    consoles.push_back(devices->console());
    led_changes += devices->change_count();
    for (const auto& change : devices->changes()) {
      Json out = entry(change.device);
      out["cycle"] = change.cycle, out["value"] = change.value;
      leds.push_back(std::move(out));
    }
    for (const auto& [described, device] : devices->places()) {
      if (device->sent() != nullptr && described.kind != DeviceKind::console) {
        Json out = entry(described.name);
        out["words"] = *device->sent();
        sent.push_back(std::move(out));
      }
      for (const auto& request : device->not_modelled()) {
        Json out = entry(described.name);
        out["what"] = request.what, out["cycle"] = request.cycle;
        missing.push_back(std::move(out));
      }
      if (described.input) {
        Json out = entry(described.name);
        out["source"] = described.input->source, out["sha256"] = described.input->sha256;
        inputs.push_back(std::move(out));
      }
    }
  }
  root["console"] = one ? consoles.front() : std::move(consoles);
  root["leds"] = std::move(leds);
  root["led_changes"] = led_changes;
  root["sent"] = std::move(sent);
  root["inputs"] = std::move(inputs);
  if (!missing.empty()) root["not_modelled"] = std::move(missing);
  root["hash"] = hash_;
}

}  // namespace cli
