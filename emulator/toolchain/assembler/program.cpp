#include "toolchain/assembler/program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "io/nearest.hpp"
#include "toolchain/assembler/checks.hpp"
#include "toolchain/encoder/encoder.hpp"
#include "toolchain/encoder/mnemonics.hpp"
#include "toolchain/objects/section_places.hpp"

namespace toolchain {
namespace {

constexpr Address largest_reserved_section = 0xFFFFFFFF;
constexpr int deepest_definition = 200;
constexpr std::size_t most_names_compared = 2'000'000;  // With undefined symbols; later ones get no suggestion.
constexpr Word nop = 0x0C800000;

std::string place_of(const SourceLine* line) {
  return line == nullptr ? "in the options" : fmt::format("at {}:{}", *line->file, line->number);
}

/// A local label without the number of its scope.
std::string as_written(const std::string& name) {
  const auto mark = name.find('?');
  return mark == std::string::npos ? name : name.substr(0, name[0] == '$' ? mark : mark + 1);
}

/// TI's symbols for the processor and the memory model, in any case (SPRU035 as quoted by GNU as). For the C3x they are
/// those of -v30.
std::optional<std::int64_t> predefined(const std::string& name, isa::Cpu cpu) {
  static const std::map<std::string_view, std::int64_t> c3x{
      {".tms320xx", 30}, {".tms320c40", 0}, {".c4x", 0}, {".c40", 0}, {".tms320c30", 1}, {".c3x", 1}, {".c30", 1}};
  static const std::map<std::string_view, std::int64_t> symbols{
      {".tms320xx", 40}, {".tms320c40", 1}, {".c4x", 1},       {".c40", 1},       {".tms320c44", 0},
      {".c44", 0},       {".tms320c30", 0}, {".tms320c31", 0}, {".tms320c32", 0}, {".tms320c33", 0},
      {".tmx320c40", 0}, {".c3x", 0},       {".c30", 0},       {".c31", 0},       {".c32", 0},
      {".c33", 0},       {".regparm", 0},   {".memparm", 1},   {".bigmodel", 0},  {".c30interrupt", 0}};
  if (name.empty() || name[0] != '.') return std::nullopt;
  if (const auto other = c3x.find(lower(name)); cpu == isa::Cpu::c3x && other != c3x.end()) return other->second;
  const auto found = symbols.find(lower(name));
  return found == symbols.end() ? std::nullopt : std::optional(found->second);
}

bool same(const Value& a, const Value& b) {
  return a.kind == b.kind && a.integer == b.integer && a.section == b.section && a.real.nearest == b.real.nearest &&
         a.real.residue == b.real.residue;
}

/// A symbol needs one that is not defined.
struct UndefinedSymbol : LineError {
  std::string name;
};

}  // namespace

Program::Program(const Options& options) : options_(options) {
  section(".text", Load::loaded, 0);
  section(".data", Load::loaded, 0);
  section(".bss", Load::reserved, 0);
  for (const auto& [name, value] : options.symbols)
    symbols_.insert({name, Symbol{Value::of(std::int64_t{value}), nullptr, 0}});
}

int Program::section(const std::string& name, Load load, std::size_t offset) {
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    if (sections_[i].name != name) continue;
    if (sections_[i].load != load)
      throw LineError{offset, fmt::format("the section '{}' {} contents; it cannot be both", name,
                                          sections_[i].load == Load::loaded ? "has" : "has no")};
    return static_cast<int>(i);
  }
  sections_.push_back({.name = name, .load = load, .items = {}});
  return static_cast<int>(sections_.size() - 1);
}

void Program::define(const std::string& name, const Value& value, const SourceLinePtr& line, std::size_t offset) {
  const auto [found, fresh] = symbols_.insert({name, Symbol{value, line, offset}});
  if (fresh) return;
  // A constant may be defined twice with the same value (a file included twice), but not changed.
  const Value* old = std::get_if<Value>(&found->second.meaning);
  if (old != nullptr && old->is_absolute() && value.is_absolute() && same(*old, value)) return;
  throw LineError{offset,
                  fmt::format("'{}' is defined already {}", as_written(name), place_of(found->second.line.get()))};
}

