#pragma once
// What the assembler collects while it reads: sections of items with addresses relative to their section, and symbols.
// At the end the sections get addresses and the items get words.
#include <map>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "toolchain/assembler/assembler.hpp"
#include "toolchain/encoder/encoder.hpp"
#include "toolchain/syntax/expression.hpp"
#include "toolchain/syntax/parser.hpp"

namespace toolchain {

struct InstructionItem {
  HalfSyntax first;
  std::optional<HalfSyntax> second;
  SourceLinePtr second_line;
  Dialect dialect = Dialect::ti;
};
struct WordItem {
  std::vector<Expression> values;
};
struct FloatItem {
  std::vector<Expression> values;
  enum class Format : std::uint8_t {
    single,    ///< The 32-bit format of the C4x.
    ieee,      ///< IEEE 754 single precision.
    extended,  ///< The 40-bit format in two words: the words that STF and STI store of a register.
  } format = Format::single;
  Address words() const { return static_cast<Address>(values.size()) * (format == Format::extended ? 2 : 1); }
};
struct FillItem {
  Address count = 0;
  Word value = 0;
};

struct Item {
  using Content = std::variant<InstructionItem, WordItem, FloatItem, FillItem>;
  SourceLinePtr line;
  Address offset = 0;
  Content content;
};

/// \throws LineError at `offset`
void require_alignment(Address words, std::size_t offset);

class Program final : public SymbolSource {
 public:
  explicit Program(const Options& options);

  // Sections

  enum class Load : std::uint8_t { loaded, reserved };
  /// Finds or makes the section. Throws LineError if it exists with the other kind of contents.
  int section(const std::string& name, Load load, std::size_t offset);
  void select(int section) {
    current_ = section;
    parallel_target_ = false;
    field_bits_ = 0;
  }
  int current() const { return current_; }
  Value here() const { return Value::at(current_, sections_[index(current_)].size); }

  // Symbols: errors are LineErrors at `offset` of the line.

  void define(const std::string& name, const Value& value, const SourceLinePtr& line, std::size_t offset);
  /// `.set`: evaluated now if possible, else when all symbols are known.
  void define(const std::string& name, Expression expression, const SourceLinePtr& line, std::size_t offset);
  void declare_global(const std::string& name, bool must_be_defined, const SourceLinePtr& line, std::size_t offset);

  // Contents of the current section

  void add(const SourceLinePtr& line, std::size_t offset, Item::Content content);
  /// The word in which add_field() with this number of bits would put its value.
  Value field_place(Address bits) const;
  void add_field(const SourceLinePtr& line, std::size_t offset, Expression value, Address bits);
  /// The next field begins a new word.
  void end_field() { field_bits_ = 0; }
  /// For the listing's head.
  void note_dialect(std::string text, bool first = false) {
    dialects_.insert(first ? dialects_.begin() : dialects_.end(), std::move(text));
  }
  void warn(const SourceLinePtr& line, std::size_t offset, const std::string& message);
  void align(const SourceLinePtr& line, std::size_t offset, Address words);
  /// Makes `half` the second half of the instruction just added.
  void add_parallel(HalfSyntax half, const SourceLinePtr& line, std::size_t offset);
  void end_instruction() { parallel_target_ = false; }
  /// Reserves words at the end of a section that is not loaded; returns their place.
  Value reserve(int section, Address words, Address alignment, std::size_t offset);

  /// The words of this section must not be split over two pages of 64 K words if they fit into one.
  void block(int section) { sections_[index(section)].blocked = true; }

  /// In an object, symbols that no source defines or declares are left to other objects.
  void leave_undefined_to_others() { undefined_external_ = true; }

  void note_file_read(std::string path) { files_read_.push_back(std::move(path)); }

  /// Assigns addresses and encodes everything; errors go to `diagnostics`.
  Image finish(std::vector<Diagnostic>& diagnostics);

  /// The same without addresses: words that depend on them get relocations. Undefined symbols that were declared become
  /// references to other objects. `listed` gets the lines and warnings; its sections begin at 0.
  Object finish_object(Image& listed, std::vector<Diagnostic>& diagnostics);

  // SymbolSource

  Value value_of(const std::string& name, std::size_t offset) const override;
  bool is_defined(const std::string& name) const override;
  bool is_placed() const override { return stage_ == Stage::placed; }
  std::int64_t address_of_section(int section) const override { return sections_[index(section)].address; }

