"""The extension of VS Code agrees with what it is for: the instruction table, the assembler's messages, the keys of
`launch`."""

import json
import re
import subprocess
from pathlib import Path

from cmrc._core import isa
from locations import BUILD, ROOT

EXTENSION = ROOT / "editors" / "vscode"
PACKAGE = json.loads((EXTENSION / "package.json").read_text())


CONDITIONS = [
    "nluf",
    "nlv",
    "nuf",
    "zuf",
    "luf",
    "nn",
    "np",
    "nc",
    "nz",
    "nv",
    "uf",
    "lv",
    "lo",
    "ls",
    "hi",
    "hs",
    "eq",
    "ne",
    "lt",
    "le",
    "gt",
    "ge",
    "u",
    "v",
    "c",
    "z",
    "n",
    "p",
]
GRAMMAR = EXTENSION / "syntaxes" / "c40.tmLanguage.json"


def instructions() -> str:
    """A pattern of all mnemonics of the instruction table; conditions may be left out."""
    mnemonics = {
        word for row in isa.rows() for word in re.findall(r"[a-z0-9?]+", f"{row['mnemonic']} {row['mnemonic2']}")
    }
    longest_first = sorted(mnemonics, key=lambda word: (-len(word), word))
    return (
        "(?i)(?<![\\w.])("
        + "|".join(word.replace("?", f"(?:{'|'.join(CONDITIONS)})?") for word in longest_first)
        + ")(?![\\w.])"
    )


def test_every_instruction_is_highlighted() -> None:
    grammar = json.loads(GRAMMAR.read_text())
    (pattern,) = (row["match"] for row in grammar["patterns"] if row["name"].startswith("keyword.operator"))
    assert pattern == instructions(), (
        "the instruction table has changed: python tests/debugger/test_vscode_extension.py writes the grammar again"
    )
    for mnemonic in ("ldi", "bz", "beqat", "callu", "mpyf3", "ldfge", "rptbd", "idle"):
        assert re.fullmatch(pattern, mnemonic), mnemonic
    assert not re.fullmatch(pattern, "nonsense")


def test_the_problem_matcher_finds_the_assemblers_messages(tmp_path: Path) -> None:
    source = tmp_path / "wrong.asm"
    source.write_text("        .text\n        bogus   r0\n")
    done = subprocess.run(
        [BUILD / "bin" / "emulator", "asm", source, "-o", tmp_path / "out"], capture_output=True, text=True, check=False
    )
    pattern = PACKAGE["contributes"]["problemMatchers"][0]["pattern"]
    found = [match for line in done.stderr.splitlines() if (match := re.match(pattern["regexp"], line))]
    assert found, done.stderr
    assert (
        found[0][pattern["file"]] == str(source)
        and found[0][pattern["line"]] == "2"
        and "bogus" in found[0][pattern["message"]]
    )


def test_launch_takes_the_keys_that_the_extension_offers() -> None:
    offered = set(PACKAGE["contributes"]["debuggers"][0]["configurationAttributes"]["launch"]["properties"])
    read = set(re.findall(r'arguments, "(\w+)"', (ROOT / "emulator" / "cli" / "debug" / "dap.cpp").read_text()))
    read |= set(
        re.findall(r'flag_of\(arguments, "(\w+)"', (ROOT / "emulator" / "debugger" / "dap_session.cpp").read_text())
    )
    assert offered | {"action", "loadAt"} == read


if __name__ == "__main__":
    grammar = json.loads(GRAMMAR.read_text())
    next(row for row in grammar["patterns"] if row["name"].startswith("keyword.operator"))["match"] = instructions()
    GRAMMAR.write_text(json.dumps(grammar, indent=2) + "\n")
