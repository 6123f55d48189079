#include "cli/arguments/command_line.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <functional>
#include <sstream>
#include <vector>

#include "cli/arguments/settings.hpp"
#include "cli/arguments/usage_errors.hpp"
#include "cmrc/configuration/config.hpp"
#include "report/version.hpp"

namespace cli {
namespace {

/// A number that a key of the configuration takes. The configuration checks it as it checks the key in a file.
void declare_number(CLI::App& app, const std::string& name, std::optional<cmrc::Value>& number, const std::string& help,
                    const std::string& type) {
  app.add_option_function<std::string>(
         name, [&number](const std::string& text) { number = parse_value(text); }, help)
      ->type_name(type);
}

/// "doorbell (default), pause or spin"
std::string with_default(const std::vector<std::string>& names, std::string_view of_default) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
    text += names[i];
    if (names[i] == of_default) text += " (default)";
  }
  return text;
}

std::string choices_of(std::string_view key) {
  const auto found = std::ranges::find(cmrc::keys(), key, &cmrc::Key::name);
  return with_default(found->choices, std::get<std::string>(found->read(cmrc::Config{})));
}

std::string preset_names() {
  std::vector<std::string> names;
  for (const cmrc::Preset& preset : cmrc::presets()) names.emplace_back(preset.name);
  return with_default(names, names.front());
}

/// The options that make a configuration, for commands that run one or several.
void declare_settings(CLI::App& app, RunOptions& options) {
  declare_number(app, "--dsps", options.dsps, "Number of DSPs, 1 to 16 (default 4)", "INT");
  app.add_option("--config", options.config, "Configuration (TOML; docs/configuration.md)")->type_name("FILE");
  app.add_option("--preset", options.preset, preset_names());
  declare_number(app, "--duration", options.duration_s, "Simulated time in s (default 180)", "FLOAT");
  declare_number(app, "--seed", options.seed, "Seed of everything random (default 1)", "INT");
  app.add_option("--set", options.settings, "Any other setting, e.g. --set scheduling.gamma_refreshes=1")
      ->type_name("KEY=VALUE");
  declare_number(app, "--turn-order", options.turn_order, "Shuffle which chip is advanced first; changes nothing",
                 "SEED");
  app.add_option("--programs", options.programs, "Assemble the DSP programs from this directory")->type_name("DIR");
  app.add_option("--board", options.board, "Memories and clock of the DSPs' boards (docs/boards.md)")
      ->type_name("default|FILE.toml");
  app.add_option("--idle-policy", options.idle_policy,
                 "How a DSP without work waits: " + choices_of("machine.idle_policy"));
  app.add_option("--topology", options.topology, "Which device is on which bus: " + choices_of("bus.topology"));
  app.add_option("--eq7", options.equation7, "Reading of equation (7): " + choices_of("scheduling.equation"));
}

void declare_run(CLI::App& app, RunOptions& options) {
  declare_settings(app, options);
  app.add_option("--report", options.report, "Write the report as JSON (docs/report.md)")->type_name("FILE.json");
  app.add_option("--page", options.page,
                 "Write a page that shows the run in a browser: dock, DSPs, deadlines (docs/page.md)")
      ->type_name("FILE.html");
  app.add_option("--trace", options.trace, "Write the event trace as text (docs/trace.md)")->type_name("FILE");
  app.add_option("--trace-window", options.trace_window, "Trace only from A to B, in simulated s")->type_name("A:B");
  app.add_option("--trace-instructions", options.trace_instructions,
                 "Also write the instructions of these DSPs, into FILE.dspN")
      ->type_name("N");
  app.add_flag("--trace-labels", options.trace_labels,
               "Write labels instead of addresses into instruction traces, and no words");
  app.add_option("--perfetto", options.perfetto,
                 "Write a timeline for ui.perfetto.dev, compressed if the name ends in .gz (docs/timelines.md)")
      ->type_name("FILE[.gz]");
  app.add_option(
         "--perfetto-detail", options.perfetto_detail,
         "Detail of the timeline: tasks (default); bus: also each bus transaction; all: also each wait of the DSPs")
      ->type_name("tasks|bus|all");
  app.add_option("--perfetto-window", options.perfetto_window,
                 "Draw the timeline only from A to B, in simulated s; needed for bus and all")
      ->type_name("A:B");
  app.add_option("--profile", options.profile,
                 "Write the DSPs' cycles by task kind, routine and source line: to FILE (.json: as JSON), or "
                 "after the report")
      ->type_name("[FILE]")
      ->expected(0, 1);
  app.add_option("--snapshot-at", options.snapshots,
                 "Write a snapshot after S simulated s, for --resume; may be given several times")
      ->type_name("S:FILE")
      ->allow_extra_args(false);
  app.add_option("--resume", options.resume,
                 "Continue from a snapshot, with the snapshot's configuration (docs/snapshots.md)")
      ->type_name("FILE");
  app.add_option("--debug", options.debug_port,
                 "Let an editor attach to this port of this machine during the run (docs/dap.md); 0: any free port")
      ->check(integer(0, 65535))
      ->type_name("PORT");
  app.add_flag("--debug-wait", options.debug_wait, "Wait for the editor before the run");
  app.add_flag("--strict", options.strict,
               "Exit with status 1 when a deadline was missed, an error had to be handled, or no job was finished");
  app.add_flag("--quiet", options.quiet, "No progress line and no report on the terminal");
}

