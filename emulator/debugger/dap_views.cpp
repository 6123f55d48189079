// The client's views: frames, variables, memory, instructions, sources.
#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>

#include "debugger/dap_session.hpp"
#include "isa/ascii.hpp"
#include "isa/types.hpp"
#include "machine/debug/expression.hpp"

namespace debugger::dap {

namespace core_ns = machine::debug;
using core_ns::Address;
using core_ns::DebugError;
using core_ns::Expression;
using core_ns::ShownRegister;
using core_ns::Word;

namespace {

constexpr std::int64_t frames_of_a_chip = 1000;
constexpr std::int64_t most_words = 1 << 20, most_instructions = 65536;

std::int64_t number_of(const Json& from, std::string_view key, std::int64_t otherwise) {
  const auto found = from.find(key);
  if (found == from.end() || found->is_null()) return otherwise;
  if (!found->is_number_integer()) throw DebugError(fmt::format("{}: an integer is expected", key));
  const auto number = found->get<std::int64_t>();
  constexpr std::int64_t far = std::int64_t{1} << 40;
  if (number < -far || number > far) throw DebugError(fmt::format("{}: {} is out of range", key, number));
  return number;
}

std::string base64(const std::vector<unsigned char>& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  const int length = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), bytes.data(),
                                     static_cast<int>(bytes.size()));  // NOLINT: OpenSSL's bytes
  text.resize(static_cast<std::size_t>(length));
  return text;
}

std::vector<unsigned char> from_base64(const std::string& text) {
  std::vector<unsigned char> bytes(3 * (text.size() / 4) + 1);
  const int length = text.size() % 4 != 0
                         ? -1
                         : EVP_DecodeBlock(bytes.data(), reinterpret_cast<const unsigned char*>(text.data()),
                                           static_cast<int>(text.size()));  // NOLINT
  if (length < 0) throw DebugError("data: base64 is expected");
  bytes.resize(static_cast<std::size_t>(length) - (text.ends_with("==") ? 2 : text.ends_with('=') ? 1 : 0));
  return bytes;
}

std::string hex_of(Address address) { return fmt::format("0x{:08X}", address); }

}  // namespace

std::string Session::reference(Place place) const {
  return debugger_->programs().size() == 1 ? hex_of(place.address)
                                           : fmt::format("{}:{}", place.chip, hex_of(place.address));
}

