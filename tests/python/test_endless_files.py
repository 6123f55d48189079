"""A file without an end, as ``/dev/zero``, is refused by name by every function of the package that reads files."""

import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import cmrc
import pytest
from locations import BUILD

MEMORY = 3 << 30
CALLS = {
    "snapshot": 'cmrc.read_snapshot("/dev/zero")',
    "resume": 'cmrc.Simulation.resume("/dev/zero")',
    "result": 'cmrc.Result.load("/dev/zero")',
    "difference": 'cmrc.diff("/dev/zero", "/dev/zero")',
    "page": 'page.Recording.read("/dev/zero")',
    "trace": 'list(events.of_trace("/dev/zero"))',
    "trace from its second line on": 'list(events.of_trace("line"))',
    "sweep": 'cmrc.sweeps.Sweep("sweep")',
    "part": 'cmrc.sweeps.Sweep("parts")',
    "grid": 'cmrc.sweep("/dev/zero", "new")',
}
NAMED = {
    CALLS["trace from its second line on"]: "line: line 2:",
    CALLS["sweep"]: "{here}/sweep/sweep.json:",
    CALLS["part"]: "{here}/parts/part-000001.parquet:",
}
SCRIPT = """
import resource
import cmrc
import cmrc.sweeps
from cmrc import events, page
resource.setrlimit(resource.RLIMIT_AS, ({memory}, {memory}))
try:
    {call}
except (ValueError, cmrc.Error) as error:
    print(error)
"""


@pytest.mark.unsanitized
@pytest.mark.parametrize("call", CALLS.values(), ids=list(CALLS))
def test_a_file_without_an_end_is_refused_by_name(call: str, tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    for folder, name in (("sweep", "sweep.json"), ("parts", "part-000001.parquet")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / name).symlink_to("/dev/zero")
    (tmp_path / "parts" / "sweep.json").write_text('{"format": 1}')
    (tmp_path / "line").write_text("# cmrc event trace 1\n")
    os.truncate(tmp_path / "line", 2 * MEMORY)
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT.format(memory=MEMORY, call=call)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
        timeout=100,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(NAMED.get(call, "/dev/zero:").format(here=tmp_path)), done.stdout


def test_a_report_may_come_from_a_pipe(tmp_path: Path) -> None:
    report = json.dumps(cmrc.run(dsps=1, duration_s=0.021, settings={"report.reference": "none"}).report)
    (tmp_path / "a.json").write_text(report)
    reader, end = os.pipe()

    def write() -> None:
        with os.fdopen(end, "w") as out:
            out.write(report)

    threading.Thread(target=write, daemon=True).start()
    with os.fdopen(reader):
        assert not cmrc.diff(f"/dev/fd/{reader}", tmp_path / "a.json")
