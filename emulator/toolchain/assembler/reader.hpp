#pragma once
// Reads source lines in order: files and includes, conditional parts, macros and repeats, directives, instructions.
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "toolchain/assembler/program.hpp"
#include "toolchain/assembler/substitution.hpp"

namespace toolchain {

class Reader {
 public:
  Reader(Program& program, const Options& options, std::vector<Diagnostic>& diagnostics);

  void read_file(const std::filesystem::path& path);
  void read_text(std::string_view text, const std::string& name, const std::filesystem::path& directory);

 private:
  struct Parameter {
    std::string name;
    std::string fallback;
  };
  struct Macro {
    std::vector<Parameter> parameters;
    std::vector<SourceLinePtr> body;
  };
  /// Collects the lines of a macro or a repeat.
  struct Collector {
    enum class Kind : std::uint8_t { macro, repeat, broken } kind = Kind::broken;
    std::string name;
    Macro macro;
    std::int64_t count = 0;
    SourceLinePtr opening;
    /// The arguments of the macro that is being expanded, for it and each macro or repeat that is open in it: without
    /// those that a parameter of the same name hides. The lines of a macro in a macro get these now, those of a repeat
    /// get theirs each time they are read.
    std::vector<Substitutes> scopes = {{}};
  };
  struct Conditional {
    bool active = false;  ///< The present part is assembled.
    bool taken = false;   ///< A part was already assembled.
    bool parent = false;  ///< The surrounding part is assembled.
    bool after_else = false;
    SourceLinePtr opening;
  };
  /// A line, parsed up to its operation.
  struct Statement {
    SourceLinePtr line;
    Parser parser;
    std::string label;
    std::size_t label_offset = 0;
    std::string operation;  ///< As written; empty if there is none.
    std::size_t operation_offset = 0;
    bool bars = false;
  };
  /// Text of a line; names that the line declares are parts of their own.
  struct LinePart {
    std::string text;
    bool declares = false;
  };
  struct Member {
    std::string name;
    Address place = 0;  ///< In words.
    SourceLinePtr line;
    std::size_t offset = 0;
  };
  /// A .struct or .union.
  struct Structure {
    std::string name;
    std::vector<Member> members;
    Address size = 0;
    Address place = 0;  ///< Of the next member.
    bool is_union = false;
    SourceLinePtr opening;
  };
  /// How a file is read.
  struct Reading {
    Dialect dialect = Dialect::ti;
    std::string why;
    bool said = false;      ///< by .dialect
    bool has_code = false;  ///< an instruction has been read: the dialect cannot change any more
  };
  enum class Sort : std::uint8_t {
    ordinary,
    conditional,  ///< It is read in parts that are not assembled, too.
    collects,     ///< The lines up to the one that closes it are collected.
    closes,       ///< It closes collected lines.
  };
  struct Directive {
    void (Reader::*read)(Statement&) = nullptr;
    bool label_is_here = false;  ///< The directive has no use for a label, which names the place where it stands.
    Sort sort = Sort::ordinary;
    std::string_view closing{};  ///< The directive that usually closes it; empty if it opens nothing.
  };

  // reader.cpp
  void read_line(const SourceLinePtr& line);
  std::vector<LinePart> parts_of(const SourceLinePtr& line) const;
  SourceLinePtr substituted(const SourceLinePtr& line);
  void read_active_line(Statement& statement);
  Statement take_apart(const SourceLinePtr& line) const;
  bool is_operation(std::string_view word) const;
  bool collect(const SourceLinePtr& line);
  void finish_collecting();
  bool condition(Statement& statement);
  void open_conditional(Statement& statement);
  void next_branch(Statement& statement);
  void close_conditional(Statement& statement);
  Conditional& open_one(const Statement& statement);
  void report_open(const SourceLinePtr& opening);
  bool stopped() const { return ended_ || given_up_ || leaving_ != Leaving::nothing; }
  bool is_active() const { return conditionals_.empty() || conditionals_.back().active; }
  void place_label(const Statement& statement);
  void define_label(const Statement& statement);
  void gcc_mark(const Statement& statement);
  void instruction(Statement& statement);
  void report(const SourceLine& line, const LineError& error);
  ParseContext context() const;
  void new_block();
  void end_of_source(std::size_t outer_conditionals);

