"""A C++ source uses something of each standard header that it includes.

No compiler is needed here: the names of a header are looked for in the text. A header that is needed for another reason
has a comment behind it that says so.
"""

import re

import pytest
from cpp_sources import cpp_sources

INCLUDE = re.compile(r"^#include <([\w./]+)>$", re.MULTILINE)
NO_CODE = re.compile(r'"(?:\\.|[^"\\\n])*"|//[^\n]*|^#include[^\n]*', re.MULTILINE)

NAMES_OF_STD = {
    "algorithm": "(ranges::)?(all_of|any_of|none_of|for_each|find|count|equal|search|copy|move_backward|transform"
    "|replace|fill|generate|remove|unique|reverse|rotate|partition|sort|stable_sort|nth_element|lower_bound"
    "|upper_bound|equal_range|binary_search|merge|includes|set_union|set_difference|set_intersection|min|max|minmax"
    "|min_element|max_element|minmax_element|clamp|lexicographical_compare|adjacent_find|mismatch|is_sorted|swap_ranges"
    "|push_heap|pop_heap|make_heap|shuffle|partial_sort|stable_partition)(_if|_if_not|_n|_copy|_copy_if|_backward)?",
    "array": "array|to_array",
    "atomic": r"atomic\w*|memory_order\w*",
    "bit": r"bit_\w+|count[lr]_\w+|popcount|rot[lr]|has_single_bit|endian",
    "charconv": "from_chars|to_chars|chars_format",
    "chrono": r"chrono|\w*chrono_literals",
    "cmath": r"abs|fabs|sqrt|cbrt|hypot|pow|exp(2|m1)?|log(10|2|1p|b)?|a?(sin|cos|tan)h?|atan2|floor|ceil|l?l?round|l?l?rint|trunc"
    r"|fmod|remainder|fma|fmin|fmax|is(finite|nan|inf|normal)|signbit|copysign|ldexp|frexp|scalbn|ilogb|nextafter|modf"
    "|nan|lerp",
    "compare": r"(strong|weak|partial)_ordering",
    "concepts": r"same_as|derived_from|convertible_to|\w*integral|floating_point|\w*invocable|predicate"
    "|constructible_from",
    "condition_variable": "condition_variable",
    "deque": "deque",
    "exception": r"exception\w*|current_exception|rethrow_exception|terminate|uncaught_exceptions|make_exception_ptr",
    "filesystem": "filesystem",
    "fstream": "[io]?fstream",
    "functional": r"function|invoke|c?ref|reference_wrapper|hash|(ranges::)?(less|greater|equal_to)|plus|minus"
    "|multiplies|bit_or|bit_and|bit_xor|identity|mem_fn|not_fn",
    "future": "async|future|promise",
    "iosfwd": r"\w*stream\w*",
    "iostream": "cout|cerr|cin|clog",
    "istream": "istream|ws",
    "iterator": r"back_inserter|inserter|next|prev|advance|distance|r?begin|r?end|s?size|data|empty|\w+_iterator\w*"
    r"|default_sentinel\w*",
    "limits": "numeric_limits",
    "map": "(multi)?map",
    "memory": r"(unique|shared|weak)_ptr|make_(unique|shared)\w*|enable_shared_from_this|addressof|allocator|\w+_at"
    r"|\w+_pointer_cast|to_address|default_delete",
    "mutex": r"\w*mutex|lock_guard|unique_lock|scoped_lock|once_flag|call_once",
    "new": r"bad_alloc|nothrow\w*|align_val_t|launder",
    "numbers": "numbers",
    "numeric": r"accumulate|reduce|iota|gcd|lcm|partial_sum|inner_product|midpoint",
    "optional": "optional|nullopt|make_optional",
    "ostream": "ostream|endl|flush",
    "random": r"mt19937\w*|\w+_distribution|random_device|\w+_engine|seed_seq",
    "ratio": "ratio|nano|pico|micro|milli",
    "set": "(multi)?set",
    "span": "span|as_bytes|as_writable_bytes|dynamic_extent",
    "sstream": "[io]?stringstream",
    "stdexcept": r"(runtime|logic|domain|length|range|overflow|underflow)_error|invalid_argument|out_of_range",
    "streambuf": "streambuf",
    "string": r"string|to_string|sto(i|u?ll?|f|d)|getline|char_traits|basic_string",
    "string_view": "string_view",
    "system_error": r"error_(code|category|condition)|system_error|\w+_category|errc|make_error_code",
    "thread": "thread|jthread|this_thread",
    "tuple": r"tuple\w*|tie|make_tuple|apply|get|forward_as_tuple|ignore",
    "type_traits": r"(is|enable|conditional|decay|remove|add|underlying|make|invoke|common|type)_\w+|decay_t"
    "|conditional_t|true_type|false_type|integral_constant|bool_constant|void_t",
    "typeinfo": "type_info|bad_cast",
    "unordered_map": "unordered_(multi)?map",
    "utility": r"move|forward|pair|make_pair|exchange|swap|as_const|declval|in_place\w*|\w*index_sequence\w*"
    r"|to_underlying|unreachable|cmp_\w+|in_range|piecewise_construct",
    "variant": r"variant\w*|visit|get_if|holds_alternative|monostate",
    "vector": "vector",
}
OTHER_NAMES = {
    "cassert": r"\bassert\(",
    "cerrno": r"\berrno\b|\bE[A-Z]{3,}\b",
    "cfenv": r"\bFE_[A-Z]+\b|\bfe\w+\(|\bfenv_t\b",
    "chrono": r"\d(ms|us|ns|s)\b",
    "clocale": r"\bLC_[A-Z]+\b",
    "compare": "<=>",
    "csignal": r"\bSIG[A-Z]+\b|\bsig(set|action|_atomic)\w*\b",
    "cstdarg": r"\bva_\w+\b",
    "cstddef": r"\b(size_t|ptrdiff_t|nullptr_t|max_align_t|offsetof|std::byte|std::to_integer)\b",
    "cstdint": r"\bu?int(8|16|32|64|ptr|max)_t\b",
    "cstdio": r"\b(\w*printf|f(open|close|write|read|puts|putc|flush|ileno|gets)|std(out|err|in)|FILE|remove|rename"
    r"|perror)\b",
    "cstdlib": r"\b(abs|(un)?setenv|getenv|_?exit|_Exit|abort|atexit|malloc|free|calloc|strto\w+|EXIT_\w+|l?labs"
    r"|realpath|mkstemp\w*)\b",
    "cstring": r"\b(mem(cpy|cmp|set|move|chr)|str(len|n?cmp|r?chr|str|error|signal|dup))\b",
    "fmt/format.h": r"\bfmt::",
    "fmt/ranges.h": r"\bfmt::(join|format|print)",
    "new": r"\bnew \(",
    "typeinfo": r"\btypeid\b",
}
# A loop over a braced list needs the header, too.
ALWAYS_USED = {"initializer_list"}


