#include "cli/command_line.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <functional>
#include <sstream>
#include <vector>

#include "report/version.hpp"

namespace cli {
namespace {

/// What makes a configuration, for a run and for all that runs several.
void declare_settings(CLI::App& app, RunOptions& options) {
  app.add_option("--dsps", options.dsps, "Number of DSPs, 1 to 16 (default 4)");
  app.add_option("--config", options.config, "Configuration (TOML; docs/configuration.md)")->type_name("FILE");
  app.add_option("--preset", options.preset, "base (default), heavy, saturated or tight");
  app.add_option("--duration", options.duration_s, "Simulated time in s (default 180)");
  app.add_option("--seed", options.seed, "Seed of everything random (default 1)");
  app.add_option("--set", options.settings, "Any other setting, e.g. --set scheduling.gamma_refreshes=1")
      ->type_name("KEY=VALUE");
  app.add_option("--turn-order", options.turn_order, "Shuffle which chip is advanced first; changes nothing")
      ->type_name("SEED");
  app.add_option("--programs", options.programs, "Assemble the DSP programs from this directory")->type_name("DIR");
  app.add_option("--board", options.board, "Memories and clock of the DSPs' boards (docs/boards.md)")
      ->type_name("default|FILE.toml");
  app.add_option("--idle-policy", options.idle_policy,
                 "How a DSP without work waits: doorbell (default), pause or spin");
  app.add_option("--topology", options.topology,
                 "What stands on which bus: dual (default), host_on_both, sensors_with_host or single");
  app.add_option("--eq7", options.equation7, "Reading of equation (7): restored (default) or as_printed");
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
               "In instruction traces labels instead of addresses, and no words");
  app.add_option("--perfetto", options.perfetto,
                 "Write a timeline for ui.perfetto.dev, packed when the name ends in .gz (docs/timelines.md)")
      ->type_name("FILE[.gz]");
  app.add_option("--perfetto-detail", options.perfetto_detail,
                 "What it draws: tasks (default); bus: also each bus transaction; all: also each wait of the DSPs")
      ->type_name("tasks|bus|all");
  app.add_option("--perfetto-window", options.perfetto_window,
                 "It draws only from A to B, in simulated s; bus and all need it")
      ->type_name("A:B");
  app.add_option("--profile", options.profile,
                 "Where the DSPs' cycles went, per task kind, routine and source line; into FILE (.json: as JSON), or "
                 "after the report")
      ->type_name("[FILE]")
      ->expected(0, 1);
  app.add_option("--snapshot-at", options.snapshots,
                 "Write the run as it is after S simulated s, to be resumed; may be given several times")
      ->type_name("S:FILE")
      ->allow_extra_args(false);
  app.add_option("--resume", options.resume,
                 "Go on from a snapshot; the configuration is the snapshot's (docs/snapshots.md)")
      ->type_name("FILE");
  app.add_option(
         "--debug", options.debug_port,
         "An editor may attach at this port of this machine while the run goes on (docs/dap.md); 0: any that is free")
      ->check(CLI::Range(0, 65535))
      ->type_name("PORT");
  app.add_flag("--debug-wait", options.debug_wait, "The run waits for the editor");
  app.add_flag("--strict", options.strict, "Exit with status 1 when a deadline was missed");
  app.add_flag("--quiet", options.quiet, "No progress line and no report on the terminal");
}

/// Its options are the package's: they are handed on as they are, --help too.
void declare_cmrc_command(CLI::App& app, CmrcCommandOptions& options) {
  options.name = app.get_name();
  app.prefix_command();
  app.set_help_flag();
  app.final_callback([&app, &options] { options.arguments = app.remaining(); });
}

void declare_compare(CLI::App& app, CompareOptions& options) {
  declare_settings(app, options.run);
  app.add_option("--json", options.json, "Also write the result as JSON (docs/report.md, Ideal)")->type_name("FILE");
}

void declare_config(CLI::App& app, ConfigOptions& options) {
  app.add_option("--config", options.run.config, "Configuration (TOML; docs/configuration.md)")->type_name("FILE");
  app.add_option("--preset", options.run.preset, "base (default), heavy, saturated or tight");
  app.add_option("--set", options.run.settings, "Any setting, e.g. --set machine.dsps=8")->type_name("KEY=VALUE");
  app.add_flag("--processes", options.processes,
               "Only the processes and sub-processes built in, with comments (docs/processes.md)");
}

void declare_dialect(CLI::App& app, std::optional<std::string>& dialect) {
  app.add_option("--dialect", dialect,
                 "Whose assembler a source was written for, if it does not say so: ti (default) or gnu "
                 "(docs/assembler.md, Dialects)")
      ->check(CLI::IsMember({"ti", "gnu"}));
}

void declare_cpu(CLI::App& app, std::optional<std::string>& cpu, const std::string& meaning) {
  app.add_option("--cpu", cpu, meaning + ": c40 (default) or c3x (docs/assembler.md, The C3x)")
      ->check(CLI::IsMember({"c40", "c3x"}));
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
  app.add_option("--section", options.sections, "Where a section stands (.text: 300000h)")
      ->type_name("NAME=ADDRESS")
      ->allow_extra_args(false);
  app.add_option("--entry", options.entry, "The symbol at which the program starts")->type_name("SYMBOL");
  app.add_option("--listing", options.listing, "Also write a listing")->type_name("FILE");
  declare_dialect(app, options.dialect);
  declare_cpu(app, options.cpu, "The processor that the program is for");
  auto* const object = app.add_flag("-c,--object", options.object, "Write a relocatable object, for emulator link");
  app.add_flag("--undefined-external", options.undefined_external,
               "Leave symbols that are neither defined nor declared to other objects; so it is with --dialect gnu")
      ->needs(object);
  app.add_option("--coff-version", options.version, "0, 1 or 2 (default)")->check(CLI::Range(0, 2));
}

void declare_link(CLI::App& app, LinkOptions& options) {
  app.add_option("FILES", options.inputs, "Relocatable objects and libraries (.a, .lib)")->required();
  app.add_option("-o,--output", options.output, "COFF executable to write")->required()->type_name("OUT");
  app.add_option("--map", options.memory_map, "Memory map (TOML; docs/assembler.md); default: 1 M words at 300000h")
      ->type_name("FILE.toml");
  app.add_option("--entry", options.entry, "The symbol at which the program starts")->type_name("SYMBOL");
  app.add_option("--map-output", options.map_output, "Also write what went where")->type_name("FILE");
  app.add_option("--c-model", options.c_model,
                 "Who sets C variables' initial values: rom, the program (default); ram, whoever loads it")
      ->check(CLI::IsMember({"rom", "ram"}));
  app.add_option("--coff-version", options.version, "0, 1 or 2 (default)")->check(CLI::Range(0, 2));
}

void declare_classify(CLI::App& app, ClassifyOptions& options) {
  app.add_option("--range", options.range, "Only these words (default: all 4294967296)")->type_name("FIRST:COUNT");
  app.add_flag("--rows", options.rows, "Count the words of every encoding");
}

void declare_disassemble(CLI::App& app, DisassembleOptions& options) {
  app.add_option("FILE", options.program, "COFF file, .hex or source")->required();
  app.add_option("-I,--include", options.include_directories, "Look here for included files")
      ->type_name("DIR")
      ->allow_extra_args(false);
  app.add_option("--load-at", options.load_at, "Where a .hex file stands")->type_name("ADDRESS");
  declare_dialect(app, options.dialect);
  declare_cpu(app, options.cpu, "The processor of a source or of words in a .hex file");
  app.add_flag("--source", options.source, "Without addresses and words: text that assembles to the same words");
}

/// The other side of a board's devices.
void declare_devices(CLI::App& app, ExecOptions& options) {
  app.add_option("--console-input", options.console_input,
                 "What is typed at the board's console: a file; - for standard input, which is read to its end first; "
                 "live: standard input while the program runs")
      ->type_name("FILE");
  app.add_option("--console-record", options.console_record,
                 "Write what was typed, and when, as a script that --device-script takes")
      ->type_name("FILE");
  app.add_option("--device-input", options.device_inputs,
                 "What a console, FIFO or mailbox of the board is sent: characters, or words in hexadecimal")
      ->type_name("NAME=FILE")
      ->allow_extra_args(false);
  app.add_option("--device-script", options.device_scripts, "The same, by a host script (docs/boards.md)")
      ->type_name("NAME=FILE")
      ->allow_extra_args(false);
}

/// What a chip's memory holds at the start, how it starts and where it has ended: of exec and of the debugger.
void declare_memory(CLI::App& app, ExecOptions& options) {
  app.add_option("--until", options.until,
                 "Stop before the instruction there, or when a word of memory holds a value; of several, at the first")
      ->type_name("[CHIP:]SYMBOL|ADDRESS[==WORD]")
      ->allow_extra_args(false);
  app.add_option("--boot", options.boot,
                 "From reset, by the boot ROM's loader: the program comes through port 0 to 5, or stands as a stream "
                 "at ADDRESS; or as the board's [pins] say")
      ->type_name("PORT|ADDRESS|reset");
  app.add_option("--rom", options.roms,
                 "Contents of a ROM for --boot, from a word address on: Intel hex, S-records or bytes. PROGRAM may "
                 "then be left out; given, it lends its names")
      ->type_name("FILE@ADDRESS")
      ->allow_extra_args(false);
  app.add_option("--rom-width", options.rom_width, "Of these ROMs, in bits, where their first bytes do not say it")
      ->check(CLI::IsMember({8, 16, 32}));
  app.add_option("--load", options.loads,
                 "Also load words, the lowest byte first, from a file of bytes, Intel hex or S-records")
      ->type_name("FILE@[CHIP:]ADDRESS")
      ->allow_extra_args(false);
  app.add_option("--poke", options.pokes, "Write a word before the start")
      ->type_name("[CHIP:]ADDRESS=WORD")
      ->allow_extra_args(false);
}

void declare_exec(CLI::App& app, ExecOptions& options) {
  app.add_option("PROGRAM", options.programs,
                 "COFF executable, .asm, .s or .hex; of several, one for each chip of a network (docs/networks.md)");
  app.add_option("-I,--include", options.include_directories, "Look here for included files")
      ->type_name("DIR")
      ->allow_extra_args(false);
  declare_dialect(app, options.dialect);
  CLI::Option* most = app.add_option("--max-cycles", options.max_cycles,
                                     "Give up after so many cycles, with exit status 1 (default 100000000)")
                          ->check(CLI::PositiveNumber);
  app.add_option("--cycles", options.cycles, "Run so many cycles: reaching them is no failure")
      ->check(CLI::PositiveNumber)
      ->excludes(most);
  app.add_option("--dump", options.dumps, "Print so many words from there")
      ->type_name("[CHIP:]ADDRESS:COUNT")
      ->allow_extra_args(false);
  app.add_flag("--json", options.json, "Print the result as JSON");
  app.add_option("--board", options.boards,
                 "default: the CMRC board's memory map; flat: zero-wait RAM everywhere, and the chip's own registers; "
                 "or a board file (docs/boards.md); of a network one for all or one for each chip")
      ->type_name("default|flat|FILE.toml")
      ->allow_extra_args(false);
  app.add_option("--memory-max", options.memory_max,
                 "Of the RAM of --board flat a program may use so many MiB (default 256)")
      ->check(CLI::Range(1, 16384))
      ->type_name("MIB");
  app.add_option("--link", options.links, "Join two communication ports")
      ->type_name("CHIP.PORT:CHIP.PORT")
      ->allow_extra_args(false);
  app.add_option("--net", options.nets, "Join pins: TCLK0 of chip 0 drives IIOF1 of chip 1 (docs/networks.md)")
      ->type_name("0.TCLK0>1.IIOF1")
      ->allow_extra_args(false);
  app.add_option("--topology", options.topology, "Chips and their links: ring, line, grid, torus or hypercube")
      ->type_name("ring:4|grid:4x4|...");
  app.add_option("--network", options.network, "Chips, links, memories and events from a file (docs/networks.md)")
      ->type_name("FILE.toml");
  app.add_option("--action", options.actions,
                 "Cut or restore a link; reset, hold, release or pull out a chip; drive a net: 12.5,cut,0.3:1.0")
      ->type_name("AT_US,ACTION,LINK|CHIP|NET")
      ->allow_extra_args(false);
  app.add_option("--link-trace", options.link_trace, "Write the words and tokens on the links")->type_name("FILE");
  app.add_option("--turn-order", options.turn_order, "Shuffle which chip is advanced first; changes nothing")
      ->type_name("SEED");
  app.add_option("--load-at", options.load_at, "Where a .hex file stands and starts")->type_name("ADDRESS");
  app.add_option("--entry", options.entry, "Start here instead of at the program's entry")->type_name("SYMBOL|ADDRESS");
  declare_memory(app, options);
  declare_devices(app, options);
  app.add_option("--device-output", options.device_outputs, "Write what a console, FIFO or mailbox has sent")
      ->type_name("NAME=FILE")
      ->allow_extra_args(false);
  app.add_flag("--peripherals", options.peripherals,
               "Print the peripheral registers that differ from reset, and what the FIFOs hold");
  app.add_option("--trace", options.trace, "Write the instruction trace (docs/trace.md)")->type_name("FILE");
  app.add_flag("--trace-labels", options.trace_labels, "In it labels instead of addresses, and no words");
  app.add_option("--events", options.events, "Write what the peripherals did (docs/peripherals.md)")->type_name("FILE");
  app.add_option("--perfetto", options.perfetto,
                 "Write a network's links and FIFOs as a timeline for ui.perfetto.dev (docs/timelines.md)")
      ->type_name("FILE[.gz]");
  app.add_flag("--profile", options.profile, "Cycles by cause, per routine and per source line");
  app.add_option("--pipeline", options.pipeline, "Draw the pipeline in these cycles")->type_name("FIRST:LAST");
  app.add_flag("--check", options.check, "Look for broken rules of the manual (docs/fidelity.md, Self-checks)");
}

void declare_image(CLI::App& app, ImageOptions& options) {
  app.add_option("PROGRAM", options.program, "COFF file, .hex or source")->required();
  app.add_option("-o,--output", options.output, "File to write")->required()->type_name("OUT");
  app.add_option("--format", options.format,
                 "boot-stream: the words that a port is sent, one a line; the others: an EPROM")
      ->required()
      ->check(CLI::IsMember({"boot-stream", "intel-hex", "srec", "binary"}));
  app.add_option("--width", options.width, "Of the memory that the chip boots from, in bits (default 32)")
      ->check(CLI::IsMember({8, 16, 32}));
  app.add_option("--board", options.board,
                 "Whose interface control registers the stream sets: default, flat or a board file")
      ->type_name("default|flat|FILE.toml");
  app.add_option("-I,--include", options.include_directories, "Look here for included files")
      ->type_name("DIR")
      ->allow_extra_args(false);
  declare_dialect(app, options.dialect);
}

/// One name may mean a network's or the dock's.
void declare_debug(CLI::App& app, DebugOptions& options) {
  ExecOptions& exec = options.exec;
  app.add_option("PROGRAM", exec.programs,
                 "COFF executable, .asm, .s or .hex; of several, one for each chip of a network. None: the dock");
  app.add_option("-x", options.scripts, "Do the commands of this file, then end; may be given several times")
      ->type_name("FILE")
      ->allow_extra_args(false);
  app.add_option("-e", options.commands, "Do this command first; may be given several times")
      ->type_name("COMMAND")
      ->allow_extra_args(false);
  app.add_option("-I,--include", exec.include_directories, "Look here for included files")
      ->type_name("DIR")
      ->allow_extra_args(false);
  declare_dialect(app, exec.dialect);
  app.add_option("--load-at", exec.load_at, "Where a .hex file stands and starts")->type_name("ADDRESS");
  declare_memory(app, exec);
  declare_devices(app, exec);
  app.add_option("--entry", exec.entry, "Start here instead of at the program's entry")->type_name("SYMBOL|ADDRESS");
  app.add_option("--board", exec.boards, "default, flat or a board file; of a network one for all or one for each chip")
      ->type_name("default|flat|FILE.toml")
      ->allow_extra_args(false);
  app.add_option("--memory-max", exec.memory_max,
                 "Of the RAM of --board flat a program may use so many MiB (default 256)")
      ->check(CLI::Range(1, 16384))
      ->type_name("MIB");
  app.add_option("--link", exec.links, "Join two communication ports")
      ->type_name("CHIP.PORT:CHIP.PORT")
      ->allow_extra_args(false);
  app.add_option("--net", exec.nets, "Join pins")->type_name("0.TCLK0>1.IIOF1")->allow_extra_args(false);
  app.add_option("--topology", exec.topology,
                 "Chips and their links (ring:4, grid:4x4, ...); of the dock what stands on which bus");
  app.add_option("--network", exec.network, "Chips, links, memories and events from a file (docs/networks.md)")
      ->type_name("FILE.toml");
  app.add_option("--action", exec.actions,
                 "Cut or restore a link; reset, hold, release or pull out a chip; drive a net")
      ->type_name("AT_US,ACTION,LINK|CHIP|NET")
      ->allow_extra_args(false);
  app.add_option("--dsps", options.run.dsps, "The dock with so many DSPs, 1 to 16 (default 4)");
  app.add_option("--config", options.run.config, "The dock, from a configuration (TOML)")->type_name("FILE");
  app.add_option("--preset", options.run.preset, "Of the dock: base (default), heavy, saturated or tight");
  app.add_option("--duration", options.run.duration_s, "Of the dock: simulated time in s (default 180)");
  app.add_option("--seed", options.run.seed, "Of the dock: seed of everything random (default 1)");
  app.add_option("--set", options.run.settings, "Of the dock: any other setting")->type_name("KEY=VALUE");
  app.add_option("--snapshot", options.run.resume, "The dock from a snapshot on (docs/snapshots.md)")
      ->type_name("FILE");
}

void declare_dap(CLI::App& app, DapOptions& options) {
  app.add_option("--listen", options.port,
                 "Serve clients at this port of this machine, one after the other; 0: any that is free. Without it: "
                 "standard input and output")
      ->check(CLI::Range(0, 65535))
      ->type_name("PORT");
}

void declare_trace_diff(CLI::App& app, TraceDiffOptions& options) {
  app.add_option("A", options.left, "A trace")->required();
  app.add_option("B", options.right, "Another trace of the same kind")->required();
  app.add_option("--programs", options.programs,
                 "What stands behind a hash comes from the DSP programs in this directory")
      ->type_name("DIR");
}

void declare_vectors(CLI::App& app, VectorOptions& options) {
  app.add_option("FILE", options.files, "Single-step vectors (docs/cli.md), plain, .gz or .xz")->required();
  app.add_option("--show", options.show, "Name so many failing vectors (default 10)")->check(CLI::NonNegativeNumber);
  app.add_flag("--every-access", options.every_access,
               "Each line names all its bus accesses in order: one without any makes none");
  app.add_flag("--json", options.json, "Print the result as JSON");
}

/// The commands and what each asks for, once the arguments are read.
class Commands {
 public:
  explicit Commands(CLI::App& app) : app_(app) {}