/// The command that the package cmrc executes.
constexpr const char* of_the_package = "limits";

/// Its options are not known here.
void declare_cmrc_command(CLI::App& app, CmrcCommandOptions&) {
  app.prefix_command();
  app.set_help_flag();
}

void declare_compare(CLI::App& app, CompareOptions& options) {
  declare_settings(app, options.run);
  app.add_option("--json", options.json, "Also write the result as JSON (docs/report.md, Ideal)")->type_name("FILE");
}

void declare_config(CLI::App& app, ConfigOptions& options) {
  app.add_option("--config", options.run.config, "Configuration (TOML; docs/configuration.md)")->type_name("FILE");
  app.add_option("--preset", options.run.preset, preset_names());
  app.add_option("--set", options.run.settings, "Any setting, e.g. --set machine.dsps=8")->type_name("KEY=VALUE");
  app.add_flag("--processes", options.processes,
               "Print only the built-in processes and sub-processes, with comments (docs/processes.md)");
}

void declare_dialect(CLI::App& app, std::optional<std::string>& dialect) {
  app.add_option("--dialect", dialect,
                 "The assembler for which a source was written, if the source does not say so: ti (default) or gnu "
                 "(docs/assembler.md, Dialects)")
      ->check(one_of({"ti", "gnu"}));
}

void declare_cpu(CLI::App& app, std::optional<std::string>& cpu, const std::string& meaning) {
  app.add_option("--cpu", cpu, meaning + ": c40 (default) or c3x (docs/assembler.md, The C3x)")
      ->check(one_of({"c40", "c3x"}));
}

void declare_assemble(CLI::App& app, AssembleOptions& options) {
  app.add_option("FILE", options.source, "Source in TI's syntax (docs/assembler.md)")->required();
  app.add_option("-o,--output", options.output, "COFF file to write")->required()->type_name("OUT");
  app.add_option("-I,--include", options.include_directories, "Look here for included files")
      ->type_name("DIR")
      ->allow_extra_args(false);
  app.add_option("-D,--define", options.defines, "Define a constant (1 if no number is given)")
      ->type_name("NAME[=NUMBER]")
      ->allow_extra_args(false);
  app.add_option("--section", options.sections, "Address of a section (.text: 300000h)")
      ->type_name("NAME=ADDRESS")
      ->allow_extra_args(false);
  app.add_option("--entry", options.entry, "Symbol at which the program starts")->type_name("SYMBOL");
  app.add_option("--listing", options.listing, "Also write a listing")->type_name("FILE");
  declare_dialect(app, options.dialect);
  declare_cpu(app, options.cpu, "The processor that the program is for");
  auto* const object = app.add_flag("-c,--object", options.object, "Write a relocatable object, for emulator link");
  app.add_flag("--undefined-external", options.undefined_external,
               "Leave symbols that are neither defined nor declared to other objects; --dialect gnu always does")
      ->needs(object);
  app.add_option("--coff-version", options.version, "0, 1 or 2 (default)")->check(integer(0, 2));
}

