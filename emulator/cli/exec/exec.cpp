// emulator exec: a program on one chip.

#include <utility>

#include "c40/peripherals/events.hpp"
#include "cli/arguments/program.hpp"
#include "cli/exec/exec_memory.hpp"
#include "cli/exec/exec_report.hpp"
#include "io/input_file.hpp"
#include "io/print.hpp"
#include "io/signals.hpp"
#include "machine/program_text/address_names.hpp"
#include "state/archive.hpp"

namespace cli {
namespace {

using toolchain::Address;
using toolchain::Image;

class EventText : public c40::PeripheralSink {
 public:
  EventText(const std::string& path, const Image& image) : file_(path), names_(image) {}
  void happened(const c40::PeripheralEvent& event) override {
    file_.stream() << event.cycle << ' ' << c40::to_text(event, [this](Address at) { return names_.text(at); }) << '\n';
  }
  void finish() { file_.commit_or_note(); }

 private:
  io::OutputFile file_;
  machine::AddressNames names_;
};

}  // namespace

int exec(const ExecOptions& options) {
  require_boot_for_roms(options);
  if (options.trace_labels && !options.trace) throw InputError("--trace-labels: needs --trace FILE");
  if (options.programs.size() > 1 || options.network || options.topology || !options.links.empty() ||
      !options.nets.empty())
    return exec_network(options);
  if (options.boards.size() > 1) throw InputError("--board: one chip has one board");
  if (options.link_trace) throw InputError("--link-trace: there is no link");
  if (options.perfetto)
    throw InputError("--perfetto: draws the links of a network; for one program there are --trace and --events");
  machine::BoardDescription chosen = board_named(options, options.boards.empty() ? "default" : options.boards.front());
  if (options.programs.empty() && !boots_rom(options, chosen))
    throw InputError(
        "exec: PROGRAM is missing; a program is expected, a ROM to boot (--rom, or region.file of the board, and "
        "--boot), or --network FILE.toml");
  add_inputs({{"0", &chosen}}, options);
  machine::BoardDevices board_devices(chosen.devices);
  const Image image = options.programs.empty() ? Image{}
                                               : read_program(options.programs.front(), options.include_directories,
                                                              options.load_at, options.dialect);
  for (const std::string& warning : image.warnings) io::print(stderr, "{}\n", warning);
  io::FileRoles files = files_read(options);
  for (const std::string& given : options.roms) files.reads("--rom", file_at(given, "--rom", &image).first);
  for (const std::string& given : options.loads) files.reads("--load", file_at(given, "--load", &image).first);
  for (const std::string& source : image.files_read) files.reads("a source", source);
  files.writes("--trace", options.trace.value_or("")).writes("--events", options.events.value_or(""));
  add_device_files(options, files);
  BoardConsole front({{"0", &board_devices}}, options, !options.json);
  const Until until = parse_until(options, image);
  std::vector<std::pair<Address, Address>> ranges;
  for (const std::string& text : options.dumps) ranges.push_back(parse_dump(text, image));

  const std::optional<Boot> boot = parse_boot(options, chosen);
  c40::Chip chip(boot ? boot->board : chosen.board);
  prepare(chip, options, image, chosen, boot);
  for (const auto& [address, word] : until.words) read_dump(chip, address, 1, "--until");
  for (const auto& [address, count] : ranges) read_dump(chip, address, count);  // refuses bad ranges before the run

  ChipListeners listeners(chip, image, options, 0, options.trace);
  chip.set_trace(listeners.sink());
  std::optional<EventText> events;
  if (options.events) chip.set_peripheral_sink(&events.emplace(*options.events, image));
  machine::LoneDevices devices(board_devices, chip);
  machine::IgnoredAccesses ignored(chosen.ignored);
  Connected connected{{}, front, devices, ignored};
  if (boot && machine::reset_source(boot->board) == machine::ResetSource::memory)
    connected.stream = machine::boot_address(boot->board);
  if (boot && boot->port) connected.feeder.emplace(chip, *boot->port, stream_for(image, *boot));
  const io::StopBySignal signals;
  const Outcome outcome = run(chip, until, options, connected);
  devices.run_ended();
  if (events) events->finish();
  listeners.run_ended();

  std::vector<Dump> dumps;
  for (const auto& [address, count] : ranges) dumps.push_back(read_dump(chip, address, count));
  front.run_ended({board_devices.empty() ? std::string()
                                         : state::save(chip) + state::save(board_devices) +
                                               (ignored.empty() ? "" : state::save(ignored))});
  const ExecReport report{chip,  outcome, std::move(dumps), listeners, chosen.clock_mhz, options.peripherals,
                          front, ignored};
  options.json ? print_json(report) : print_text(report);
  return outcome.reason == "interrupted" ? signals.status(run_failed) : outcome.status;
}

}  // namespace cli