std::string Session::path_to_client(const std::string& path) const {
  if (!paths_are_uris_ || !path.starts_with('/')) return path;
  std::string uri = "file://";
  for (const char c : path) {
    const bool plain = ascii::is_letter_or_digit(c) || std::string_view("/-._~").find(c) != std::string_view::npos;
    uri += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri;
}

std::string Session::path_from_client(const std::string& path) const {
  constexpr std::string_view scheme = "file://";
  if (!paths_are_uris_ || !path.starts_with(scheme)) return path;
  std::string plain;
  for (std::size_t i = std::min(path.find('/', scheme.size()), path.size()); i < path.size(); ++i) {
    const bool escape = path[i] == '%' && i + 2 < path.size();
    const auto code = escape ? ascii::number<unsigned>(path.substr(i + 1, 2), 16) : std::nullopt;
    if (code)
      plain += static_cast<char>(*code), i += 2;
    else
      plain += path[i];
  }
  return plain;
}

/// A file on disk by its path; another one, such as a built-in one, by a number.
Json Session::source_of(std::size_t chip, const std::string& file) {
  const std::size_t slash = file.find_last_of('/');
  const std::string name = slash == std::string::npos ? file : file.substr(slash + 1);
  const auto& program = core().program(chip);
  if (const std::string path = program.path(file); !path.empty())
    return {{"name", name}, {"path", path_to_client(path)}};
  auto found = std::ranges::find_if(sources_, [&](const BuiltIn& one) {
    return one.file == file && &core().program(one.chip).image() == &program.image();
  });
  if (found == sources_.end()) found = sources_.insert(sources_.end(), {chip, file});
  return {{"name", name}, {"path", file}, {"sourceReference", found - sources_.begin() + 1}, {"origin", "built in"}};
}

Json Session::threads(const Json&) {
  Json all = Json::array();
  if (debugger_ != nullptr)
    for (std::size_t n = 0; n < debugger_->programs().size(); ++n)
      all.push_back(
          {{"id", n + 1},
           {"name", fmt::format("{}: {}", debugger_->debuggee().chip_name(n), debugger_->debuggee().describe(n))
                        .substr(0, 120)}});
  return {{"threads", all}};
}

Json Session::stack_trace(const Json& arguments) {
  const std::size_t chip = chip_of(arguments);
  const auto& program = core().program(chip);
  const auto all = core_ns::call_stack(core().debuggee(), chip, program);
  const auto first = static_cast<std::size_t>(std::max<std::int64_t>(number_of(arguments, "startFrame", 0), 0));
  const std::int64_t levels = number_of(arguments, "levels", 0);
  Json frames = Json::array();
  for (std::size_t i = first; i < all.size() && (levels <= 0 || static_cast<std::int64_t>(i - first) < levels); ++i) {
    const auto place = program.source(all[i].pc);
    Json frame{{"id", static_cast<std::int64_t>(chip) * frames_of_a_chip + static_cast<std::int64_t>(i) + 1},
               {"name", program.name(all[i].pc)},
               {"line", place ? to_client(place->line) : 0},
               {"column", place && columns_from_one_ ? 1 : 0},
               {"instructionPointerReference", reference({chip, all[i].pc})}};
    if (place) frame["source"] = source_of(chip, place->file);
    frames.push_back(std::move(frame));
  }
  return {{"stackFrames", frames}, {"totalFrames", all.size()}};
}

std::size_t Session::chip_of_frame(const Json& arguments) const {
  if (debugger_ == nullptr) throw DebugError("there is no debuggee yet: launch or attach comes first");
  const std::int64_t frame = number_of(arguments, "frameId", 0);
  if (frame == 0) return debugger_->stop().chip.value_or(0);
  const std::int64_t chip = (frame - 1) / frames_of_a_chip;
  if (frame < 0 || chip >= static_cast<std::int64_t>(debugger_->programs().size()))
    throw DebugError(fmt::format("frameId {} does not exist", frame));
  return static_cast<std::size_t>(chip);
}

Json Session::variable(const ShownRegister& reg, bool hex, std::size_t chip) {
  Json out{{"name", reg.name},
           {"value", hex || reg.value.empty() ? reg.hex
                     : reg.parts.empty() || reg.parts.front().first != "float"
                         ? fmt::format("{} ({})", reg.value, reg.hex)
                         : fmt::format("{} (integer {})", reg.value, reg.parts.back().second)},
           {"variablesReference", 0}};
  if (!reg.parts.empty()) {
    shown_.push_back([reg](bool) {
      Json parts = Json::array();
      for (const auto& [name, value] : reg.parts)
        parts.push_back({{"name", name}, {"value", value}, {"variablesReference", 0}});
      parts.push_back({{"name", "hexadecimal"}, {"value", reg.hex}, {"variablesReference", 0}});
      return parts;
    });
    out["variablesReference"] = shown_.size();
  }
  const c40::Chip& of = core().debuggee().chip(chip);
  if (reg.name == "PC")
    out["memoryReference"] = reference({chip, of.pc()});
  else if (reg.name.starts_with("AR") || reg.name == "SP")
    out["memoryReference"] = reference({chip, static_cast<Address>(of.register_value(*isa::register_named(reg.name)))});
  return out;
}

Json Session::scopes(const Json& arguments) {
  const std::size_t chip = chip_of_frame(arguments);
  Json all = Json::array();
  const auto add = [&](const std::string& name, bool expensive, std::function<Json(bool)> make) {
    shown_.push_back(std::move(make));
    all.push_back({{"name", name}, {"variablesReference", shown_.size()}, {"expensive", expensive}});
    return static_cast<std::int64_t>(shown_.size());
  };
  const auto list = [this, chip](const std::vector<ShownRegister>& registers, bool hex) {
    Json out = Json::array();
    for (const ShownRegister& reg : registers) out.push_back(variable(reg, hex, chip));
    return out;
  };
  registers_shown_[add("Registers", false, [this, chip, list](bool hex) {
    return list(core_ns::registers(core().debuggee().chip(chip)), hex);
  })] = {chip, false};
  all.back()["presentationHint"] = "registers";
  registers_shown_[add("Peripherals", true, [this, chip, list](bool hex) {
    return list(core_ns::peripherals(core().debuggee().chip(chip)), hex);
  })] = {chip, true};
  for (const std::string& page : core().debuggee().page_names())
    add(page, true, [this, page](bool) {
      Json lines = Json::array();
      const std::string text = core().debuggee().page(page);
      for (std::size_t at = 0, n = 1; at < text.size(); ++n) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        lines.push_back(
            {{"name", fmt::format("{}", n)}, {"value", text.substr(at, end - at)}, {"variablesReference", 0}});
        at = end + 1;
      }
      return lines;
    });
  return {{"scopes", all}};
}

