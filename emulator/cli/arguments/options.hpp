#pragma once
// The options of the command line: one struct and one function per command. command_line.cpp fills the structs;
// docs/cli.md explains them.
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "cmrc/configuration/rows/value.hpp"
#include "io/text_error.hpp"

namespace cli {

/// Exit statuses (ruling 29).
inline constexpr int success = 0;
inline constexpr int run_failed = 1;
inline constexpr int bad_input = 2;

/// The user gave something that cannot be used. The message says what and where, and what would be right.
class InputError : public io::TextError<std::runtime_error> {
 public:
  using TextError::TextError;
};

struct RunOptions {
  std::optional<cmrc::Value> dsps;
  std::optional<std::string> config;
  std::optional<std::string> preset;
  std::optional<cmrc::Value> duration_s;
  std::optional<cmrc::Value> seed;
  std::optional<cmrc::Value> turn_order;
  std::optional<std::string> programs;
  std::optional<std::string> board;
  std::optional<std::string> idle_policy;
  std::optional<std::string> topology;
  std::optional<std::string> equation7;
  bool strict = false;
  bool quiet = false;
  std::vector<std::string> settings;  ///< KEY=VALUE
  std::optional<std::string> report;
  std::optional<std::string> trace;
  std::optional<std::string> perfetto;         ///< FILE, or FILE.gz
  std::optional<std::string> perfetto_detail;  ///< tasks, bus or all
  std::optional<std::string> perfetto_window;  ///< A:B in seconds
  std::optional<std::string> page;
  std::optional<std::string> profile;        ///< file, or empty: on the terminal
  std::optional<std::string> trace_window;   ///< A:B in seconds
  std::vector<unsigned> trace_instructions;  ///< slots of the DSPs whose instructions are traced too
  bool trace_labels = false;                 ///< instruction traces have labels, not addresses
  std::vector<std::string> snapshots;        ///< S:FILE
  std::optional<std::string> resume;
  std::optional<int> debug_port;  ///< an editor may attach to this port during the run
  bool debug_wait = false;        ///< the run waits for the editor
};

/// emulator config: prints the configuration of a run instead of running it.
struct ConfigOptions {
  RunOptions run;
  bool processes = false;  ///< Only the built-in rows of processes and sub-processes.
};

/// A command of the Python package: the arguments after the command's name.
struct CmrcCommandOptions {
  std::string name;
  std::vector<std::string> arguments;
};

struct CompareOptions {
  RunOptions run;
  std::optional<std::string> json;
};

struct AssembleOptions {
  std::string source;
  std::string output;
  std::vector<std::string> include_directories;
  std::vector<std::string> defines;   ///< NAME or NAME=NUMBER
  std::vector<std::string> sections;  ///< NAME=ADDRESS
  std::optional<std::string> entry;
  std::optional<std::string> listing;
  std::optional<std::string> dialect;  ///< ti or gnu
  std::optional<std::string> cpu;      ///< c40 or c3x
  bool object = false;
  bool undefined_external = false;
  int version = 2;  ///< Version of the COFF file.
};

struct ClassifyOptions {
  std::optional<std::string> range;  ///< FIRST:COUNT
  bool rows = false;                 ///< Name every encoding.
};

struct LinkOptions {
  std::vector<std::string> inputs;
  std::string output;
  std::optional<std::string> memory_map;
  std::optional<std::string> entry;
  std::optional<std::string> map_output;
  std::optional<std::string> c_model;
  int version = 2;
};

struct DisassembleOptions {
  std::string program;
  std::vector<std::string> include_directories;
  std::optional<std::string> load_at;
  std::optional<std::string> dialect, cpu;
  bool source = false;  ///< Print source that assembles to the same words.
};

struct ImageOptions {
  std::string program;
  std::string output;
  std::string format;   ///< boot-stream, intel-hex, srec or binary
  unsigned width = 32;  ///< width of the memory in bits
  std::string board = "default";
  std::vector<std::string> include_directories;
  std::optional<std::string> dialect;
};

inline constexpr std::int64_t default_max_cycles = 100'000'000;

struct ExecOptions {
  std::vector<std::string> programs;
  std::vector<std::string> include_directories;
  std::vector<std::string> until;          ///< SYMBOL, ADDRESS or ADDRESS==WORD
  std::optional<std::int64_t> max_cycles;  ///< more cycles are a failure
  std::optional<std::int64_t> cycles;      ///< the requested length of the run
  std::vector<std::string> dumps;          ///< ADDRESS:COUNT
  bool json = false;
  std::vector<std::string> boards;          ///< empty: default
  std::optional<std::uint64_t> memory_max;  ///< MiB of RAM for each chip on board flat
  std::optional<std::string> dialect;       ///< of programs that are source files
  std::optional<std::string> load_at;
  std::optional<std::string> entry;
  std::optional<std::string> boot;  ///< a port 0 to 5, an address, or "reset"
  std::vector<std::string> roms;    ///< FILE@ADDRESS
  std::optional<unsigned> rom_width;
  std::vector<std::string> loads;            ///< FILE@ADDRESS
  std::vector<std::string> pokes;            ///< ADDRESS=WORD
  std::optional<std::string> console_input;  ///< a file, - for standard input, or live
  std::optional<std::string> console_record;
  std::vector<std::string> device_inputs, device_scripts, device_outputs;  ///< NAME=FILE
  bool peripherals = false;
  std::vector<std::string> links;  ///< CHIP.PORT:CHIP.PORT
  std::vector<std::string> nets;   ///< CHIP.PIN>CHIP.PIN
  std::optional<std::string> topology;
  std::optional<std::string> network;
  std::optional<std::string> link_trace;
  std::optional<std::string> perfetto;  ///< timeline of a network
  std::vector<std::string> actions;     ///< AT_US,ACTION,TARGET
  std::uint64_t turn_order = 0;
  std::optional<std::string> trace;
  bool trace_labels = false;  ///< the trace has labels, not addresses
  std::optional<std::string> events;
  bool check = false;
  bool profile = false;
  std::optional<std::string> pipeline;  ///< FIRST:LAST in cycles
};

struct DebugOptions {
  ExecOptions exec;                   ///< for programs and networks
  RunOptions run;                     ///< for the dock, if no program is given
  std::vector<std::string> scripts;   ///< files with commands
  std::vector<std::string> commands;  ///< executed before the scripts
};

struct DapOptions {
  std::optional<int> port;  ///< none: standard input and output
};

struct TraceDiffOptions {
  std::string left;
  std::string right;
  std::optional<std::string> programs;
};

struct VectorOptions {
  std::vector<std::string> files;
  int show = 10;              ///< Number of failing vectors to print.
  bool every_access = false;  ///< Each line names all its bus accesses in order; a line without any makes none.
  bool json = false;
};

// Each function returns an exit status; throws InputError or the input errors of the rooms below.
int run(const RunOptions& options);
int print_config(const ConfigOptions& options);
/// Does not return if the command starts. \throws InputError if no Python package is installed beside the program
int cmrc_command(const CmrcCommandOptions& options);
int compare(const CompareOptions& options);
int assemble(const AssembleOptions& options);
int disassemble(const DisassembleOptions& options);
int link(const LinkOptions& options);
int classify(const ClassifyOptions& options);
int image(const ImageOptions& options);
int exec(const ExecOptions& options);
int exec_network(const ExecOptions& options);
int debug(const DebugOptions& options);
int dap(const DapOptions& options);
int trace_diff(const TraceDiffOptions& options);
int vectors(const VectorOptions& options);

}  // namespace cli