void Program::define(const std::string& name, Expression expression, const SourceLinePtr& line, std::size_t offset) {
  std::optional<Value> value;
  trying_ = true;
  try {
    value = evaluate(expression, *this);
  } catch (const LineError&) {
    // The value may need later definitions; finish() reports errors.
  }
  trying_ = false;
  if (value) return define(name, *value, line, offset);
  const auto [found, fresh] = symbols_.insert({name, Symbol{std::move(expression), line, offset}});
  if (!fresh)
    throw LineError{offset,
                    fmt::format("'{}' is defined already {}", as_written(name), place_of(found->second.line.get()))};
}

void Program::declare_global(const std::string& name, bool must_be_defined, const SourceLinePtr& line,
                             std::size_t offset) {
  globals_.insert({name, Global{line, offset, must_be_defined}});
}

void Program::grow(Section& section, Address words, std::size_t offset) {
  const Address largest = section.load == Load::loaded ? largest_loaded_section : largest_reserved_section;
  if (words > largest || section.size > largest - words)
    throw LineError{offset, fmt::format("the section '{}' would pass {} words", section.name, largest)};
  section.size += words;
}

void Program::add(const SourceLinePtr& line, std::size_t offset, Item::Content content) {
  Section& section = sections_[index(current_)];
  if (section.load == Load::reserved && !std::holds_alternative<FillItem>(content))
    throw LineError{offset, fmt::format("the section '{}' is not loaded: it takes .space, no contents", section.name)};
  Address words = 1;
  if (const auto* w = std::get_if<WordItem>(&content)) words = static_cast<Address>(w->values.size());
  if (const auto* f = std::get_if<FloatItem>(&content)) words = f->words();
  if (const auto* fill = std::get_if<FillItem>(&content)) words = fill->count;
  parallel_target_ = std::holds_alternative<InstructionItem>(content);
  field_bits_ = 0;
  const Address start = section.size;
  grow(section, words, offset);
  if (words > 0) section.items.push_back({line, start, std::move(content)});
}

Value Program::field_place(Address bits) const {
  Value place = here();
  if (field_bits_ != 0 && field_bits_ + bits <= 32) --place.integer;
  return place;
}

void require_alignment(Address words, std::size_t offset) {
  if (!std::has_single_bit(words)) throw LineError{offset, "an alignment is a power of 2, in words"};
}

void Program::add_field(const SourceLinePtr& line, std::size_t offset, Expression value, Address bits) {
  if (field_bits_ == 0 || field_bits_ + bits > 32) {
    WordItem item;
    item.values.push_back(std::move(value));
    add(line, offset, std::move(item));
    field_bits_ = bits;
    return;
  }
  auto& word = std::get<WordItem>(sections_[index(current_)].items.back().content).values.back();
  word.value.integer |= value.value.integer << field_bits_;
  field_bits_ += bits;
}

void Program::warn(const SourceLinePtr& line, std::size_t offset, const std::string& message) {
  warnings_.push_back(make_diagnostic(*line, offset, message, true).format());
}

void Program::align(const SourceLinePtr& line, std::size_t offset, Address words) {
  require_alignment(words, offset);
  Section& section = sections_[index(current_)];
  section.alignment = std::max(section.alignment, words);
  const Address gap = (words - section.size % words) % words;
  add(line, offset, FillItem{gap, section.name == ".text" ? nop : 0});
}

void Program::add_parallel(HalfSyntax half, const SourceLinePtr& line, std::size_t offset) {
  Section& section = sections_[index(current_)];
  auto* instruction = section.items.empty() ? nullptr : std::get_if<InstructionItem>(&section.items.back().content);
  if (!parallel_target_ || instruction == nullptr) throw LineError{offset, "'||' has no instruction before it"};
  if (instruction->second) throw LineError{offset, "an instruction has two parallel halves, not three"};
  instruction->second = std::move(half);
  instruction->second_line = line;
}

Value Program::reserve(int section_number, Address words, Address alignment, std::size_t offset) {
  Section& section = sections_[index(section_number)];
  require_alignment(alignment, offset);
  section.alignment = std::max(section.alignment, alignment);
  grow(section, (alignment - section.size % alignment) % alignment, offset);
  const Value place = Value::at(section_number, section.size);
  grow(section, words, offset);
  return place;
}

bool Program::is_defined(const std::string& name) const { return symbols_.contains(name) || predefined_value(name); }

