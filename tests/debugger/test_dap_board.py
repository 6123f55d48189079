"""A board's console in an editor: what it sends is output of the session, and what it is sent comes from a file."""

from __future__ import annotations

from pathlib import Path

from dap import events
from editor import Editor
from locations import ROOT

BOARD = ROOT / "examples" / "console.toml"
SHOUT = """\
        .text
start:  ldhi    0a000h,ar2
wait:   ldi     *+ar2(1),r0
        tstb    1,r0
        bz      done
        ldi     *ar2,r1
        andn    20h,r1
        sti     r1,*ar2
        b       wait
done:   b       done
"""


def test_a_console_speaks_to_the_editor(tmp_path: Path) -> None:
    for name, text in (("p.asm", SHOUT), ("typed", "hey")):
        (tmp_path / name).write_text(text)
    with Editor() as editor:
        editor.begin(program=str(tmp_path / "p.asm"), board=str(BOARD), consoleInput=str(tmp_path / "typed"))
        editor.configured()
        editor.wait(events.TerminatedEvent)
        assert "HEY" in editor.outputs