 private:
  struct Section {
    std::string name;
    Load load = Load::loaded;
    Address size = 0;
    Address alignment = 1;
    bool blocked = false;
    std::vector<Item> items;
    Address address = 0;
  };
  /// Why a symbol has no value.
  struct Problem {
    std::string message;
    std::string undefined;  ///< The symbol that is not defined, if that is why: the problem lasts until it is.
  };
  /// What an expression means changes when sections get addresses, or an object is made.
  enum class Stage : std::uint8_t { reading, placed, relocatable };
  /// What the evaluation of a symbol gave. It holds until the next stage, so that a symbol is evaluated once however
  /// many others use it.
  struct Evaluated {
    std::variant<Value, Problem> result;
    Stage stage{};
  };
  struct Symbol {
    std::variant<Value, Expression> meaning;
    SourceLinePtr line;
    std::size_t offset = 0;
    mutable bool busy =
        false;  ///< The symbol is being evaluated: meeting it again means that it is defined in terms of itself.
    mutable std::optional<Evaluated> found = {};
  };
  struct Global {
    SourceLinePtr line;
    std::size_t offset = 0;
    bool must_be_defined = false;
  };

  static std::size_t index(int section) { return static_cast<std::size_t>(section); }
  void grow(Section& section, Address words, std::size_t offset);
  std::vector<Section*> placement_order();
  void place(std::vector<Diagnostic>& diagnostics);
  static Diagnostic about_section(const Section& section, std::string message);
  void check_overlaps(const std::vector<Section*>& order, std::vector<Diagnostic>& diagnostics) const;
  /// What the linker has to know of a word.
  struct WordRelocation {
    Address offset = 0;
    FieldRelocation field;
  };
  using WordRelocations = std::vector<WordRelocation>;

  void encode_section(const Section& section, Image& image, std::vector<Diagnostic>& diagnostics,
                      WordRelocations* relocations) const;
  static void encode_float(const FloatItem& item, const Expression& expression, const Value& value,
                           std::vector<Word>& out);
  std::vector<Word> encode_item(const Section& section, const Item& item, Image& image,
                                std::vector<Diagnostic>& diagnostics, WordRelocations* relocations) const;
  Word plain_word(const Expression& expression, const Value& value, Address offset, WordRelocations* relocations) const;
  static void check_run(std::span<const Item> items, const Image::Section& section, Image& image);
  void export_symbols(Image& image, std::vector<Diagnostic>& diagnostics) const;
  void check_globals(std::vector<Diagnostic>& diagnostics) const;
  /// Half of an address is a number once the sections are placed.
  Value settled(const Value& value) const;
  /// What the last evaluation gave, if another would give the same.
  const Evaluated* known(const Symbol& symbol) const;
  std::optional<std::int64_t> predefined_value(const std::string& name) const;
  std::string undefined(const std::string& name) const;
  /// "; did you mean 'start'?", what the name means on the other processor, or nothing.
  std::string symbol_near(const std::string& name) const;
  static void check_global(const std::string& name, const Value& value, std::size_t offset);
  bool goes_into_object(std::size_t section) const;
  void add_object_symbols(Object& object, const std::vector<int>& numbers, std::vector<Diagnostic>& diagnostics);
  Relocation relocation(Object& object, const std::vector<int>& numbers, const WordRelocation& wanted) const;
  Address entry_point(const Image& image, std::vector<Diagnostic>& diagnostics) const;

  const Options& options_;
  std::vector<Section> sections_;
  int current_ = 0;
  bool parallel_target_ = false;
  Address field_bits_ = 0;  ///< Bits of the last word used by fields; 0: the last word contains no field.
  std::vector<std::string> warnings_, dialects_;
  std::vector<std::string> files_read_;
  bool undefined_external_ = false;
  mutable std::map<std::string, int> externals_;  ///< External symbols found so far by finish_object(), numbered.
  std::size_t first_external_ = 0;                ///< Its place among the object's symbols.
  mutable int evaluation_depth_ = 0;
  Stage stage_ = Stage::reading;
  bool trying_ = false;  ///< define() asks whether a value is known already: nobody reads the message.
  mutable std::map<std::string, std::string> suggestions_;  ///< By undefined symbol, of this stage.
  mutable std::size_t names_compared_ = 0;
  std::map<std::string, Symbol, std::less<>> symbols_;
  std::map<std::string, Global, std::less<>> globals_;
};

}  // namespace toolchain