/// An option gives the symbol another value, in any case of letters too.
std::optional<std::int64_t> Program::predefined_value(const std::string& name) const {
  const auto usual = predefined(name, options_.cpu);
  if (usual)
    for (const auto& [given, value] : options_.symbols)
      if (lower(given) == lower(name)) return value;
  return usual;
}

Value Program::value_of(const std::string& name, std::size_t offset) const {
  const auto found = symbols_.find(name);
  if (found == symbols_.end()) {
    if (const auto value = predefined_value(name)) return Value::of(*value);
  }
  // A register of the other processor is not taken as a symbol of another object, unless the source declares it.
  const bool taken_as_external = undefined_external_ && register_of_other(name, options_.cpu).empty();
  if (found == symbols_.end() && stage_ == Stage::relocatable && (globals_.contains(name) || taken_as_external)) {
    return Value::external(externals_.insert({name, static_cast<int>(externals_.size())}).first->second);
  }
  if (found == symbols_.end()) throw UndefinedSymbol{{offset, undefined(name)}, name};
  const Symbol& symbol = found->second;
  if (const auto* value = std::get_if<Value>(&symbol.meaning)) return settled(*value);
  const auto fail = [&](const Problem& problem) {
    std::string message = problem.undefined.empty() ? problem.message : undefined(problem.undefined);
    if (evaluation_depth_ == 0) message += fmt::format(" (in '{}', defined {})", name, place_of(symbol.line.get()));
    if (problem.undefined.empty()) throw LineError{offset, std::move(message)};
    throw UndefinedSymbol{{offset, std::move(message)}, problem.undefined};
  };
  if (const Evaluated* before = known(symbol)) {
    if (const auto* value = std::get_if<Value>(&before->result)) return *value;
    fail(std::get<Problem>(before->result));
  }
  if (symbol.busy) throw LineError{offset, fmt::format("'{}' is defined in terms of itself", name)};
  if (evaluation_depth_ >= deepest_definition)
    throw LineError{offset,
                    fmt::format("'{}' is defined through more than {} other symbols", name, deepest_definition)};
  symbol.busy = true;
  ++evaluation_depth_;
  Evaluated now{Problem{}, stage_};
  try {
    now.result = evaluate(std::get<Expression>(symbol.meaning), *this);
  } catch (const UndefinedSymbol& error) {
    now.result = Problem{{}, error.name};
  } catch (const LineError& error) {
    now.result = Problem{error.message, {}};
  }
  symbol.busy = false;
  --evaluation_depth_;
  symbol.found = std::move(now);
  if (const auto* problem = std::get_if<Problem>(&symbol.found->result)) fail(*problem);
  return std::get<Value>(symbol.found->result);
}

Value Program::settled(const Value& value) const {
  return is_placed() && value.half != Value::Half::none ? Value::of(number_of(value)) : value;
}

const Program::Evaluated* Program::known(const Symbol& symbol) const {
  if (!symbol.found || symbol.found->stage != stage_) return nullptr;
  const auto* problem = std::get_if<Problem>(&symbol.found->result);
  if (problem != nullptr && !problem->undefined.empty() && is_defined(problem->undefined)) return nullptr;
  return &*symbol.found;
}

std::string Program::undefined(const std::string& name) const {
  if (trying_) return {};
  return fmt::format("undefined symbol '{}'{}", as_written(name),
                     globals_.contains(name)
                         ? ", which another object is to define (emulator asm --object, emulator link)"
                         : symbol_near(name));
}

std::string Program::symbol_near(const std::string& name) const {
  if (std::string other = register_of_other(name, options_.cpu); !other.empty()) return other;
  if (const auto before = suggestions_.find(name); stage_ != Stage::reading && before != suggestions_.end())
    return before->second;
  if (names_compared_ >= most_names_compared) return {};
  names_compared_ += symbols_.size();
  std::vector<std::string_view> names;
  for (const auto& [known, symbol] : symbols_)
    if (as_written(known) == known) names.push_back(known);  // no local label: its name is not what the source has
  std::string near = io::suggestion(io::nearest(name, names, io::most_wrong(name)), '\'');
  if (stage_ != Stage::reading) suggestions_[name] = near;  // all symbols are known
  return near;
}