Json Session::variables(const Json& arguments) {
  const std::int64_t number = number_of(arguments, "variablesReference", 0);
  if (number < 1 || number > static_cast<std::int64_t>(shown_.size()))
    throw DebugError(fmt::format("variablesReference {}: it does not exist, or the machine has run since", number));
  const auto format = arguments.find("format");
  const auto make = shown_[static_cast<std::size_t>(number - 1)];  // the call may add further ones
  Json all = make(format != arguments.end() && format->value("hex", false));
  const auto first = static_cast<std::size_t>(
      std::clamp<std::int64_t>(number_of(arguments, "start", 0), 0, static_cast<std::int64_t>(all.size())));
  const std::int64_t count = number_of(arguments, "count", 0);
  const std::size_t last = count <= 0 ? all.size() : std::min(all.size(), first + static_cast<std::size_t>(count));
  return {{"variables",
           Json(all.begin() + static_cast<std::ptrdiff_t>(first), all.begin() + static_cast<std::ptrdiff_t>(last))}};
}

Json Session::set_variable(const Json& arguments) {
  const auto found = registers_shown_.find(number_of(arguments, "variablesReference", 0));
  if (found == registers_shown_.end() || found->second.of_peripherals)
    throw DebugError("only registers of a processor can be set here; use the memory view for memory");
  const std::string name = text_of(arguments, "name");
  const std::size_t chip = found->second.chip;
  core().set_register(chip, name, text_of(arguments, "value"));
  const auto format = arguments.find("format");
  const bool hex = format != arguments.end() && format->value("hex", false);
  for (const ShownRegister& reg : core_ns::registers(core().debuggee().chip(chip)))
    if (reg.name == name) {
      Json answer = variable(reg, hex, chip);
      answer.erase("name");
      return answer;
    }
  return {{"value", text_of(arguments, "value")}};
}

Json Session::evaluate(const Json& arguments) {
  const std::size_t chip = chip_of_frame(arguments);
  const auto value = Expression(text_of(arguments, "expression"), core().debuggee(), core().programs(), chip).value();
  Json body{{"result", value.text()}, {"type", value.is_float ? "float" : "word"}, {"variablesReference", 0}};
  if (value.address) body["memoryReference"] = reference({value.chip.value_or(chip), *value.address});
  return body;
}

Session::Place Session::place_of(const Json& arguments, std::string_view key) const {
  if (debugger_ == nullptr) throw DebugError("there is no debuggee yet: launch or attach comes first");
  const std::string text = text_of(arguments, key);
  const std::size_t colon = text.find(':');
  const std::size_t chips = debugger_->programs().size();
  const auto chip = colon == std::string::npos ? std::optional(static_cast<Address>(debugger_->stop().chip.value_or(0)))
                                               : toolchain::find_address(text.substr(0, colon), nullptr);
  const auto address = toolchain::find_address(text.substr(colon == std::string::npos ? 0 : colon + 1), nullptr);
  if (!chip || *chip >= chips || !address)
    throw DebugError(fmt::format("{} \"{}\": an address such as 0x00300000{} is expected", key, text,
                                 chips == 1 ? "" : ", or 1:0x00300000 of chip 1,"));
  return {*chip, *address + static_cast<Address>(number_of(arguments, "offset", 0))};
}

