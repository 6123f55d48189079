"""Ctrl-C in every long call: KeyboardInterrupt and nothing else, and what was called can still be used.

The signal is sent when the process has used processor time since it said that it would call, so it is in the call.
"""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from locations import BUILD

PATIENCE = 120
# A shell ignores SIGINT in what it starts in the background, and a test run hands that on.
HEAD = """
import signal
import sys
signal.signal(signal.SIGINT, signal.default_int_handler)
import cmrc
LONG = {"duration_s": 80000, "settings": {"report.signal_decimation": 80000}}
ALONE = {"duration_s": 80000, "settings": {"report.signal_decimation": 80000, "report.reference": "none"}}
loop = cmrc.c40.assemble("_start: addi 1,r0\\n        b _start\\n")
send = cmrc.c40.assemble("_start: ldp 100042h\\nround:  sti r0,@100042h\\n        b round\\n")
take = cmrc.c40.assemble("_start: ldp 100071h\\nround:  ldi @100071h,r0\\n        b round\\n")
def interrupted(call):
    print("calls", flush=True)
    try:
        call()
    except BaseException as error:
        assert type(error) is KeyboardInterrupt, repr(error)
        return
    raise AssertionError("it ended")
"""
CALLS = {
    "Simulation.run": """
simulation = cmrc.Simulation(**LONG)
interrupted(simulation.run)
result = simulation.result()
assert result.stop_reason == "interrupted" and result.report["simulated_s"] == simulation.time_s > 0
assert result.report["errors"] is not None
simulation.run_until(simulation.time_s + 0.01)
assert simulation.result().stop_reason == "under_way"
""",
    "Simulation.run with progress": """
simulation = cmrc.Simulation(**ALONE)
interrupted(lambda: simulation.run(lambda at, of: True))
assert simulation.result().stop_reason == "interrupted"
""",
    "Simulation.run_until": """
simulation = cmrc.Simulation(**ALONE)
interrupted(lambda: simulation.run_until(80000))
time = simulation.time_s
assert 0 < time < 80000
simulation.run_until(time + 0.01)
assert abs(simulation.time_s - time - 0.01) < 1e-9
""",
    "Simulation.result": """
simulation = cmrc.Simulation(**LONG, dsps=1, events=[{"at_s": 0.05, "action": "fail", "dsp": 0}], after_stop_s=0.1)
while not simulation.ended: simulation.run_until(simulation.time_s + 1)
interrupted(simulation.result)
interrupted(simulation.reference)
assert simulation.ended
""",
    "run": "interrupted(lambda: cmrc.run(**ALONE))",
    "limits": "interrupted(lambda: cmrc.limits(dsps=[2, 3, 4], **ALONE, boot='preloaded', **{'start_ms': 0}))",
    "limits with errors": "interrupted(lambda: cmrc.limits(dsps=[2, 3, 4], errors=True, **LONG))",
    "compare": "interrupted(lambda: cmrc.compare(**LONG))",
    "Processor.run": """
processor = cmrc.c40.Processor(loop)
interrupted(lambda: processor.run(10**15, until=0x300100))
cycles = processor.cycles
assert cycles > 0 and processor.run(100).reason == "limit" and processor.cycles >= cycles + 100
""",
    "Processor.run with checks": """
processor = cmrc.c40.Processor(loop, checks=True)
processor.pc = "_start"
interrupted(lambda: processor.run(10**15))
assert processor.run(100).reason == "limit"
""",
    "Processor.trace": """
processor = cmrc.c40.Processor(loop)
interrupted(lambda: processor.trace(10**15))
assert len(processor.trace(8)) > 0
""",
    "Crane.run": """
crane = cmrc.plant.Crane()
interrupted(lambda: crane.run((0.0,) * 5, 0.01, 10**9))
assert crane.state.time_s > 0
crane.run((0.0,) * 5, 0.01, 1)
""",
    "Network.run": """
network = cmrc.network.Network([send, take], links=["0.0:1.3"])
interrupted(lambda: network.run(max_cycles=10**13))
now = network.now_ps
assert now > 0
network.run(until_us=now / 1e6 + 10)
assert network.links[0].forth.sent > 0
""",
    "assemble": """
text = "        .loop 900000\\n        addi 1,r0\\n        .endloop\\n"
def assemble():
    while True: cmrc.c40.assemble(text)
interrupted(assemble)
""",
    "Dock.advance_to": """
scene = cmrc.plant.Scene()
def steps():
    while True: scene.step(None, 60.0)
interrupted(steps)
time = scene.time_s
scene.step(None, 0.5)
assert abs(scene.time_s - time - 0.5) < 1e-9
""",
}


def cpu_ticks(process: "subprocess.Popen[str]") -> int:
    """Of the process and the children that have ended, and of those that have not."""
    total = 0
    numbers = [process.pid]
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    numbers += [int(number) for number in children.read_text().split()]
    for number in numbers:
        try:
            fields = Path(f"/proc/{number}/stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        total += int(fields[11]) + int(fields[12])
    return total


@pytest.mark.parametrize("script", CALLS.values(), ids=list(CALLS))
def test_ctrl_c_raises_keyboard_interrupt(script: str) -> None:
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "python")}
    with subprocess.Popen(
        [sys.executable, "-c", HEAD + script],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            assert line == "calls\n"
            start = cpu_ticks(process)
            while process.poll() is None and cpu_ticks(process) < start + os.sysconf("SC_CLK_TCK") // 10:
                threading.Event().wait(0.005)
            assert process.poll() is None
            process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE)
        assert process.returncode == 0, errors
