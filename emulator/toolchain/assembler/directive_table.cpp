// Every directive that the assembler's reader knows. Sources, collected lines and suggestions all look here.
#include "io/nearest.hpp"
#include "toolchain/assembler/reader.hpp"

namespace toolchain {

const std::map<std::string, Reader::Directive, std::less<>>& Reader::directives() {
  static constexpr Directive ignored{&Reader::directive_nothing, true};
  static const std::map<std::string, Directive, std::less<>> table{
      // Sections
      {".text", {&Reader::directive_section_text}},
      {".data", {&Reader::directive_section_data}},
      {".const", {&Reader::directive_section_const}},
      {".bss", {&Reader::directive_bss}},
      {".sect", {&Reader::directive_sect}},
      {".section", {&Reader::directive_sect}},
      {".usect", {&Reader::directive_usect}},
      {".align", {&Reader::directive_align}},
      // Contents
      {".word", {&Reader::directive_word}},
      {".int", {&Reader::directive_word}},
      {".long", {&Reader::directive_word}},
      {".byte", {&Reader::directive_byte}},
      {".hword", {&Reader::directive_half_word}},
      {".short", {&Reader::directive_half_word}},
      {".field", {&Reader::directive_field}},
      {".float", {&Reader::directive_float}},
      {".single", {&Reader::directive_float}},
      {".double", {&Reader::directive_float}},
      {".ldouble", {&Reader::directive_long_double}},
      {".ieee", {&Reader::directive_ieee}},
      {".string", {&Reader::directive_string}},
      {".ascii", {&Reader::directive_string}},
      {".asciz", {&Reader::directive_asciz}},
      {".cstring", {&Reader::directive_asciz}},
      {".space", {&Reader::directive_space}},
      {".block", {&Reader::directive_space}},
      {".bes", {&Reader::directive_space_end}},
      // Symbols and files
      {".set", {&Reader::directive_set}},
      {".equ", {&Reader::directive_set}},
      {".label", {&Reader::directive_label, true}},
      {".newblock", {&Reader::directive_newblock, true}},
      {".struct", {.read = &Reader::start_structure, .closing = ".endstruct"}},
      {".union", {.read = &Reader::start_structure, .closing = ".endunion"}},
      {".endstruct", {&Reader::end_structure}},
      {".endunion", {&Reader::end_structure}},
      {".tag", {&Reader::tag}},
      {".asg", {&Reader::assign_text, true}},
      {".eval", {&Reader::assign_number, true}},
      {".var", {&Reader::declare_variables, true}},
      {".unasg", {&Reader::forget_text, true}},
      {".include", {&Reader::directive_include, true}},
      {".copy", {&Reader::directive_include, true}},
      {".global", {&Reader::directive_global, true}},
      {".globl", {&Reader::directive_global, true}},
      {".xdef", {&Reader::directive_global, true}},
      {".ref", {&Reader::directive_global, true}},
      {".def", {&Reader::directive_def, true}},
      {".version", {&Reader::directive_version, true}},
      {".dialect", {&Reader::directive_dialect, true}},
      {".end", {&Reader::directive_end, true}},
      // Macros and repeats
      {".macro", {.read = &Reader::start_macro, .sort = Sort::collects, .closing = ".endm"}},
      {".mexit", {&Reader::leave_macro, true}},
      {".exitm", {&Reader::leave_macro, true}},
      {".endm", {.read = &Reader::directive_stray, .sort = Sort::closes}},
      {".rept", {&Reader::start_repeat, true, Sort::collects, ".endr"}},
      {".loop", {&Reader::start_repeat, true, Sort::collects, ".endloop"}},
      {".break", {&Reader::leave_repeat, true}},
      {".endr", {.read = &Reader::directive_stray, .sort = Sort::closes}},
      {".endloop", {.read = &Reader::directive_stray, .sort = Sort::closes}},
      // Conditional parts
      {".if", {.read = &Reader::open_conditional, .sort = Sort::conditional, .closing = ".endif"}},
      {".ifdef", {.read = &Reader::open_conditional, .sort = Sort::conditional, .closing = ".endif"}},
      {".ifndef", {.read = &Reader::open_conditional, .sort = Sort::conditional, .closing = ".endif"}},
      {".elseif", {.read = &Reader::next_branch, .sort = Sort::conditional}},
      {".else", {.read = &Reader::next_branch, .sort = Sort::conditional}},
      {".endif", {.read = &Reader::close_conditional, .sort = Sort::conditional}},
      // Messages
      {".emsg", {&Reader::directive_error, true}},
      {".error", {&Reader::directive_error, true}},
      {".wmsg", {&Reader::directive_warning, true}},
      {".warning", {&Reader::directive_warning, true}},
      // For listings, debuggers and section hints of TI's tools: without effect on the program
      {".title", ignored},
      {".page", ignored},
      {".list", ignored},
      {".nolist", ignored},
      {".length", ignored},
      {".width", ignored},
      {".option", ignored},
      {".tab", ignored},
      {".mlist", ignored},
      {".mnolist", ignored},
      {".fclist", ignored},
      {".fcnolist", ignored},
      {".sslist", ignored},
      {".ssnolist", ignored},
      {".drlist", ignored},
      {".drnolist", ignored},
      {".mmsg", ignored},
      {".mlib", ignored},
      {".clink", ignored},
      {".sblock", ignored},
      {".file", ignored},
      {".ident", ignored},
      {".line", ignored},
      {".ln", ignored},
      {".func", ignored},
      {".endfunc", ignored},
      {".sym", ignored},
      {".stag", ignored},
      {".etag", ignored},
      {".utag", ignored},
      {".member", ignored},
      {".eos", ignored},
      {".blockb", ignored},
      {".endblock", ignored},
      {".regalias", ignored},
  };
  return table;
}

const Reader::Directive* Reader::directive_named(std::string_view name) {
  const auto found = directives().find(name);
  return found == directives().end() ? nullptr : &found->second;
}

std::string Reader::directive_near(std::string_view name) {
  std::vector<std::string_view> names;
  for (const auto& [known, unused] : directives()) names.push_back(known);
  return io::suggestion(io::nearest(name, names, io::most_wrong(name)), '\'');
}

}  // namespace toolchain
