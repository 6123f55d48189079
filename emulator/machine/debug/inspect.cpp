#include "machine/debug/inspect.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "c40/peripherals/register_map.hpp"
#include "c40/values/float40.hpp"
#include "isa/ascii.hpp"
#include "isa/decode.hpp"
#include "isa/disassemble.hpp"

namespace machine::debug {
namespace {

using isa::Register;

std::string_view last_part(std::string_view path) {
  const std::size_t slash = path.find_last_of("/\\");
  return slash == std::string_view::npos ? path : path.substr(slash + 1);
}

/// The number of parts of the shorter path, if the other one ends with it; else 0.
std::size_t common_end(std::string_view a, std::string_view b) {
  if (a.size() < b.size()) std::swap(a, b);
  if (b.empty() || !a.ends_with(b)) return 0;
  const std::size_t before = a.size() - b.size();
  if (before != 0 && a[before - 1] != '/' && a[before - 1] != '\\') return 0;
  return 1 + static_cast<std::size_t>(std::ranges::count_if(b, [](char c) { return c == '/' || c == '\\'; }));
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
  for (const auto& [name, value] : image.names())
    if (in_code(image, value) && !name.starts_with('.') && name.find('$') == std::string::npos)
      labels_.emplace(value, name);
  for (const std::string& file : image.files) {
    std::error_code error;
    const bool found = std::filesystem::is_regular_file(file, error);
    paths_.push_back(found ? std::filesystem::absolute(file, error).lexically_normal().string() : "");
  }
}

std::optional<SourcePlace> ProgramView::source(Address address) const {
  const auto found = lines_.find(address);
  if (found == lines_.end()) return std::nullopt;
  const toolchain::LineRecord& line = image_.lines[found->second];
  return SourcePlace{line.file < image_.files.size() ? image_.files[line.file] : "", line.line, line.text};
}

std::string ProgramView::path(std::string_view file) const {
  const auto found = std::ranges::find(image_.files, file);
  return found == image_.files.end() ? "" : paths_[static_cast<std::size_t>(found - image_.files.begin())];
}

std::string ProgramView::file_text(std::string_view file) const {
  if (std::ifstream in{path(file)}; in) {
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
  const auto symbol = image_.symbols.find(label);
  if (symbol != image_.symbols.end() && names_.name(symbol->second) == label) return symbol->second;
  if (const auto at = names_.address(label)) return at;
  return symbol == image_.symbols.end() ? std::nullopt : std::optional<Address>(symbol->second);
}

std::optional<Address> ProgramView::labelled(std::string_view text) const {
  const std::size_t sign = text.find('+');
  const auto base = address(ascii::trimmed(text.substr(0, sign)));
  if (!base || sign == std::string_view::npos) return base;
  const auto offset = toolchain::find_address(ascii::trimmed(text.substr(sign + 1)), nullptr);
  return offset ? std::optional(*base + *offset) : std::nullopt;
}

std::optional<std::string> ProgramView::label_at(Address address) const {
  const auto found = labels_.find(address);
  return found == labels_.end() ? std::nullopt : std::optional(found->second);
}

bool ProgramView::has_code(Address address) const { return in_code(image_, address); }

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

// ---- places ----

std::vector<CodePlace> with_same_program(const std::vector<ProgramView>& programs, std::size_t chip, Address address) {
  std::vector<CodePlace> places;
  for (std::size_t n = 0; n < programs.size(); ++n)
    if (&programs[n].image() == &programs[chip].image()) places.push_back({n, address});
  if (places.size() == programs.size()) return {{std::nullopt, address}};
  return places;
}

namespace {

/// What is at the same addresses on every chip is of all.
std::vector<CodePlace> simplified(std::map<std::size_t, std::vector<Address>> by_chip, std::size_t chips) {
  std::vector<CodePlace> places;
  const bool same = by_chip.size() == chips && std::ranges::all_of(by_chip, [&](const auto& one) {
                      return one.second == by_chip.begin()->second;
                    });
  for (const auto& [chip, addresses] : by_chip) {
    for (const Address address : addresses) places.push_back({same ? std::nullopt : std::optional(chip), address});
    if (same) break;
  }
  return places;
}

}  // namespace

FilesNamed::FilesNamed(const std::vector<ProgramView>& programs, std::optional<std::size_t> chip, std::string_view file)
    : programs_(programs), one_chip_(chip.has_value()) {
  const std::filesystem::path named(file);
  std::error_code error;
  const bool on_disk = std::filesystem::is_regular_file(named, error);
  std::vector<File> exact, ends, parts;
  std::size_t most = 1;
  std::set<std::string> identities;
  for (std::size_t n = chip.value_or(0); n < (chip ? *chip + 1 : programs.size()); ++n)
    for (std::size_t i = 0; i < programs[n].files().size(); ++i) {
      const std::string &name = programs[n].files()[i], &path = programs[n].path(i);
      const File candidate{n, i, path.empty() ? name : path};
      if (on_disk && !path.empty()) {
        if (std::filesystem::equivalent(named, path, error)) exact.push_back(candidate);
        if (named.is_absolute()) continue;
      }
      if (const std::size_t common = std::max(common_end(name, file), common_end(path, file)); common >= most) {
        if (common > most) ends.clear();
        most = common;
        ends.push_back(candidate);
      }
      if (last_part(name) == last_part(file)) parts.push_back(candidate), identities.insert(candidate.identity);
    }
  files_ = !exact.empty() ? exact : !ends.empty() ? ends : identities.size() == 1 ? parts : std::vector<File>{};
}

FilesNamed FilesNamed::only(const std::vector<ProgramView>& programs, std::size_t chip, std::size_t file) {
  FilesNamed one(programs);
  for (std::size_t n = 0; n < programs.size(); ++n)
    if (&programs[n].image() == &programs[chip].image()) one.files_.push_back({n, file, programs[chip].files()[file]});
  return one;
}

std::vector<CodePlace> FilesNamed::code(int line) const {
  struct Found {
    int line = std::numeric_limits<int>::max();
    std::map<std::size_t, std::vector<Address>> by_chip{};
  };
  std::map<std::string, Found> found;  // by file
  for (const File& file : files_) {
    Found& best = found[file.identity];
    const toolchain::Image& image = programs_[file.chip].image();
    for (const toolchain::LineRecord& record : image.lines) {
      if (record.file != file.number || record.line < line || record.line > best.line ||
          !in_code(image, record.address))
        continue;
      if (record.line < best.line) best = {record.line, {}};
      best.by_chip[file.chip].push_back(record.address);
    }
  }
  std::map<std::size_t, std::vector<Address>> by_chip;
  for (const auto& [identity, best] : found)
    for (const auto& [chip, addresses] : best.by_chip)
      by_chip[chip].insert(by_chip[chip].end(), addresses.begin(), addresses.end());
  return simplified(std::move(by_chip), one_chip_ ? 1 : programs_.size());
}

std::set<int> FilesNamed::lines(int from, int to) const {
  std::set<int> all;
  for (const File& file : files_)
    for (const toolchain::LineRecord& record : programs_[file.chip].image().lines)
      if (record.file == file.number && record.line >= from && record.line <= to &&
          in_code(programs_[file.chip].image(), record.address))
        all.insert(record.line);
  return all;
}

std::vector<CodePlace> code_named(const std::vector<ProgramView>& programs, std::optional<std::size_t> chip,
                                  std::string_view text) {
  if (text.starts_with('*')) text.remove_prefix(1);
  const std::size_t first = chip.value_or(0), behind = chip ? *chip + 1 : programs.size();
  const std::size_t colon = text.rfind(':');
  if (colon != std::string_view::npos) {
    const std::string_view digits = text.substr(colon + 1);
    const auto number = ascii::number<unsigned>(digits);
    if (!number || digits.size() > 9)
      throw DebugError(fmt::format("\"{}\": FILE:LINE is expected, LINE a number from 1 on", text));
    std::vector<CodePlace> found = FilesNamed(programs, chip, text.substr(0, colon)).code(static_cast<int>(*number));
    if (!found.empty()) return found;
    std::map<std::string_view, std::set<std::string_view>> files;  // by their last parts
    for (std::size_t n = first; n < behind; ++n)
      for (const std::string& file : programs[n].files()) files[last_part(file)].insert(file);
    std::vector<std::string_view> names;
    for (const auto& [last, all] : files) {
      if (all.size() == 1)
        names.push_back(last);
      else
        names.insert(names.end(), all.begin(), all.end());
    }
    throw DebugError(fmt::format("\"{}\": there is no instruction in that line or after it; files with lines: {}", text,
                                 names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
  }
  std::map<std::size_t, std::vector<Address>> by_chip;
  for (std::size_t n = first; n < behind; ++n)
    if (const auto labelled = programs[n].labelled(text)) by_chip[n] = {*labelled};
  if (!by_chip.empty()) return simplified(std::move(by_chip), behind - first);
  const std::size_t sign = text.find('+');
  const auto base = toolchain::find_address(text.substr(0, sign), nullptr),
             offset = sign == std::string_view::npos ? std::optional<Address>(0)
                                                     : toolchain::find_address(text.substr(sign + 1), nullptr);
  if (!base || !offset)
    throw DebugError(fmt::format(
        "\"{}\" is not a place: a label, a label + a number, an address (300000h, 0x300000) or FILE:LINE is expected",
        text));
  return {{std::nullopt, *base + *offset}};
}

std::vector<Address> places_named(const std::vector<ProgramView>& programs, std::size_t chip, std::string_view text) {
  std::vector<Address> addresses;
  for (const CodePlace& place : code_named(programs, chip, text)) addresses.push_back(place.address);
  return addresses;
}

std::string text_of(const std::vector<CodePlace>& places, const std::vector<ProgramView>& programs,
                    const Debuggee& debuggee) {
  constexpr std::size_t most = 8;
  std::vector<std::string> texts;
  for (const CodePlace& place : places) {
    if (texts.size() == most) {
      texts.push_back(fmt::format("and {} more", places.size() - most));
      break;
    }
    texts.push_back(fmt::format("{} ({:08X}h){}", programs[place.chip.value_or(0)].name(place.address), place.address,
                                place.chip ? " of " + debuggee.chip_name(*place.chip) : ""));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
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

/// Of a call that leads to one place.
std::optional<Address> target_of(const isa::Instruction& call, Address at) {
  if (!call.src1.is(isa::Operand::Kind::target)) return std::nullopt;
  return at + static_cast<Address>(call.src1.value);
}

bool is_delayed(const isa::Instruction& instruction) {
  return instruction.row->operation == isa::Operation::laj || instruction.row->operation == isa::Operation::lat;
}

/// The call before a return address, if there is one that may have led to `pc`: no other routine lies between.
std::optional<Address> call_before(Debuggee& debuggee, std::size_t chip, const ProgramView& program, Address returns_to,
                                   Address pc, bool delayed) {
  const Address at = returns_to - (delayed ? 4 : 1);
  const auto word = debuggee.peek(chip, at);
  if (!word || !program.has_code(at)) return std::nullopt;
  const isa::Decoded decoded = isa::decode(*word);
  const isa::Instruction* instruction = as_call(decoded);
  if (instruction == nullptr || is_delayed(*instruction) != delayed) return std::nullopt;
  if (const auto target = target_of(*instruction, at); target && program.has_code(pc))
    if (*target > pc || program.called().upper_bound(*target) != program.called().upper_bound(pc)) return std::nullopt;
  return at;
}

constexpr Address deepest_look = 1024;  // words of stack
constexpr std::size_t most_frames = 64;

}  // namespace

const std::set<Address>& ProgramView::called() const {
  if (!called_.empty()) return called_;
  called_.insert(image_.entry);
  for (const toolchain::Image::Section& section : image_.sections)
    for (Address i = 0; i < section.words.size(); ++i) {
      const isa::Decoded decoded = isa::decode(section.words[i]);
      const isa::Instruction* call = as_call(decoded);
      const auto target = call != nullptr ? target_of(*call, section.address + i) : std::nullopt;
      if (target && has_code(*target)) called_.insert(*target);
    }
  return called_;
}

std::optional<Address> returns_from_call(Address address, Word word) {
  const isa::Decoded decoded = isa::decode(word);
  const isa::Instruction* instruction = as_call(decoded);
  if (instruction == nullptr) return std::nullopt;
  return address + (is_delayed(*instruction) ? 4 : 1);
}

bool calls_debugger(Word word) {
  const isa::Decoded decoded = isa::decode(word);
  const auto* instruction = std::get_if<isa::Instruction>(&decoded);
  return instruction != nullptr && instruction->row->operation == isa::Operation::swi;
}

bool returns_from_interrupt(Word word) {
  const isa::Decoded decoded = isa::decode(word);
  const auto* instruction = std::get_if<isa::Instruction>(&decoded);
  return instruction != nullptr && instruction->row->operation == isa::Operation::reti;
}

std::vector<Frame> call_stack(Debuggee& debuggee, std::size_t n, const ProgramView& program) {
  const c40::Chip& chip = debuggee.chip(n);
  std::vector<Frame> frames{{chip.pc(), std::nullopt, 0}};
  const auto sp = static_cast<Address>(chip.register_value(Register::SP));
  const auto r11 = static_cast<Address>(chip.register_value(Register::R11));
  if (const auto at = call_before(debuggee, n, program, r11, chip.pc(), true))
    frames.push_back({*at, std::nullopt, r11});
  for (Address depth = 0; depth < deepest_look && frames.size() < most_frames; ++depth) {
    const auto word = debuggee.peek(n, sp - depth);
    if (!word) break;
    const Address below = frames.back().pc;
    for (const bool delayed : {false, true})
      if (const auto at = call_before(debuggee, n, program, *word, below, delayed);
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
