#pragma once
/// What a front end shows of a chip and its program: places, source, calls, registers.
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "machine/debug/debuggee.hpp"
#include "machine/debug/error.hpp"
#include "machine/program_text/address_names.hpp"

namespace machine::debug {

struct SourcePlace {
  std::string file;  ///< as in the program: a path, or the name of a built-in file
  int line = 0;      ///< from 1
  std::string text;
};

/// A program's lines, labels and instructions, by address and by name.
class ProgramView {
 public:
  explicit ProgramView(const toolchain::Image& image);

  const toolchain::Image& image() const { return image_; }
  std::optional<SourcePlace> source(Address address) const;
  const std::vector<std::string>& files() const { return image_.files; }
  /// The absolute path of a file of the program, as it was found on disk; empty: it was not, or is built in.
  const std::string& path(std::size_t file) const { return paths_[file]; }
  std::string path(std::string_view file) const;
  /// A file's text: from disk, else composed of the lines that have code. Empty if none is known.
  std::string file_text(std::string_view file) const;
  /// "kernel_pid+0x1A"
  std::string name(Address address) const { return names_.text(address); }
  /// The address of a label, or of a word to which the program gives a name; else the value of a symbol.
  std::optional<Address> address(std::string_view label) const;
  /// The address of "label", "label+4".
  std::optional<Address> labelled(std::string_view text) const;
  /// A label of code that is exactly there.
  std::optional<std::string> label_at(Address address) const;
  /// The address is code of the program.
  bool has_code(Address address) const;
  /// Where the program's calls lead to, and its entry: a routine extends from one to the next, as in a profile.
  const std::set<Address>& called() const;
  /// From the source, else disassembled.
  std::string instruction(Address address, Word word) const;
  std::string disassembled(Address address, Word word) const;

 private:
  const toolchain::Image& image_;
  AddressNames names_;
  std::vector<std::string> paths_;         ///< of the files
  std::map<Address, std::size_t> lines_;   ///< into image_.lines
  std::map<Address, std::string> labels_;  ///< of code
  mutable std::set<Address> called_;       ///< made at the first call
};

/// A place in code: of one chip, or of all.
struct CodePlace {
  std::optional<std::size_t> chip{};
  Address address = 0;
  friend bool operator==(const CodePlace&, const CodePlace&) = default;
};
/// The same code, as far as it is the same: all chips with this chip's program.
std::vector<CodePlace> with_same_program(const std::vector<ProgramView>& programs, std::size_t chip, Address address);

/// What a user means by the name of a file: exactly the file that he names; else those of which most of the path, from
/// its end, is the same; else the only one with that last part. A file that is known to be another one is not meant.
class FilesNamed {
 public:
  /// \param chip only of its program; none: of all programs
  FilesNamed(const std::vector<ProgramView>& programs, std::optional<std::size_t> chip, std::string_view file);
  /// A file of the first program that has it, by its number there.
  static FilesNamed only(const std::vector<ProgramView>& programs, std::size_t chip, std::size_t file);
  bool empty() const { return files_.empty(); }
  /// In each of the files, the first line with code from `line` on.
  std::vector<CodePlace> code(int line) const;
  /// The lines with code from one to another.
  std::set<int> lines(int from, int to) const;

 private:
  explicit FilesNamed(const std::vector<ProgramView>& programs) : programs_(programs) {}
  struct File {
    std::size_t chip = 0, number = 0;
    std::string identity;  ///< the same text for the same file
  };
  const std::vector<ProgramView>& programs_;
  bool one_chip_ = false;
  std::vector<File> files_;
};

/// Code by a user's words: "kernel_pid", "kernel_pid+4", FILE:LINE: of each chip whose program has it, there; 300000h,
/// 0x300000, a decimal number: of all chips. \param chip only in its program
/// \throws DebugError that says what would be right
std::vector<CodePlace> code_named(const std::vector<ProgramView>& programs, std::optional<std::size_t> chip,
                                  std::string_view text);
/// The same in one chip's program.
std::vector<Address> places_named(const std::vector<ProgramView>& programs, std::size_t chip, std::string_view text);
/// "cloop (00300001h) of chip 0, cloop (00300005h) of chip 1"
std::string text_of(const std::vector<CodePlace>& places, const std::vector<ProgramView>& programs,
                    const Debuggee& debuggee);

struct Frame {
  Address pc = 0;             ///< of the present instruction, or of the call
  std::optional<Address> at;  ///< place of the return address on the stack
  Address returns_to = 0;     ///< for all but the first
};
/// By the calling convention, the innermost call first. Return addresses are words on the stack that follow a call of
/// the routine below; R11 after LAJ; if AR3 is used as by TI's C compiler, its chain counts.
std::vector<Frame> call_stack(Debuggee& debuggee, std::size_t chip, const ProgramView& program);

/// A value in the form for a front end.
struct ShownRegister {
  std::string name;
  std::string hex;
  std::string value;                                       ///< a float of R0 to R11, else a signed number
  std::vector<std::pair<std::string, std::string>> parts;  ///< fields by name; for R0 to R11 float, integer
};
/// R0 to R11, AR0 to AR7, the others, IVTP, TVTP, PC.
std::vector<ShownRegister> registers(const c40::Chip& chip);
/// Peripheral registers by name, with their fields.
std::vector<ShownRegister> peripherals(const c40::Chip& chip);

/// Whether a word is a call (CALL, CALLcond, LAJ, LAJcond, TRAPcond, LATcond), and its return address.
std::optional<Address> returns_from_call(Address address, Word word);
/// Whether a word is SWI.
bool calls_debugger(Word word);
/// Whether a word is RETIcond or RETIcondD.
bool returns_from_interrupt(Word word);

}  // namespace machine::debug
