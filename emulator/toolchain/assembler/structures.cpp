// .struct, .union and .tag of the assembler's reader: names for places within a record.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "toolchain/assembler/reader.hpp"

namespace toolchain {
namespace {

constexpr std::size_t most_letters = 1U << 22;  // .tag can double them with each structure

}  // namespace

void Reader::count_member(const std::string& name, std::size_t offset) {
  letters_of_members_ += name.size();
  if (letters_of_members_ > most_letters)
    throw LineError{offset, fmt::format("too many members: the names that structures make have more than {} letters",
                                        most_letters)};
}

/// `[NAME] .struct [offset]` or `.union`: the lines up to .endstruct or .endunion declare members.
void Reader::start_structure(Statement& s) {
  if (structure_) throw LineError{s.operation_offset, "a structure within a structure; use .tag for its members"};
  Structure structure;
  structure.name = s.label;
  structure.is_union = lower(s.operation) == ".union";
  structure.opening = s.line;
  if (!s.parser.at_end()) structure.size = structure.place = known_size(s.parser, "the offset");
  s.parser.expect_end();
  if (structures_.contains(structure.name))
    throw LineError{s.label_offset, fmt::format("the structure '{}' is defined already", structure.name)};
  structure_ = std::move(structure);
}

/// `[SIZE] .endstruct`
void Reader::end_structure(Statement& s) {
  s.parser.expect_end();
  if (!structure_) throw LineError{s.operation_offset, fmt::format("'{}' closes nothing", s.operation)};
  const Structure structure = std::move(*structure_);
  structure_.reset();
  const Value size = Value::of(std::int64_t{structure.size});
  for (const Member& member : structure.members) {
    const std::string name = structure.name.empty() ? member.name : structure.name + "." + member.name;
    count_member(name, s.operation_offset);
    try {
      program_.define(name, Value::of(std::int64_t{member.place}), member.line, member.offset);
    } catch (const LineError& error) {
      report(*member.line, error);
    }
  }
  if (!s.label.empty()) program_.define(s.label, size, s.line, s.label_offset);
  if (!structure.name.empty()) {
    program_.define(structure.name, size, structure.opening, 0);
    structures_[structure.name] = structure;
  }
}

/// A line within a structure: `[member] .int [count]`, `[member] .tag OTHER`, .space, .align.
void Reader::member(Statement& s) {
  static const std::set<std::string_view> words{".int",    ".word", ".long",   ".byte",   ".hword", ".short", ".float",
                                                ".single", ".ieee", ".double", ".string", ".space", ".block"};
  const std::string operation = lower(s.operation);
  if (operation == ".endstruct" || operation == ".endunion") return end_structure(s);
  if (operation == ".struct" || operation == ".union") return start_structure(s);
  Parser& p = s.parser;
  Address size = 0;
  if (operation == ".align") {
    const Address alignment = p.at_end() ? 32 : known_size(p, "the alignment");
    require_alignment(alignment, s.operation_offset);
    structure_->place = (structure_->place + alignment - 1) / alignment * alignment;
  } else if (operation == ".tag") {
    const Structure& other = structure_named(p);
    if (!s.label.empty())
      for (const Member& inner : other.members) {
        structure_->members.push_back(
            {s.label + "." + inner.name, structure_->place + inner.place, s.line, s.label_offset});
        count_member(structure_->members.back().name, s.label_offset);
      }
    size = other.size;
  } else if (words.contains(operation) || operation == ".ldouble") {
    const Address count = p.at_end() ? 1 : known_size(p, "the number of elements");
    size = operation == ".ldouble" ? 2 * count : count;
  } else if (!operation.empty()) {
    throw LineError{s.operation_offset, fmt::format("'{}' cannot declare a member of a structure", s.operation)};
  }
  p.expect_end();
  if (!s.label.empty()) structure_->members.push_back({s.label, structure_->place, s.line, s.label_offset});
  structure_->size = std::max(structure_->size, structure_->place + size);
  if (!structure_->is_union) structure_->place = structure_->size;
}

const Reader::Structure& Reader::structure_named(Parser& p) {
  p.skip_blanks();
  const std::size_t offset = p.offset();
  const std::string name = p.required_identifier("a structure");
  const auto found = structures_.find(name);
  if (found == structures_.end()) throw LineError{offset, fmt::format("there is no structure '{}'", name)};
  return found->second;
}

/// `NAME .tag STRUCTURE` defines NAME.member for every member.
void Reader::tag(Statement& s) {
  if (s.label.empty()) throw LineError{s.operation_offset, ".tag needs a label: name .tag STRUCTURE"};
  const Structure& structure = structure_named(s.parser);
  s.parser.expect_end();
  const std::size_t at = s.label_offset;
  const Expression base{Expression::Kind::symbol, {}, s.label, {}, at};
  for (const Member& member : structure.members) {
    const Expression offset{Expression::Kind::constant, Value::of(std::int64_t{member.place}), {}, {}, at};
    const std::string name = s.label + "." + member.name;
    count_member(name, at);
    program_.define(name, Expression{Expression::Kind::binary, {}, "+", {base, offset}, at}, s.line, at);
  }
}

}  // namespace toolchain