std::vector<Program::Section*> Program::placement_order() {
  const auto rank = [](const Section& s) { return placement_rank(s.name, s.load == Load::loaded); };
  std::vector<Section*> order;
  for (Section& section : sections_) order.push_back(&section);
  std::stable_sort(order.begin(), order.end(), [&](const Section* a, const Section* b) { return rank(*a) < rank(*b); });
  return order;
}

Diagnostic Program::about_section(const Section& section, std::string message) {
  const SourceLine nowhere = of_option("--section", section.name);
  return make_diagnostic(section.items.empty() ? nowhere : *section.items.front().line, 0, std::move(message));
}

void Program::check_overlaps(const std::vector<Section*>& order, std::vector<Diagnostic>& diagnostics) const {
  const auto complain = [&](const Section& s, std::string message) {
    diagnostics.push_back(about_section(s, std::move(message)));
  };
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Section& a = *order[i];
    if (std::uint64_t{a.address} + a.size > isa::address_space(options_.cpu))
      complain(a, fmt::format("the section '{}' ({} words at {:x}h) passes the end of the address space{}", a.name,
                              a.size, a.address, options_.cpu == isa::Cpu::c3x ? " of the C3x, 0FFFFFFh" : ""));
    for (std::size_t k = i + 1; k < order.size(); ++k) {
      const Section& b = *order[k];
      if (a.size == 0 || b.size == 0 || a.address - b.address >= b.size) {
        if (a.size == 0 || b.size == 0 || b.address - a.address >= a.size) continue;
      }
      complain(b, fmt::format("the sections '{}' ({} words at {:x}h) and '{}' ({} words at {:x}h) overlap", a.name,
                              a.size, a.address, b.name, b.size, b.address));
    }
  }
}

void Program::export_symbols(Image& image, std::vector<Diagnostic>& diagnostics) const {
  for (const auto& [name, symbol] : symbols_) {
    try {
      const Value value = value_of(name, symbol.offset);
      if (name.find('?') != std::string::npos) continue;
      if (value.is_real()) {
        const auto single = to_single(value.real);
        if (single) image.symbols[name] = *single;
        continue;
      }
      image.symbols[name] = static_cast<Word>(number_of(value));
    } catch (const LineError& error) {
      if (symbol.line) diagnostics.push_back(make_diagnostic(*symbol.line, error.offset, error.message));
    }
  }
  check_globals(diagnostics);
}

void Program::check_globals(std::vector<Diagnostic>& diagnostics) const {
  for (const auto& [name, global] : globals_)
    if (global.must_be_defined && !symbols_.contains(name))
      diagnostics.push_back(
          make_diagnostic(*global.line, global.offset, fmt::format("'{}' is not defined in this program", name)));
}

Address Program::entry_point(const Image& image, std::vector<Diagnostic>& diagnostics) const {
  if (!options_.entry.empty()) {
    const auto found = image.symbols.find(options_.entry);
    if (found != image.symbols.end()) return found->second;
    diagnostics.push_back(make_diagnostic(of_option("--entry", options_.entry), 0,
                                          fmt::format("the entry symbol '{}' is not defined", options_.entry)));
  }
  for (const std::string_view name : usual_entries) {
    const auto found = symbols_.find(name);
    if (found == symbols_.end()) continue;
    try {
      const Value value = value_of(found->first, 0);
      if (value.is_address() && sections_[index(value.section)].load == Load::loaded)
        return static_cast<Address>(number_of(value));
    } catch (const LineError&) {
      // export_symbols() has reported it.
    }
  }
  return sections_[0].address;
}

Image Program::finish(std::vector<Diagnostic>& diagnostics) {
  Image image;
  image.cpu = options_.cpu;
  image.warnings = warnings_;
  image.dialects = dialects_;
  image.files_read = files_read_;
  for (const auto& placed : options_.sections)
    if (std::ranges::find(sections_, placed.first, &Section::name) == sections_.end())
      image.warnings.push_back(fmt::format(
          "warning: an address is given for the section '{}', and the program has no such section", placed.first));
  place(diagnostics);
  for (const Section& section : sections_) encode_section(section, image, diagnostics, nullptr);
  export_symbols(image, diagnostics);
  image.entry = entry_point(image, diagnostics);
  return image;
}

}  // namespace toolchain
