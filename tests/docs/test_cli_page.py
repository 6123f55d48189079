"""Each option that `--help` names is in docs/cli.md, or in the page that docs/cli.md names for its command."""

import re
import subprocess
from pathlib import Path

import pytest
from locations import BUILD, ROOT

DOCS = ROOT / "docs"
PAGES = {
    "asm": ("assembler",),
    "link": ("assembler",),
    "disasm": ("assembler",),
    "classify": ("oracles",),
    "exec": ("cli", "networks"),
    "debug": ("debugger", "networks", "cli"),
    "dap": ("dap", "debugger", "cli"),
    "trace-diff": ("trace",),
}
"""Pages that describe a command's options; the default is docs/cli.md alone."""


def options(command: str) -> set[tuple[str, str]]:
    """Each option with its letter, which may be empty."""
    words = [command] if command else []
    done = subprocess.run([BUILD / "bin" / "emulator", *words, "--help"], capture_output=True, text=True, check=True)
    return set(re.findall(r"^  (-\w)?,?(--[a-z][\w-]*)", done.stdout, re.MULTILINE)) - {("-h", "--help")}


def commands() -> list[str]:
    text = (DOCS / "cli.md").read_text(encoding="utf-8").partition("\n\n")[2].partition("\n\n")[0]
    return sorted({"", *re.findall(r"^    emulator ([a-z][a-z-]+)", text, re.MULTILINE)})


def test_the_page_names_every_command() -> None:
    done = subprocess.run([BUILD / "bin" / "emulator", "--help"], capture_output=True, text=True, check=True)
    listed = re.findall(r"^  ([a-z][a-z-]+) ", done.stdout.partition("Subcommands:")[2], re.MULTILINE)
    text = (DOCS / "cli.md").read_text(encoding="utf-8")
    assert listed and not [name for name in listed if not re.search(rf"emulator {name}\b", text)]


@pytest.mark.parametrize("command", commands(), ids=lambda name: name or "emulator")
def test_every_option_is_documented(command: str) -> None:
    pages = [Path(DOCS / f"{page}.md") for page in PAGES.get(command, ("cli",))]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    found = options(command)
    missing = [
        name
        for letter, name in sorted(found)
        if not re.search(rf"{name}(?![\w-])" + (rf"|[` ]{letter}\b" if letter else ""), text)
    ]
    assert found and not missing
