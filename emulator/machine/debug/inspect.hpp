#pragma once
/// What a front end shows of a chip and its program: places, source, calls, registers.
#include <map>
#include <optional>
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
  /// In all files whose names end with `file`: the first line with code from `line` on. Empty if there is none.
  std::vector<Address> addresses(std::string_view file, int line) const;
  const std::vector<std::string>& files() const { return image_.files; }
  /// A file's text: from disk, else composed of the lines that have code. Empty if none is known.
  std::string file_text(std::string_view file) const;
  /// "kernel_pid+0x1A"
  std::string name(Address address) const { return names_.text(address); }
  /// The address of a label, or of a word to which the program gives a name; else the value of a symbol.
  std::optional<Address> address(std::string_view label) const;
  /// The label at the start of the routine, at or before the address; and its address.
  std::optional<std::pair<std::string, Address>> routine(Address address) const;
  /// From the source, else disassembled.
  std::string instruction(Address address, Word word) const;
  std::string disassembled(Address address, Word word) const;

 private:
  const toolchain::Image& image_;
  AddressNames names_;
  std::map<Address, std::size_t> lines_;     ///< into image_.lines
  std::map<Address, std::string> routines_;  ///< by first address
};

/// An address in a user's form: "kernel_pid", "kernel_pid+4", 300000h, 0x300000, a decimal number, or FILE:LINE.
/// \throws DebugError that says what would be right
std::vector<Address> places_named(const ProgramView& program, std::string_view text);

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

}  // namespace machine::debug
