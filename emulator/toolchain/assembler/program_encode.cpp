// The addresses of sections, and the words in them.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "toolchain/assembler/checks.hpp"
#include "toolchain/assembler/program.hpp"
#include "toolchain/objects/section_places.hpp"

namespace toolchain {

/// As the linker does: nothing is put where a section with an address lies. Such a section moves those after it; an
/// empty one lies behind the one before it.
void Program::place(std::vector<Diagnostic>& diagnostics) {
  std::uint64_t from = usual_address, end = from;
  std::vector<Extent> taken;
  for (const Section& section : sections_)
    if (const auto wanted = options_.sections.find(section.name); wanted != options_.sections.end())
      taken.push_back({wanted->second, section.size});
  std::vector<Section*> placed;
  for (Section* section : placement_order()) {
    const auto wanted = options_.sections.find(section->name);
    std::uint64_t at = aligned(end, section->alignment);
    if (wanted != options_.sections.end())
      at = from = end = wanted->second;
    else if (section->size != 0)
      at = free_place(from, section->size, section->alignment, section->blocked, taken);
    if (at > 0xFFFFFFFF && section->size != 0) {
      diagnostics.push_back(
          about_section(*section, fmt::format("no address is left for the section '{}' behind 0ffffffffh; --section "
                                              "gives it another place",
                                              section->name)));
      continue;
    }
    section->address = static_cast<Address>(at);
    placed.push_back(section);
    if (section->size != 0) {
      end = at + section->size;
      if (wanted != options_.sections.end())
        from = end;
      else
        taken.push_back({at, section->size});
    }
    const SourceLine nowhere = of_option("--section", section->name);
    const auto complain = [&](std::string message) {
      diagnostics.push_back(make_diagnostic(nowhere, 0, std::move(message)));
    };
    if (section->address % section->alignment != 0)
      complain(fmt::format("the section '{}' at {:x}h must be aligned to {} words", section->name, section->address,
                           section->alignment));
    if (section->blocked && is_split(section->address, section->size))
      complain(fmt::format("the section '{}' ({} words at {:x}h) must lie in one page of 64 K words", section->name,
                           section->size, section->address));
  }
  stage_ = Stage::placed;
  check_overlaps(placed, diagnostics);
}

void Program::encode_float(const FloatItem& item, const Expression& expression, const Value& value,
                           std::vector<Word>& out) {
  const std::size_t before = out.size();
  out.resize(before + (item.format == FloatItem::Format::extended ? 2 : 1));
  if (!value.is_absolute()) throw LineError{expression.offset, "an address; .float takes numbers"};
  const Real real = value.is_real() ? value.real : real_of(value.integer);
  const auto put = [&](std::optional<std::uint64_t> bits, std::string_view format) {
    if (!bits) throw LineError{expression.offset, fmt::format("out of the range of {}", format)};
    return *bits;
  };
  switch (item.format) {
    case FloatItem::Format::single: out[before] = static_cast<Word>(put(to_single(real), "a 32-bit float")); return;
    case FloatItem::Format::ieee:
      out[before] = static_cast<Word>(put(to_ieee(real), "an IEEE single-precision float"));
      return;
    case FloatItem::Format::extended: {
      const std::uint64_t bits = put(to_extended(real), "a 40-bit float");
      out[before] = static_cast<Word>(bits >> 8);
      out[before + 1] = static_cast<Word>(bits);
    }
  }
}

std::vector<Word> Program::encode_item(const Section& section, const Item& item, Image& image,
                                       std::vector<Diagnostic>& diagnostics, WordRelocations* relocations) const {
  if (const auto* fill = std::get_if<FillItem>(&item.content)) return std::vector<Word>(fill->count, fill->value);
  std::vector<Word> words;
  if (const auto* instruction = std::get_if<InstructionItem>(&item.content)) {
    const auto line_of = [&](int half) -> const SourceLine& {
      return half == 1 && instruction->second_line ? *instruction->second_line : *item.line;
    };
    const std::function<void(const LineError&)> warn = [&](const LineError& warning) {
      image.warnings.push_back(make_diagnostic(line_of(warning.half), warning.offset, warning.message, true).format());
    };
    try {
      std::vector<FieldRelocation> fields;
      const EncodeContext context{section.address + item.offset,
                                  *this,
                                  warn,
                                  relocations != nullptr ? &fields : nullptr,
                                  static_cast<int>(&section - sections_.data()),
                                  instruction->dialect,
                                  options_.cpu};
      words.push_back(encode(instruction->first, instruction->second ? &*instruction->second : nullptr, context));
      for (const FieldRelocation& field : fields) relocations->push_back({item.offset, field});
    } catch (const LineError& error) {
      diagnostics.push_back(make_diagnostic(line_of(error.half), error.offset, error.message));
      words.push_back(0);
    }
    return words;
  }
  const auto* floats = std::get_if<FloatItem>(&item.content);
  for (const Expression& expression : floats != nullptr ? floats->values : std::get<WordItem>(item.content).values) {
    words.push_back(0);
    try {
      const Value value = evaluate(expression, *this);
      if (floats != nullptr) {
        words.pop_back();
        encode_float(*floats, expression, value, words);
        continue;
      }
      const Address offset = item.offset + static_cast<Address>(words.size() - 1);
      words.back() = plain_word(expression, value, offset, relocations);
    } catch (const LineError& error) {
      diagnostics.push_back(make_diagnostic(*item.line, error.offset, error.message));
    }
  }
  return words;
}

Word Program::plain_word(const Expression& expression, const Value& value, Address offset,
                         WordRelocations* relocations) const {
  if (value.is_real()) throw LineError{expression.offset, "a float; use .float, or single(x) for its word"};
  if (!value.is_absolute() && value.half == Value::Half::none && std::abs(value.integer) >= std::int64_t{1} << 32)
    throw LineError{expression.offset, fmt::format("{} beside an address does not fit in 32 bits", value.integer)};
  if (relocations != nullptr && !value.is_absolute()) {
    const auto address = static_cast<Word>(value.integer);
    const bool high = value.half == Value::Half::high, low = value.half == Value::Half::low;
    relocations->push_back({offset,
                            {high  ? RelocationType::partms16
                             : low ? RelocationType::partls16
                                   : RelocationType::rellong,
                             value}});
    return high ? address >> 16 : low ? address & 0xFFFF : address;
  }
  const std::int64_t number = number_of(value);
  if (number < -(std::int64_t{1} << 31) || number >= std::int64_t{1} << 32)
    throw LineError{expression.offset, fmt::format("{} does not fit in 32 bits", number)};
  return static_cast<Word>(number);
}

/// Warns about instructions at places where they do not work.
void Program::check_run(std::span<const Item> items, const Image::Section& section, Image& image) {
  if (items.empty()) return;
  const auto words = std::span(section.words).subspan(items.front().offset, items.size());
  for (const Finding& finding : check_code(words, section.address + items.front().offset, image.cpu)) {
    const SourceLine& line = *items[finding.index].line;
    const auto first = line.text.find_first_not_of(" \t");
    image.warnings.push_back(
        make_diagnostic(line, first == std::string::npos ? 0 : first, finding.message, true).format());
  }
}

void Program::encode_section(const Section& section, Image& image, std::vector<Diagnostic>& diagnostics,
                             WordRelocations* relocations) const {
  if (section.size == 0) return;
  Image::Section out{section.name, section.address, section.size, {}, section.load == Load::loaded};
  if (!out.loaded) {
    image.sections.push_back(std::move(out));
    return;
  }
  std::size_t run = 0;  // The first of the instructions before this item without a gap.
  for (std::size_t i = 0; i < section.items.size(); ++i) {
    const Item& item = section.items[i];
    if (!std::holds_alternative<InstructionItem>(item.content)) {
      check_run({section.items.data() + run, i - run}, out, image);
      run = i + 1;
    }
    const auto words = encode_item(section, item, image, diagnostics, relocations);
    if (diagnostics.size() > most_errors) break;
    const auto file = std::find(image.files.begin(), image.files.end(), *item.line->file);
    const auto* instruction = std::get_if<InstructionItem>(&item.content);
    const bool parallel = instruction != nullptr && instruction->second_line != nullptr;
    image.lines.push_back({section.address + item.offset, static_cast<std::uint32_t>(file - image.files.begin()),
                           item.line->number, item.line->text, static_cast<std::uint32_t>(image.sections.size()),
                           parallel ? instruction->second_line->text : ""});
    if (file == image.files.end()) image.files.push_back(*item.line->file);
    out.words.insert(out.words.end(), words.begin(), words.end());
  }
  if (diagnostics.size() <= most_errors) check_run(std::span(section.items).subspan(run), out, image);
  image.sections.push_back(std::move(out));
}

}  // namespace toolchain
