"""A C++ source includes the header that declares the function or type it names.

The usual build compiles sources in groups of four, where one source has what another one includes. A source that
lacks an include compiles only there, and the builds of single sources (`make fuzz`, `make coverage`, the debug preset)
break. No compiler is needed here: names are looked for in the text, and a name that might be the source's own is
passed over.
"""

import re
from collections import defaultdict
from functools import cached_property
from pathlib import PurePosixPath

from cpp_sources import code_of, cpp_sources

INCLUDED_FROM = ("", "emulator", "python")
"""Folders that the paths of includes begin at"""

NAMESPACE = re.compile(r"^namespace ([\w:]+)", re.MULTILINE)
FUNCTION = re.compile(r"^(?!return|using|namespace|typedef|friend)[A-Za-z_\[][^\n()=;]*[\s&*](\w+)\(", re.MULTILINE)
TYPE = re.compile(r"^(?:struct|class|enum class|enum) (\w+)\b[^;]*?\{", re.MULTILINE)
OWN_TYPE = re.compile(r"\b(?:struct|class|enum class|enum|using) (\w+)\b")
OWN_FUNCTION = re.compile(
    r"[\w>&*] [&*]?(\w+)\([^()]*(?:\([^()]*\)[^()]*)*\)(?: const)?(?: noexcept)?(?: override)? ?[{;:]"
)
NEVER_A_TYPE = {"return", "else", "case", "throw", "new", "co_return", "in", "and", "or", "not"}


class Source:
    """The text of a file, and what can be read from it."""

    def __init__(self, text: str) -> None:
        self.code = code_of(text)
        self.includes: list[str] = re.findall(r'^#include "([^"]+)"', text, re.MULTILINE)

    @cached_property
    def words(self) -> set[str]:
        return set(re.findall(r"\b[A-Za-z_]\w*", self.code))

    @cached_property
    def namespaces(self) -> set[str]:
        return set(NAMESPACE.findall(self.code))

    @cached_property
    def declared(self) -> set[str]:
        """Functions and types of a namespace: their lines begin at the margin."""
        return {*FUNCTION.findall(self.code), *TYPE.findall(self.code)}

    @cached_property
    def own(self) -> set[str]:
        return {*OWN_TYPE.findall(self.code), *OWN_FUNCTION.findall(self.code)}

    def names(self, name: str, namespaces: set[str]) -> bool:
        """Whether the source names a function or type of one of the namespaces."""
        found = False
        for use in re.finditer(rf"\b{name}\b", self.code):
            before = re.search(r"(?:(\w+)::|(\w+)|([\w>]&&?|->|.))\s*$", self.code[: use.start()], re.DOTALL)
            scope, word, mark = before.groups() if before else (None, None, "")
            if (word and word not in NEVER_A_TYPE) or (mark and mark.endswith("&") and len(mark) > 1):
                return False  # A parameter, or a variable with its type.
            if not name[0].isupper() and not self.code.startswith(("(", "<"), use.end()):
                continue
            if scope:
                found |= scope in {space.rpartition("::")[2] for space in namespaces}
            elif mark not in (".", "->"):
                found |= bool(self.namespaces & namespaces)
        return found


def lacking(texts: dict[str, str]) -> list[str]:
    """For each name that a source uses without its header, "source: name, header"; paths begin at the tree's root."""
    sources = {path: Source(text) for path, text in texts.items()}
    headers = defaultdict(set)
    for path, source in sources.items():
        if path.endswith(".hpp"):
            for name in source.declared:
                headers[name].add(path)

    def included(path: str) -> set[str]:
        seen: set[str] = set()
        waiting = [path]
        while waiting:
            at = waiting.pop()
            if at in seen:
                continue
            seen.add(at)
            for wanted in sources[at].includes:
                places = [str(PurePosixPath(start) / wanted) for start in INCLUDED_FROM]
                waiting += [place for place in places if place in sources][:1]
        return seen - {path}

    found = []
    for path, source in sorted(sources.items()):
        known = source.own.union(*(sources[other].own | sources[other].declared for other in included(path)))
        for name in sorted((source.words & headers.keys()) - known):
            if path not in headers[name] and source.names(
                name, set().union(*(sources[header].namespaces for header in headers[name]))
            ):
                found.append(f"{path}: {name}, {' or '.join(sorted(headers[name]))}")
    return found


def test_sources_include_what_they_name() -> None:
    texts = cpp_sources("emulator", "bus_model", "plant", "python/bindings", "fuzz")
    assert len(texts) > 700
    for path in texts:
        if path.startswith("python/") and path.endswith(".cpp"):
            texts[path] += '#include "bindings/interpreter/text.hpp"\n'  # by python/CMakeLists.txt
    assert not lacking(texts)


HEADER = "#pragma once\nnamespace toolchain {\nint pages(int words);\nstruct Place {\n  int at;\n};\n}\n"


def found(body: str, namespace: str = "toolchain") -> list[str]:
    texts = {"emulator/toolchain/places.hpp": HEADER, "emulator/a.cpp": f"namespace {namespace} {{\n{body}\n}}\n"}
    return [line.partition(": ")[2].partition(",")[0] for line in lacking(texts)]


def test_a_name_without_its_header_is_found() -> None:
    assert found("void f() { pages(3); }") == ["pages"]
    assert found("Place f() { return {}; }") == ["Place"]
    assert found("void f() { toolchain::pages(3); }", "other") == ["pages"]


def test_a_name_with_another_meaning_is_none() -> None:
    assert found("void f() { pages(3); }", "other") == []
    assert found("void f() { other::pages(3); }") == []
    assert found("void f(Book& book) { book.pages(3); }") == []
    assert found("template <class Pages>\nvoid f(Pages&& pages) { pages(3); }") == []
    assert found("// pages(3)\nvoid f() {}") == []


def test_an_include_of_an_include_is_enough() -> None:
    texts = {
        "emulator/toolchain/places.hpp": HEADER,
        "emulator/toolchain/more.hpp": '#include "toolchain/places.hpp"\n',
        "emulator/a.cpp": '#include "toolchain/more.hpp"\nnamespace toolchain {\nvoid f() { pages(3); }\n}\n',
    }
    assert lacking(texts) == []