void declare_link(CLI::App& app, LinkOptions& options) {
  app.add_option("FILES", options.inputs, "Relocatable objects and libraries (.a, .lib)")->required();
  app.add_option("-o,--output", options.output, "COFF executable to write")->required()->type_name("OUT");
  app.add_option("--map", options.memory_map, "Memory map (TOML; docs/assembler.md); default: 1 M words at 300000h")
      ->type_name("FILE.toml");
  app.add_option("--entry", options.entry, "Symbol at which the program starts")->type_name("SYMBOL");
  app.add_option("--map-output", options.map_output, "Also write a map: the address of each section and symbol")
      ->type_name("FILE");
  app.add_option("--c-model", options.c_model,
                 "What sets C variables' initial values: rom, the program (default); ram, the loader")
      ->check(one_of({"rom", "ram"}));
  app.add_option("--coff-version", options.version, "0, 1 or 2 (default)")->check(integer(0, 2));
}

void declare_classify(CLI::App& app, ClassifyOptions& options) {
  app.add_option("--range", options.range, "Classify only these words (default: all 4294967296)")
      ->type_name("FIRST:COUNT");
  app.add_flag("--rows", options.rows, "Count the words of every encoding");
}

void declare_disassemble(CLI::App& app, DisassembleOptions& options) {
  app.add_option("FILE", options.program, "COFF file, .hex or source")->required();
  app.add_option("-I,--include", options.include_directories, "Look here for included files")
      ->type_name("DIR")
      ->allow_extra_args(false);
  app.add_option("--load-at", options.load_at, "Address of a .hex file's first word")->type_name("ADDRESS");
  declare_dialect(app, options.dialect);
  declare_cpu(app, options.cpu, "Processor of a source or of the words in a .hex file");
  app.add_flag("--source", options.source, "Print source that assembles to the same words: no addresses, no words");
}

/// The inputs of a board's devices.
void declare_devices(CLI::App& app, ExecOptions& options) {
  app.add_option("--console-input", options.console_input,
                 "Input of the board's console: a file; - for standard input, read to its end before the run; live: "
                 "standard input while the program runs")
      ->type_name("FILE");
  app.add_option("--console-record", options.console_record,
                 "Write the console's input with its times, as a script for --device-script")
      ->type_name("FILE");
  app.add_option("--device-input", options.device_inputs,
                 "Input of a console, FIFO or mailbox of the board: characters, or words in hexadecimal")
      ->type_name("NAME=FILE")
      ->allow_extra_args(false);
  app.add_option("--device-script", options.device_scripts, "Input of such a device by a host script (docs/boards.md)")
      ->type_name("NAME=FILE")
      ->allow_extra_args(false);
}

/// What a chip's memory holds at the start, how it starts and where it has ended: of exec and of the debugger.
void declare_memory(CLI::App& app, ExecOptions& options) {
  app.add_option("--until", options.until,
                 "Stop before the instruction at this address, or when a word of memory holds a value; several: at the "
                 "first")
      ->type_name("[CHIP:]SYMBOL|ADDRESS[==WORD]")
      ->allow_extra_args(false);
  app.add_option("--boot", options.boot,
                 "Start from reset with the boot loader, which takes the program from port 0 to 5 or as a stream at "
                 "ADDRESS; reset: as [pins] of the board say")
      ->type_name("PORT|ADDRESS|reset");
  app.add_option("--rom", options.roms,
                 "Contents of a ROM for --boot, from a word address on: Intel hex, S-records or bytes. PROGRAM is then "
                 "optional; only its names are used")
      ->type_name("FILE@ADDRESS")
      ->allow_extra_args(false);
  app.add_option("--rom-width", options.rom_width, "Width of these ROMs in bits, if their first bytes do not say it")
      ->check(one_of({"8", "16", "32"}));
  app.add_option("--load", options.loads,
                 "Also load words from a file of bytes (lowest byte first), Intel hex or S-records")
      ->type_name("FILE@[CHIP:]ADDRESS")
      ->allow_extra_args(false);
  app.add_option("--poke", options.pokes, "Write a word before the start")
      ->type_name("[CHIP:]ADDRESS=WORD")
      ->allow_extra_args(false);
}

