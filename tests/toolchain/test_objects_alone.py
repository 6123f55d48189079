"""An object by itself: it runs, and its relocations are shown."""

import subprocess
from pathlib import Path

HERE = Path(__file__).parent / "linking"


def test_an_object_runs_by_itself(tmp_path: Path, emulator: Path) -> None:
    (tmp_path / "p.asm").write_text(
        "\t.global START\n\tnop\nSTART:\tldi 5,r0\n\tldp x\n\tsti r0,@x\ndone:\tb done\n\t.data\nx:\t.word 0\n"
    )
    subprocess.run([emulator, "asm", "-c", "p.asm", "-o", "p.o"], cwd=tmp_path, check=True)
    done = subprocess.run(
        [emulator, "exec", "p.o", "--until", "done", "--dump", "x:1"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.splitlines()[-1] == "00300005: 00000005"
    listed = subprocess.run(
        [emulator, "exec", HERE / "b.gnu.o", "--max-cycles", "1", "--entry", "ext"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert "00300001" in listed.stdout


def test_an_object_shows_its_relocations(tmp_path: Path, emulator: Path) -> None:
    done = subprocess.run([emulator, "disasm", HERE / "a.gnu.o"], capture_output=True, text=True, check=True).stdout
    assert "00000008  62FFFFF7  call 0x0  ; R_PCR24 ext" in done and "local:\n0000000F" in done
