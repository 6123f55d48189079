"""GNU's own test sources for the C4x, without the lines that our assembler refuses for a reason."""

import re
from collections.abc import Mapping, Sequence

from cmrc._core import toolchain
from locations import ROOT

GNU = ROOT / "build-oracles" / "bin"
SOURCES = ("opcodes", "addressing", "registers")
LDM_OF_AN_IMMEDIATE = 0b000_010010_11


def lines_of(name: str, left_out: str) -> list[str]:
    """One statement to a line, but for those that match ``left_out``, which the two assemblers read differently."""
    source = (GNU.parent / "testsuite" / f"{name}.s").read_text().replace("&", "\n")
    lines = ["\t.ref start" if name == "opcodes" else "", *source.splitlines()]
    return ["" if re.search(left_out, line) else line for line in lines]


def defined(symbols: Sequence[str]) -> list[str]:
    """The options of GNU's assembler that give these symbols the value 1."""
    return [word for symbol in symbols for word in ("--defsym", f"{symbol}=1")]


def without_refused(
    lines: Sequence[str], symbols: Sequence[str], reasons: Mapping[str, str], **options: str
) -> tuple[list[str], toolchain.Object]:
    """The lines that our assembler takes, if these symbols are 1, and the object that it makes of them.

    ``reasons``: a part of each message, and the shape of the lines that are refused with it. Nothing else is refused.
    """
    kept = list(lines)
    head = "".join(f"{symbol} .set 1\n" for symbol in symbols)
    for _ in range(3):  # a line that is refused may hide mistakes of another kind
        try:
            return kept, toolchain.assemble_object(head + "\n".join(kept), dialect="gnu", **options)
        except toolchain.AssemblyError as error:
            refused = {each["line"] - 1 - len(symbols): each["message"] for each in error.diagnostics}
        for at, message in refused.items():
            shapes = [shape for reason, shape in reasons.items() if reason in message]
            assert any(re.match(shape, kept[at].strip()) for shape in shapes), (message, kept[at])
            kept[at] = ""
    raise AssertionError("lines are refused again and again")


def as_ours(words: Sequence[int]) -> list[int]:
    """GNU's words with the one difference that its sources show: it keeps the exponent of LDM's immediate
    (gnu_differences.toml)."""
    return [word & ~0xF000 if word >> 21 == LDM_OF_AN_IMMEDIATE else word for word in words]