void declare_exec(CLI::App& app, ExecOptions& options) {
  app.add_option("PROGRAM", options.programs,
                 "COFF executable, .asm, .s or .hex; several: one for each chip of a network (docs/networks.md)");
  app.add_option("-I,--include", options.include_directories, "Look here for included files")
      ->type_name("DIR")
      ->allow_extra_args(false);
  declare_dialect(app, options.dialect);
  CLI::Option* most = app.add_option("--max-cycles", options.max_cycles,
                                     "Stop after so many cycles with exit status 1 (default 100000000; with "
                                     "--console-input live only from the end of the input on)")
                          ->check(positive());
  app.add_option("--cycles", options.cycles, "Run so many cycles; exit status 0 when they are reached")
      ->check(positive())
      ->excludes(most);
  app.add_option("--dump", options.dumps, "Print COUNT words of memory from ADDRESS on")
      ->type_name("[CHIP:]ADDRESS:COUNT")
      ->allow_extra_args(false);
  app.add_flag("--json", options.json, "Print the result as JSON");
  app.add_option("--board", options.boards,
                 "default: the CMRC board's memory map; flat: zero-wait RAM everywhere, and the chip's own registers; "
                 "or a board file (docs/boards.md); for a network one board for all chips, or one for each")
      ->type_name("default|flat|FILE.toml")
      ->allow_extra_args(false);
  app.add_option("--memory-max", options.memory_max,
                 "How many MiB of the RAM of --board flat a program may use (default 256)")
      ->check(integer(1, 16384))
      ->type_name("MIB");
  app.add_option("--link", options.links, "Connect two communication ports")
      ->type_name("CHIP.PORT:CHIP.PORT")
      ->allow_extra_args(false);
  app.add_option("--net", options.nets, "Connect pins: TCLK0 of chip 0 drives IIOF1 of chip 1 (docs/networks.md)")
      ->type_name("0.TCLK0>1.IIOF1")
      ->allow_extra_args(false);
  app.add_option("--topology", options.topology, "Chips and their links: ring, line, grid, torus or hypercube")
      ->type_name("ring:4|grid:4x4|...");
  app.add_option("--network", options.network, "Chips, links, memories and events from a file (docs/networks.md)")
      ->type_name("FILE.toml");
  app.add_option(
         "--action", options.actions,
         "Cut or restore a link; reset, hold, release or pull out a chip; drive a net. Example: 12.5,cut,0.3:1.0")
      ->type_name("AT_US,ACTION,LINK|CHIP|NET")
      ->allow_extra_args(false);
  app.add_option("--link-trace", options.link_trace, "Write the words and tokens that go over the links")
      ->type_name("FILE");
  app.add_option("--turn-order", options.turn_order, "Shuffle which chip is advanced first; changes nothing")
      ->type_name("SEED");
  app.add_option("--load-at", options.load_at, "Address of a .hex file's first word, and start of the program")
      ->type_name("ADDRESS");
  app.add_option("--entry", options.entry, "Start at this address instead of the program's entry")
      ->type_name("SYMBOL|ADDRESS");
  declare_memory(app, options);
  declare_devices(app, options);
  app.add_option("--device-output", options.device_outputs, "Write the output of a console, FIFO or mailbox")
      ->type_name("NAME=FILE")
      ->allow_extra_args(false);
  app.add_flag("--peripherals", options.peripherals,
               "Print the peripheral registers that differ from reset, and the contents of the FIFOs");
  app.add_option("--trace", options.trace, "Write the instruction trace (docs/trace.md)")->type_name("FILE");
  app.add_flag("--trace-labels", options.trace_labels,
               "Write labels instead of addresses into the trace, and no words");
  app.add_option("--events", options.events, "Write what the peripherals did (docs/peripherals.md)")->type_name("FILE");
  app.add_option("--perfetto", options.perfetto,
                 "Write a network's links and FIFOs as a timeline for ui.perfetto.dev (docs/timelines.md)")
      ->type_name("FILE[.gz]");
  app.add_flag("--profile", options.profile, "Print cycles by cause, per routine and per source line");
  app.add_option("--pipeline", options.pipeline, "Draw the pipeline in these cycles")->type_name("FIRST:LAST");
  app.add_flag("--check", options.check, "Report broken rules of the manual (docs/fidelity.md, Self-checks)");
}

void declare_image(CLI::App& app, ImageOptions& options) {
  app.add_option("PROGRAM", options.program, "COFF file, .hex or source")->required();
  app.add_option("-o,--output", options.output, "File to write")->required()->type_name("OUT");
  app.add_option("--format", options.format,
                 "boot-stream: the words for a communication port, one per line; the others: an EPROM")
      ->required()
      ->check(one_of({"boot-stream", "intel-hex", "srec", "binary"}));
  app.add_option("--width", options.width, "Width of the memory from which the chip boots, in bits (default 32)")
      ->check(one_of({"8", "16", "32"}));
  app.add_option("--board", options.board,
                 "Board for whose interface control registers the stream has values: default, flat or a board file")
      ->type_name("default|flat|FILE.toml");
  app.add_option("-I,--include", options.include_directories, "Look here for included files")
      ->type_name("DIR")
      ->allow_extra_args(false);
  declare_dialect(app, options.dialect);
}

