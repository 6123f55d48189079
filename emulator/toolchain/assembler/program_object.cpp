// The end of an assembly without addresses: the linker assigns them.
#include <fmt/format.h>

#include <algorithm>

#include "toolchain/assembler/program.hpp"
#include "toolchain/encoder/operand_encoder.hpp"

namespace toolchain {

constexpr Address most_alignment = 1 << 15;  // COFF has four bits for the exponent.

/// The usual sections are included only if they have contents or a symbol.
bool Program::goes_into_object(std::size_t section) const {
  if (sections_[section].size != 0 || section > 2) return true;
  for (const auto& [name, symbol] : symbols_)
    if (const auto* value = std::get_if<Value>(&symbol.meaning))
      if (value->section == static_cast<int>(section)) return true;
  return false;
}

Object Program::finish_object(Image& listed, std::vector<Diagnostic>& diagnostics) {
  stage_ = Stage::relocatable;
  listed.warnings = warnings_;
  listed.dialects = dialects_;
  listed.files_read = files_read_;
  Object object;
  object.cpu = listed.cpu = options_.cpu;
  std::vector<int> numbers(sections_.size(), -1);  // In the object.
  std::vector<WordRelocations> relocations(sections_.size());
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const Section& section = sections_[i];
    if (!goes_into_object(i)) continue;
    numbers[i] = static_cast<int>(object.sections.size());
    encode_section(section, listed, diagnostics, &relocations[i]);
    ObjectSection& out = object.sections.emplace_back();
    out.name = section.name;
    out.size = section.size;
    out.loaded = section.load == Load::loaded;
    out.alignment = section.alignment;
    out.blocked = section.blocked;
    if (section.alignment > most_alignment)
      diagnostics.push_back(about_section(
          section, fmt::format("the section '{}' is aligned to {} words; an object holds alignments up to {}",
                               section.name, section.alignment, most_alignment)));
    if (section.size != 0) out.words = listed.sections.back().words;
    for (const LineRecord& line : listed.lines)
      if (section.size != 0 && line.section + 1 == listed.sections.size())
        out.lines.push_back({line.address - listed.sections.back().address, line.file, line.line});
  }
  object.files = listed.files;
  add_object_symbols(object, numbers, diagnostics);
  for (std::size_t i = 0; i < sections_.size(); ++i)
    for (const WordRelocation& wanted : relocations[i])
      object.sections[static_cast<std::size_t>(numbers[i])].relocations.push_back(relocation(object, numbers, wanted));
  return object;
}

/// First the sections' own symbols, then the others by name, then the external ones.
void Program::add_object_symbols(Object& object, const std::vector<int>& numbers,
                                 std::vector<Diagnostic>& diagnostics) {
  for (std::size_t i = 0; i < object.sections.size(); ++i)
    object.symbols.push_back({.name = object.sections[i].name,
                              .value = 0,
                              .section = static_cast<int>(i),
                              .global = false,
                              .stands_for_section = true});
  for (const auto& [name, symbol] : symbols_) {
    try {
      const Value value = value_of(name, symbol.offset);
      if (name.find('?') != std::string::npos) continue;
      const bool global = globals_.contains(name);
      if (global) check_global(name, value, symbol.offset);
      if (value.is_external() || value.half != Value::Half::none) continue;  // no symbol can say what it is
      const auto single = value.is_real() ? to_single(value.real) : std::optional<Word>(0);
      if (!single) continue;
      object.symbols.push_back({.name = name,
                                .value = value.is_real() ? *single : static_cast<Word>(value.integer),
                                .section = value.is_absolute() ? ObjectSymbol::absolute : numbers[index(value.section)],
                                .global = global,
                                .stands_for_section = false});
    } catch (const LineError& error) {
      if (symbol.line) diagnostics.push_back(make_diagnostic(*symbol.line, error.offset, error.message));
    }
  }
  check_globals(diagnostics);
  first_external_ = object.symbols.size();
  object.symbols.resize(first_external_ + externals_.size());
  for (const auto& [name, number] : externals_)
    object.symbols[first_external_ + index(number)] = {
        .name = name, .value = 0, .section = ObjectSymbol::undefined, .global = true, .stands_for_section = false};
}

/// Other objects see an address in a section, or an integer of 32 bits.
void Program::check_global(const std::string& name, const Value& value, std::size_t offset) {
  if (value.is_real())
    throw LineError{offset, fmt::format("'{}' is a float; other objects can see addresses and integers", name)};
  if (value.half != Value::Half::none)
    throw LineError{offset,
                    fmt::format("'{}' is half of an address that the linker assigns; it cannot be global", name)};
  if (value.is_external())
    throw LineError{offset,
                    fmt::format("'{}' is defined through a symbol of another object; it cannot be global", name)};
  if (value.is_absolute() && !fits_signed(value.integer, 32) && !fits_unsigned(value.integer, 32))
    throw LineError{offset, fmt::format("'{}' is {}: other objects can see 32 bits of it", name, value.integer)};
}

/// A branch refers to a symbol exactly at its target, so that 16 bits always hold the rest of the distance; so does an
/// immediate whose number beside the section's address has more than 16 bits. All other relocations refer to the
/// section's own symbol.
Relocation Program::relocation(Object& object, const std::vector<int>& numbers, const WordRelocation& wanted) const {
  const Value& target = wanted.field.target;
  const auto value = static_cast<Word>(target.integer);
  Relocation out{.offset = wanted.offset, .type = wanted.field.type, .symbol = 0, .low = 0};
  if (out.type == RelocationType::partms16) out.low = value & 0xFFFF;
  const auto found = [&](auto suits) {
    const auto at = std::find_if(object.symbols.begin(), object.symbols.end(), suits);
    out.symbol = static_cast<int>(at - object.symbols.begin());
    return at != object.symbols.end();
  };
  if (target.is_external()) {
    out.symbol = static_cast<int>(first_external_) + target.external_number();
    return out;
  }
  const int section = target.is_absolute() ? ObjectSymbol::absolute : numbers[index(target.section)];
  const bool too_far = out.type == RelocationType::relword && !fits_signed(target.integer, width(out.type));
  if (!is_relative(out.type) && !too_far) {
    found([&](const ObjectSymbol& s) { return s.stands_for_section && s.section == section; });
    return out;
  }
  if (!found([&](const ObjectSymbol& s) { return s.section == section && s.value == value; })) {
    object.symbols.push_back({.name = name_for_relocations(object, section, value),
                              .value = value,
                              .section = section,
                              .global = false,
                              .stands_for_section = false});
  }
  return out;
}

}  // namespace toolchain