/// Addresses count words; so do offsets of instructions.
Json Session::disassemble(const Json& arguments) {
  const auto [chip, base] = place_of(arguments, "memoryReference");
  const Address first = base + static_cast<Address>(number_of(arguments, "instructionOffset", 0));
  const std::int64_t count = number_of(arguments, "instructionCount", 0);
  if (count < 0 || count > most_instructions)
    throw DebugError(fmt::format("instructionCount {}: 0 to {} are possible", count, most_instructions));
  const auto& program = core().program(chip);
  Json all = Json::array();
  for (Address at = first; at != first + static_cast<Address>(count); ++at) {
    const auto word = core().debuggee().peek(chip, at);
    Json row{{"address", hex_of(at)},
             {"instructionBytes", word ? fmt::format("{:08X}", *word) : ""},
             {"instruction", word ? program.disassembled(at, *word) : "(no memory)"}};
    if (!word) row["presentationHint"] = "invalid";
    if (const auto label = program.label_at(at)) row["symbol"] = *label;
    if (const auto place = program.source(at))
      row["location"] = source_of(chip, place->file), row["line"] = to_client(place->line);
    all.push_back(std::move(row));
  }
  return {{"instructions", all}};
}

/// Four bytes per word, little-endian. If the range begins or ends inside a word, the answer contains the whole word.
Json Session::read_memory(const Json& arguments) {
  Json where = arguments;
  where.erase("offset");
  const std::int64_t offset = number_of(arguments, "offset", 0), count = number_of(arguments, "count", 0);
  if (count < 0 || count > most_words * 4)
    throw DebugError(fmt::format("count {}: 0 to {} bytes are possible", count, most_words * 4));
  const std::int64_t begin = offset >= 0 ? offset / 4 : -((-offset + 3) / 4),
                     end = offset + count >= 0 ? (offset + count + 3) / 4 : -(-(offset + count) / 4);
  const auto [chip, base] = place_of(where, "memoryReference");
  std::vector<unsigned char> bytes;
  std::int64_t at = begin;
  for (; at < end; ++at) {
    const auto word = core().debuggee().peek(chip, base + static_cast<Address>(at));
    if (!word) break;
    for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<unsigned char>(*word >> 8 * i));
  }
  Json body{{"address", hex_of(base + static_cast<Address>(begin))}, {"data", base64(bytes)}};
  if (at < end) body["unreadableBytes"] = (end - at) * 4;
  return body;
}

Json Session::write_memory(const Json& arguments) {
  Json where = arguments;
  where.erase("offset");
  const std::int64_t offset = number_of(arguments, "offset", 0);
  const std::vector<unsigned char> bytes = from_base64(text_of(arguments, "data"));
  if (offset % 4 != 0 || bytes.size() % 4 != 0)
    throw DebugError("only whole words can be written: offset and data in multiples of 4 bytes");
  const auto [chip, first] = place_of(where, "memoryReference");
  const Address base = first + static_cast<Address>(offset / 4);
  for (std::size_t i = 0; i < bytes.size(); i += 4) {
    const Word word = bytes[i] | Word{bytes[i + 1]} << 8 | Word{bytes[i + 2]} << 16 | Word{bytes[i + 3]} << 24;
    core().set_word(chip, base + static_cast<Address>(i / 4), word);
  }
  return {{"bytesWritten", bytes.size()}};
}

Json Session::source(const Json& arguments) {
  std::int64_t number = number_of(arguments, "sourceReference", 0);
  if (const auto source = arguments.find("source"); number == 0 && source != arguments.end())
    number = number_of(*source, "sourceReference", 0);
  if (number < 1 || number > static_cast<std::int64_t>(sources_.size()))
    throw DebugError(fmt::format("sourceReference {} does not exist", number));
  const BuiltIn& one = sources_[static_cast<std::size_t>(number - 1)];
  return {{"content", core().program(one.chip).file_text(one.file)}, {"mimeType", "text/x-asm"}};
}

Json Session::loaded_sources(const Json&) {
  Json all = Json::array();
  for (std::size_t chip = 0; chip < core().programs().size(); ++chip)
    for (const std::string& file : core().program(chip).files())
      if (Json source = source_of(chip, file); std::ranges::find(all, source) == all.end())
        all.push_back(std::move(source));
  return {{"sources", all}};
}

Json Session::exception_info(const Json& arguments) {
  chip_of(arguments);
  const auto& stop = core().stop();
  return {
      {"exceptionId", std::string(core_ns::name(stop.reason))}, {"description", stop.text}, {"breakMode", "always"}};
}

}  // namespace debugger::dap