def unused(text: str) -> list[str]:
    """The standard headers of which a source uses nothing."""
    code = NO_CODE.sub(" ", text)

    def used(header: str) -> bool:
        of_std, others = NAMES_OF_STD.get(header), OTHER_NAMES.get(header)
        if of_std is None and others is None:
            return True
        return bool(
            (of_std is not None and re.search(rf"\bstd::({of_std})\b", code))
            or (others is not None and re.search(others, code))
        )

    return [header for header in INCLUDE.findall(text) if not used(header)]


def test_sources_use_the_standard_headers_that_they_include() -> None:
    texts = cpp_sources("emulator", "bus_model", "plant", "python/bindings", "fuzz", "tests")
    assert len(texts) > 700
    assert not [f"{path}: {header}" for path, text in sorted(texts.items()) for header in unused(text)]


def test_every_standard_header_of_the_project_has_its_names_here() -> None:
    known = NAMES_OF_STD.keys() | OTHER_NAMES.keys() | ALWAYS_USED
    included = {
        header
        for text in cpp_sources("emulator", "bus_model", "plant", "python/bindings", "fuzz", "tests").values()
        for header in INCLUDE.findall(text)
        if re.fullmatch("[a-z_]+", header)
    }
    assert included - known == set()


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        ("std::vector<int> all;", []),
        ("// a std::vector of numbers", ["vector"]),
        ('const char* text = "std::vector";', ["vector"]),
        ("std::vectors all;", ["vector"]),
        ("own::vector all;", ["vector"]),
    ],
)
def test_a_header_without_use_is_found(code: str, expected: list[str]) -> None:
    assert unused(f"#include <vector>\n{code}\n") == expected


def test_a_header_with_its_reason_is_left() -> None:
    assert unused("#include <vector>  // for the header below\n") == []