/// An option's name may have one meaning for a network and another for the dock.
void declare_debug(CLI::App& app, DebugOptions& options) {
  ExecOptions& exec = options.exec;
  app.add_option("PROGRAM", exec.programs,
                 "COFF executable, .asm, .s or .hex; several: one for each chip of a network. None: the dock");
  app.add_option("-x", options.scripts, "Execute the commands of this file, then end; may be given several times")
      ->type_name("FILE")
      ->allow_extra_args(false);
  app.add_option("-e", options.commands, "Execute this command first; may be given several times")
      ->type_name("COMMAND")
      ->allow_extra_args(false);
  app.add_option("-I,--include", exec.include_directories, "Look here for included files")
      ->type_name("DIR")
      ->allow_extra_args(false);
  declare_dialect(app, exec.dialect);
  app.add_option("--load-at", exec.load_at, "Address of a .hex file's first word, and start of the program")
      ->type_name("ADDRESS");
  declare_memory(app, exec);
  declare_devices(app, exec);
  app.add_option("--entry", exec.entry, "Start at this address instead of the program's entry")
      ->type_name("SYMBOL|ADDRESS");
  app.add_option("--board", exec.boards,
                 "default, flat or a board file; for a network one board for all chips, or one for each")
      ->type_name("default|flat|FILE.toml")
      ->allow_extra_args(false);
  app.add_option("--memory-max", exec.memory_max,
                 "How many MiB of the RAM of --board flat a program may use (default 256)")
      ->check(integer(1, 16384))
      ->type_name("MIB");
  app.add_option("--link", exec.links, "Connect two communication ports")
      ->type_name("CHIP.PORT:CHIP.PORT")
      ->allow_extra_args(false);
  app.add_option("--net", exec.nets, "Join pins")->type_name("0.TCLK0>1.IIOF1")->allow_extra_args(false);
  app.add_option("--topology", exec.topology,
                 "Chips and their links (ring:4, grid:4x4, ...); for the dock, which device is on which bus");
  app.add_option("--network", exec.network, "Chips, links, memories and events from a file (docs/networks.md)")
      ->type_name("FILE.toml");
  app.add_option("--action", exec.actions,
                 "Cut or restore a link; reset, hold, release or pull out a chip; drive a net")
      ->type_name("AT_US,ACTION,LINK|CHIP|NET")
      ->allow_extra_args(false);
  declare_number(app, "--dsps", options.run.dsps, "Number of the dock's DSPs, 1 to 16 (default 4)", "INT");
  app.add_option("--config", options.run.config, "Configuration of the dock (TOML)")->type_name("FILE");
  app.add_option("--preset", options.run.preset, "Preset of the dock: " + preset_names());
  declare_number(app, "--duration", options.run.duration_s, "Simulated time of the dock in s (default 180)", "FLOAT");
  declare_number(app, "--seed", options.run.seed, "Seed of everything random in the dock (default 1)", "INT");
  app.add_option("--set", options.run.settings, "Any other setting of the dock")->type_name("KEY=VALUE");
  app.add_option("--snapshot", options.run.resume, "Start the dock from a snapshot (docs/snapshots.md)")
      ->type_name("FILE");
}

void declare_dap(CLI::App& app, DapOptions& options) {
  app.add_option("--listen", options.port,
                 "Serve clients on this port of this machine, one after the other; 0: any free port. Without --listen: "
                 "standard input and output")
      ->check(integer(0, 65535))
      ->type_name("PORT");
}

void declare_trace_diff(CLI::App& app, TraceDiffOptions& options) {
  app.add_option("A", options.left, "A trace")->required();
  app.add_option("B", options.right, "Another trace of the same kind")->required();
  app.add_option("--programs", options.programs,
                 "Directory of the DSP programs with which the instructions behind a hash are executed again")
      ->type_name("DIR");
}

