#include "machine/debug/inspect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>

#include "c40/peripherals/register_map.hpp"
#include "c40/values/float40.hpp"
#include "isa/ascii.hpp"
#include "isa/decode.hpp"
#include "isa/disassemble.hpp"

namespace machine::debug {
namespace {

using isa::Register;

bool ends_with_path(std::string_view path, std::string_view end) {
  if (!path.ends_with(end)) return false;
  return path.size() == end.size() || path[path.size() - end.size() - 1] == '/' ||
         path[path.size() - end.size() - 1] == '\\';
}

std::string_view last_part(std::string_view path) {
  const std::size_t slash = path.find_last_of("/\\");
  return slash == std::string_view::npos ? path : path.substr(slash + 1);
}

bool in_code(const toolchain::Image& image, Address address) {
  return std::ranges::any_of(image.sections, [&](const auto& s) { return s.loaded && address - s.address < s.size; });
}

AddressNames names_of(const toolchain::Image& image) {
  try {
    return AddressNames::of_dock(image);
  } catch (const std::out_of_range&) {
    return AddressNames(image);
  }
}

}  // namespace

ProgramView::ProgramView(const toolchain::Image& image) : image_(image), names_(names_of(image)) {
  for (std::size_t i = 0; i < image.lines.size(); ++i) lines_.emplace(image.lines[i].address, i);
  for (const auto& [name, value] : image.symbols)
    if (in_code(image, value) && !name.starts_with('.') && name.find('$') == std::string::npos)
      routines_.emplace(value, name);
}

std::optional<SourcePlace> ProgramView::source(Address address) const {
  const auto found = lines_.find(address);
  if (found == lines_.end()) return std::nullopt;
  const toolchain::LineRecord& line = image_.lines[found->second];
  return SourcePlace{line.file < image_.files.size() ? image_.files[line.file] : "", line.line, line.text};
}

std::vector<Address> ProgramView::addresses(std::string_view file, int line) const {
  int first = std::numeric_limits<int>::max();
  std::vector<Address> found;
  const auto is_file = [&](const toolchain::LineRecord& record) {
    const std::string& path = image_.files[record.file];
    return ends_with_path(path, file) || ends_with_path(file, path) || last_part(path) == last_part(file);
  };
  for (const toolchain::LineRecord& record : image_.lines) {
    if (record.line < line || record.line > first || record.file >= image_.files.size() || !is_file(record) ||
        !in_code(image_, record.address))
      continue;
    if (record.line < first) found.clear(), first = record.line;
    found.push_back(record.address);
  }
  return found;
}

std::string ProgramView::file_text(std::string_view file) const {
  if (std::ifstream in{std::string(file)}; in) {
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }
  std::map<int, std::string> lines;
  for (const toolchain::LineRecord& record : image_.lines)
    if (record.file < image_.files.size() && image_.files[record.file] == file) {
      lines[record.line] = record.text;
      if (!record.second.empty()) lines[record.line + 1] = record.second;
    }
  std::string text;
  int next = 1;
  for (const auto& [line, content] : lines) {
    text.append(static_cast<std::size_t>(std::max(line - next, 0)), '\n');
    text += content + '\n';
    next = line + 1;
  }
  return text;
}

std::optional<Address> ProgramView::address(std::string_view label) const {
  if (const auto at = names_.address(label)) return at;
  const auto symbol = image_.symbols.find(label);
  return symbol == image_.symbols.end() ? std::nullopt : std::optional<Address>(symbol->second);
}

std::optional<std::pair<std::string, Address>> ProgramView::routine(Address address) const {
  auto found = routines_.upper_bound(address);
  if (found == routines_.begin() || !in_code(image_, address)) return std::nullopt;
  --found;
  return std::pair{found->second, found->first};
}

std::string ProgramView::disassembled(Address address, Word word) const {
  return isa::disassemble(word, address, [this](Address at) { return names_.name(at).value_or(""); });
}

std::string ProgramView::instruction(Address address, Word word) const {
  const auto line = lines_.find(address);
  if (line == lines_.end()) return disassembled(address, word);
  const toolchain::LineRecord& record = image_.lines[line->second];
  std::string text = record.text;
  if (!record.second.empty()) text += "\n" + record.second;
  return text;
}

std::vector<Address> places_named(const ProgramView& program, std::string_view text) {
  if (text.starts_with('*')) text.remove_prefix(1);
  const std::size_t colon = text.rfind(':');
  if (colon != std::string_view::npos) {
    const std::string_view number = text.substr(colon + 1);
    if (number.empty() || number.size() > 9 ||
        !std::ranges::all_of(number, [](char c) { return c >= '0' && c <= '9'; }))
      throw DebugError(fmt::format("\"{}\": FILE:LINE is expected, LINE a number from 1 on", text));
    std::vector<Address> found = program.addresses(text.substr(0, colon), std::stoi(std::string(number)));
    if (!found.empty()) return found;
    std::string files;
    for (const std::string& file : program.files()) files += (files.empty() ? "" : ", ") + std::string(last_part(file));
    throw DebugError(fmt::format("\"{}\": there is no instruction in that line or after it; files with lines: {}", text,
                                 files.empty() ? "none" : files));
  }
  const std::size_t sign = text.find('+');
  auto base = program.address(text.substr(0, sign));
  if (!base) base = toolchain::find_address(text.substr(0, sign), nullptr);
  const auto offset = sign == std::string_view::npos ? std::optional<Address>(0)
                                                     : toolchain::find_address(text.substr(sign + 1), nullptr);
  if (!base || !offset)
    throw DebugError(fmt::format(
        "\"{}\" is not a place: a label, a label + a number, an address (300000h, 0x300000) or FILE:LINE is expected",
        text));
  return {*base + *offset};
}

// ---- calls ----

namespace {

const isa::Instruction* as_call(const isa::Decoded& decoded) {
  using enum isa::Operation;
  const auto* instruction = std::get_if<isa::Instruction>(&decoded);
  if (instruction == nullptr) return nullptr;
  const isa::Operation what = instruction->row->operation;
  return what == call || what == laj || what == trap || what == lat ? instruction : nullptr;
}

bool is_delayed(const isa::Instruction& instruction) {
  return instruction.row->operation == isa::Operation::laj || instruction.row->operation == isa::Operation::lat;
}

/// The call before a return address, if there is one that may call the routine.
std::optional<Address> call_before(Debuggee& debuggee, std::size_t chip, const ProgramView& program, Address returns_to,
                                   std::optional<Address> routine, bool delayed) {
  const Address at = returns_to - (delayed ? 4 : 1);
  const auto word = debuggee.peek(chip, at);
  if (!word || !in_code(program.image(), at)) return std::nullopt;
  const isa::Decoded decoded = isa::decode(*word);
  const isa::Instruction* instruction = as_call(decoded);
  if (instruction == nullptr || is_delayed(*instruction) != delayed) return std::nullopt;
  if (instruction->src1.is(isa::Operand::Kind::target) && routine) {
    const Address target = at + static_cast<Address>(instruction->src1.value);
    const auto called = program.routine(target);
    if (called && called->second != *routine && target != *routine) return std::nullopt;
  }
  return at;
}

constexpr Address deepest_look = 1024;  // words of stack
constexpr std::size_t most_frames = 64;

}  // namespace

std::optional<Address> returns_from_call(Address address, Word word) {
  const isa::Decoded decoded = isa::decode(word);
  const isa::Instruction* instruction = as_call(decoded);
  if (instruction == nullptr) return std::nullopt;
  return address + (is_delayed(*instruction) ? 4 : 1);
}

std::vector<Frame> call_stack(Debuggee& debuggee, std::size_t n, const ProgramView& program) {
  const c40::Chip& chip = debuggee.chip(n);
  std::vector<Frame> frames{{chip.pc(), std::nullopt, 0}};
  const auto routine_of = [&](Address pc) -> std::optional<Address> {
    const auto routine = program.routine(pc);
    return routine ? std::optional(routine->second) : std::nullopt;
  };
  const auto sp = static_cast<Address>(chip.register_value(Register::SP));
  const auto r11 = static_cast<Address>(chip.register_value(Register::R11));
  if (const auto at = call_before(debuggee, n, program, r11, routine_of(chip.pc()), true))
    frames.push_back({*at, std::nullopt, r11});
  for (Address depth = 0; depth < deepest_look && frames.size() < most_frames; ++depth) {
    const auto word = debuggee.peek(n, sp - depth);
    if (!word) break;
    const auto routine = routine_of(frames.back().pc);
    for (const bool delayed : {false, true})
      if (const auto at = call_before(debuggee, n, program, *word, routine, delayed);
          at && !(delayed && *word == r11 && frames.size() > 1)) {
        frames.push_back({*at, sp - depth, *word});
        break;
      }
  }
  return frames;
}

// ---- registers ----

namespace {

struct StatusField {
  std::string_view name;
  std::uint32_t mask;
};
constexpr std::array<StatusField, 16> status_fields{{{"C", c40::st::C},
                                                     {"V", c40::st::V},
                                                     {"Z", c40::st::Z},
                                                     {"N", c40::st::N},
                                                     {"UF", c40::st::UF},
                                                     {"LV", c40::st::LV},
                                                     {"LUF", c40::st::LUF},
                                                     {"OVM", c40::st::OVM},
                                                     {"RM", c40::st::RM},
                                                     {"PCF", c40::st::PCF},
                                                     {"CF", c40::st::CF},
                                                     {"CE", c40::st::CE},
                                                     {"CC", c40::st::CC},
                                                     {"GIE", c40::st::GIE},
                                                     {"PGIE", c40::st::PGIE},
                                                     {"SET COND", c40::st::SETCOND}}};

ShownRegister word_register(std::string name, Word value) {
  return {std::move(name), fmt::format("{:08X}h", value), fmt::format("{}", static_cast<std::int32_t>(value)), {}};
}

}  // namespace

std::vector<ShownRegister> registers(const c40::Chip& chip) {
  std::vector<ShownRegister> all;
  constexpr std::array<Register, isa::register_count> order{
      Register::R0,  Register::R1,  Register::R2,  Register::R3,  Register::R4,  Register::R5,  Register::R6,
      Register::R7,  Register::R8,  Register::R9,  Register::R10, Register::R11, Register::AR0, Register::AR1,
      Register::AR2, Register::AR3, Register::AR4, Register::AR5, Register::AR6, Register::AR7, Register::DP,
      Register::IR0, Register::IR1, Register::BK,  Register::SP,  Register::ST,  Register::DIE, Register::IIE,
      Register::IIF, Register::RS,  Register::RE,  Register::RC};
  all.push_back(word_register("PC", chip.pc()));
  for (const Register reg : order) {
    const std::uint64_t value = chip.register_value(reg);
    ShownRegister shown = word_register(ascii::upper(isa::name(reg)), static_cast<Word>(value));
    if (isa::is_extended(reg)) {
      const std::string integer = shown.value;
      shown.hex = fmt::format("{:010X}h", value);
      shown.value = fmt::format("{:.9g}", c40::float40::to_double(chip.float_register(reg)));
      shown.parts = {{"float", shown.value}, {"integer", integer}};
    }
    if (reg == Register::ST)
      for (const StatusField& field : status_fields)
        shown.parts.emplace_back(field.name, (value & field.mask) != 0 ? "1" : "0");
    all.push_back(std::move(shown));
  }
  all.push_back(word_register("IVTP", chip.expansion(isa::Expansion::IVTP)));
  all.push_back(word_register("TVTP", chip.expansion(isa::Expansion::TVTP)));
  return all;
}

std::vector<ShownRegister> peripherals(const c40::Chip& chip) {
  std::vector<ShownRegister> all;
  for (const c40::RegisterInfo& info : c40::register_map()) {
    const bool fifo = c40::is_port_register(info.address) &&
                      c40::port_access(info.address, false, 0, 0).reg != c40::PortRegister::control;
    if (fifo) continue;
    ShownRegister shown = word_register(info.name, chip.peripheral(info.name));
    const Word value = chip.peripheral(info.name);
    for (const c40::Field& field : info.fields)
      shown.parts.emplace_back(field.name, fmt::format("{}", field.of(value)));
    all.push_back(std::move(shown));
  }
  for (int n = 0; n < c40::port_count; ++n)
    for (const auto& [name, fifo] :
         {std::pair{"input", &chip.port(n).input}, std::pair{"output", &chip.port(n).output}}) {
      ShownRegister shown{fmt::format("PORT{}.{}", n, name), "", fmt::format("{} words", fifo->words().size()), {}};
      for (const Word word : fifo->words())
        shown.parts.emplace_back(fmt::format("{}", shown.parts.size()), fmt::format("{:08X}h", word));
      all.push_back(std::move(shown));
    }
  return all;
}

}  // namespace machine::debug