  // macros.cpp
  void expand(const Macro& macro, Statement& statement);
  void read_lines(const std::vector<SourceLinePtr>& body, const SourceLinePtr& from);
  std::vector<std::string> macro_arguments(std::string_view text) const;
  static std::string macro_name(Statement& statement);
  void start_macro(Statement& statement);
  void start_repeat(Statement& statement);
  void leave_macro(Statement& statement);
  void leave_repeat(Statement& statement);
  void assign_text(Statement& statement);
  void assign_number(Statement& statement);
  void declare_variables(Statement& statement);
  void forget_text(Statement& statement);
  void directive_newblock(Statement& statement);

  // structures.cpp
  void start_structure(Statement& statement);
  void end_structure(Statement& statement);
  void member(Statement& statement);
  void tag(Statement& statement);
  const Structure& structure_named(Parser& parser);
  void count_member(const std::string& name, std::size_t offset);

  // directive_table.cpp
  static const std::map<std::string, Directive, std::less<>>& directives();
  /// In lower case, with its dot. Null if there is none.
  static const Directive* directive_named(std::string_view name);
  /// "; did you mean '.word'?" or nothing.
  static std::string directive_near(std::string_view name);

  // directives.cpp
  std::int64_t known_number(Parser& parser, std::string_view what);
  Address alignment_of_reserved(Parser& parser, int section);
  Address known_size(Parser& parser, std::string_view what);
  std::string symbol_name(Statement& statement);
  void directive_section_text(Statement&);
  void directive_section_data(Statement&);
  void directive_section_const(Statement&);
  void directive_bss(Statement&);
  void directive_sect(Statement&);
  void directive_usect(Statement&);
  void directive_label(Statement&);
  void directive_version(Statement&);
  void directive_dialect(Statement&);
  void directive_warning(Statement&);
  void directive_align(Statement&);
  void directive_set(Statement&);
  void directive_include(Statement&);
  void directive_global(Statement&);
  void directive_def(Statement&);
  void directive_end(Statement&);
  void directive_error(Statement&);
  void directive_nothing(Statement&);
  void directive_stray(Statement&);
  void select_section(Statement& statement, const std::string& name, Program::Load load, std::size_t offset);

  // data_directives.cpp
  void directive_word(Statement&);
  void directive_byte(Statement&);
  void directive_half_word(Statement&);
  void directive_field(Statement&);
  void directive_float(Statement&);
  void directive_ieee(Statement&);
  void directive_long_double(Statement&);
  void directive_string(Statement&);
  void directive_asciz(Statement&);
  void directive_space(Statement&);
  void directive_space_end(Statement&);
  void packed_strings(Statement& statement, bool terminated);
  void floats(Statement& statement, FloatItem::Format format);
  WordItem numbers(Statement& statement, unsigned bits);

  Program& program_;
  const Options& options_;
  std::vector<Diagnostic>& diagnostics_;
  std::map<std::string, Macro, std::less<>> macros_;
  std::map<std::string, Structure, std::less<>> structures_;
  std::optional<Structure> structure_;  ///< The structure that is being declared.
  std::size_t letters_of_members_ = 0;  ///< In all names that structures made.
  std::vector<Conditional> conditionals_;
  std::unique_ptr<Collector> collector_;
  std::vector<std::filesystem::path> open_files_;  ///< The present file and the files that include it.
  std::filesystem::path directory_;
  Substitutes substitutes_;
  Substitutes* parameters_ = nullptr;  ///< The parameters of the present macro.
  RegisterNames registers_;
  mutable std::vector<LineError> parser_warnings_;  ///< Warnings for the present line.
  enum class Leaving : std::uint8_t {
    nothing,
    repeat,
    macro
  } leaving_ = Leaving::nothing;  ///< Set by .break or .mexit.
  int repeat_depth_ = 0;
  int block_ = 0;        ///< The scope of $0 to $9.
  int local_scope_ = 0;  ///< The scope of names that end in '?'.
  int last_scope_ = 0;
  int expansion_depth_ = 0;
  bool ended_ = false;     ///< Set by .end.
  bool given_up_ = false;  ///< Set after too many lines or errors.
  std::int64_t lines_read_ = 0;
  Reading reading_;
  int open_texts_ = 0;
};

}  // namespace toolchain