void declare_vectors(CLI::App& app, VectorOptions& options) {
  app.add_option("FILE", options.files, "Single-step vectors (docs/cli.md), plain, .gz or .xz")->required();
  app.add_option("--show", options.show, "Print so many failing vectors (default 10)")->check(not_negative());
  app.add_flag("--every-access", options.every_access,
               "Each line names all its bus accesses in order; a line without any makes none");
  app.add_flag("--json", options.json, "Print the result as JSON");
}

/// The commands, and the request that each makes once the arguments are read.
class Commands {
 public:
  explicit Commands(CLI::App& app) : app_(app) {}

  template <typename Options>
  void add(const char* name, const char* purpose, void (*declare)(CLI::App&, Options&), Options& options) {
    CLI::App* command = app_.add_subcommand(name, purpose);
    // Only the options of the command that is asked for are made: those of all commands take most of the time of a
    // parse.
    command->preparse_callback([=, &options](std::size_t) { declare(*command, options); });
    asked_.emplace_back(command, [&options] { return Request(options); });
  }
  Request asked(const RunOptions& otherwise) const {
    for (const auto& [command, request] : asked_)
      if (command->parsed()) return request();
    return otherwise;
  }

 private:
  CLI::App& app_;
  std::vector<std::pair<const CLI::App*, std::function<Request()>>> asked_;
};

}  // namespace

std::variant<Request, Help> parse_command_line(int argc, const char* const* argv) {
  // All that stands behind it, --help and -- too, goes to the package.
  if (argc > 1 && std::string_view(argv[1]) == of_the_package)
    return Request(CmrcCommandOptions{of_the_package, {argv + 2, argv + argc}});
  CLI::App app{
      "Emulator of TMS320C40 multiprocessors that reproduces the CMRC robot controller. Without a command it simulates "
      "the dock and reports "
      "whether the control tasks met their deadlines."};
  RunOptions run_options;
  ConfigOptions config_options;
  CmrcCommandOptions limits_options;
  CompareOptions compare_options;
  AssembleOptions assemble_options;
  DisassembleOptions disassemble_options;
  LinkOptions link_options;
  ClassifyOptions classify_options;
  ImageOptions image_options;
  ExecOptions exec_options;
  DebugOptions debug_options;
  DapOptions dap_options;
  TraceDiffOptions trace_diff_options;
  VectorOptions vector_options;

  app.set_version_flag("--version", fmt::format("emulator {}", report::emulator_version), "Print the version and end");
  declare_run(app, run_options);
  app.require_subcommand(0, 1);
  Commands commands(app);
  commands.add("config", "Print the configuration that a run would have, as TOML", declare_config, config_options);
  commands.add(of_the_package, "Scan for the first missed deadline (starts cmrc limits)", declare_cmrc_command,
               limits_options);
  commands.add("compare", "Compare a run with the same run under instant execution: what delays and misses cost",
               declare_compare, compare_options);
  commands.add("asm", "Assemble a C4x program", declare_assemble, assemble_options);
  commands.add("disasm", "Print a program as instructions", declare_disassemble, disassemble_options);
  commands.add("link", "Link objects to a program", declare_link, link_options);
  commands.add("classify", "Count what every 32-bit word is: an instruction, or reserved and why", declare_classify,
               classify_options);
  commands.add("image", "Make an EPROM, or a stream for a port, for the boot loader", declare_image, image_options);
  commands.add("exec", "Run a program on one chip, or programs on a network of chips", declare_exec, exec_options);
  commands.add("debug", "Debug a program, a network or the dock, forwards and backwards", declare_debug, debug_options);
  commands.add("dap", "Serve an editor: the Debug Adapter Protocol (docs/dap.md)", declare_dap, dap_options);
  commands.add("trace-diff", "Find the first difference of two traces (exit status 1 if there is one)",
               declare_trace_diff, trace_diff_options);
  commands.add("vectors", "Run single-step vectors (exit status 1 if one fails)", declare_vectors, vector_options);
  // The package's commands take the settings of a run.
  CLI::App of_package;
  RunOptions unused;
  declare_settings(of_package, unused);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0)
      throw InputError(misplaced_option(app, of_package).value_or(usage_error(app, error)));
    std::ostringstream text;
    app.exit(error, text, text);
    return Help{text.str()};
  }
  if (const auto error = misplaced_option(app, of_package)) throw InputError(*error);
  return commands.asked(run_options);
}

}  // namespace cli
