"""C++ that Debian's clang 14 refuses, and the usual build takes.

`make fuzz`, `make trust` and `make clang` compile with this clang, the suite and CI with GCC alone. No compiler is
needed here: what it would refuse is looked for in the text. `make clang` is the whole check.
"""

import re

from cpp_sources import code_of, cpp_sources

BINDING = re.compile(r"(\bfor \()?\b(?:const )?auto&{0,2} \[([\w, ]+)\]")
LAMBDA = re.compile(r"\[([&=][^\]]*)\](?: ?\(|<| ?\{)")


def closing(code: str, at: int) -> int:
    """The place behind the bracket that closes the one which is open at `at`, or behind the `;` of a statement."""
    depth = 0
    for place in range(at, len(code)):
        if code[place] in "({[":
            depth += 1
        elif code[place] in ")}]":
            depth -= 1
            if depth < 0 or (depth == 0 and code[place] == "}"):
                return place + 1
        elif code[place] == ";" and depth == 0:
            return place + 1
    return len(code)


def scope(code: str, found: re.Match[str]) -> str:
    """The text in which the names of a structured binding are known."""
    at = found.end()
    if found[1]:  # The rest of the loop's head, and its statement.
        head = closing(code, at)
        return code[at : closing(code, head)]
    depth = 0
    for place in range(at, len(code)):
        depth += {"{": 1, "}": -1}.get(code[place], 0)
        if depth < 0:
            return code[at:place]
    return code[at:]


def refused(text: str) -> list[str]:
    """What clang 14 refuses: views of ranges, and names of structured bindings in lambdas that capture by default."""
    code = code_of(text)
    found = ["std::views"] if re.search(r"std::(ranges::)?views\b", code) else []
    for binding in BINDING.finditer(code):
        known = scope(code, binding)
        for inner in LAMBDA.finditer(known):
            body = known[inner.end() : closing(known, known.find("{", inner.end() - 1))]
            copied = re.findall(r"(\w+) =", inner[1])
            found += [
                name
                for name in re.findall(r"\w+", binding[2])
                if name not in copied and re.search(rf"(?<![.>:\w]){name}\b", body)
            ]
    return found


def test_no_source_has_what_clang_14_refuses() -> None:
    texts = cpp_sources("emulator", "bus_model", "plant", "python/bindings", "fuzz", "tests")
    assert len(texts) > 700
    found = {path: refused(text) for path, text in texts.items()}
    assert not {path: names for path, names in found.items() if names}


def test_it_is_found() -> None:
    assert refused("void f() { for (const auto& [name, at] : all) if (any([&](int i) { return i == at; })) g(); }") == [
        "at"
    ]
    assert refused("void f() { const auto [a, b] = g(); h([=] { return a; }); }") == ["a"]
    assert refused("for (int i : list | std::views::reverse) {}") == ["std::views"]


def test_what_clang_14_takes_is_not_found() -> None:
    assert not refused("void f() { for (const auto& [a, b] : all) { g(a); } h([&] { return a; }); }")
    assert not refused("void f() { const auto [a, b] = g(); h([&, a = a] { return a; }); }")
    assert not refused("void f() { { const auto [a, b] = g(); } h([&] { return a; }); }")
    assert not refused("void f() { const auto [a, b] = g(); h([&] { return it.a; }); }")