  template <typename Options>
  void add(const char* name, const char* purpose, void (*declare)(CLI::App&, Options&), Options& options) {
    CLI::App* command = app_.add_subcommand(name, purpose);
    declare(*command, options);
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
  commands.add("limits", "Scan for the first missed deadline (starts cmrc limits)", declare_cmrc_command,
               limits_options);
  commands.add("compare", "Run beside the same run with instant execution: what delays and misses cost",
               declare_compare, compare_options);
  commands.add("asm", "Assemble a C4x program", declare_assemble, assemble_options);
  commands.add("disasm", "Print a program as instructions", declare_disassemble, disassemble_options);
  commands.add("link", "Link objects to a program", declare_link, link_options);
  commands.add("classify", "Count what every 32-bit word is: an instruction, or reserved and why", declare_classify,
               classify_options);
  commands.add("image", "Make an EPROM, or a stream for a port, that the boot loader takes", declare_image,
               image_options);
  commands.add("exec", "Run a program on one chip, or programs on a network of chips", declare_exec, exec_options);
  commands.add("debug", "Debug a program, a network or the dock, forwards and backwards", declare_debug, debug_options);
  commands.add("dap", "Serve an editor: the Debug Adapter Protocol (docs/dap.md)", declare_dap, dap_options);
  commands.add("trace-diff", "Find where two traces part (exit status 1 if they do)", declare_trace_diff,
               trace_diff_options);
  commands.add("vectors", "Run single-step vectors (exit status 1 if one fails)", declare_vectors, vector_options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0)
      throw InputError(std::string(error.what()) + " (emulator --help lists what there is)");
    std::ostringstream text;
    app.exit(error, text, text);
    return Help{text.str()};
  }
  return commands.asked(run_options);
}

}  // namespace cli
