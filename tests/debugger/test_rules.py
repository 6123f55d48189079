"""Stops at instructions that break a rule of the manual, against what the checks of a chip alone find."""

from collections import Counter

import cmrc
import pytest
from cmrc.c40 import Processor, assemble
from cmrc.debug import DebugError, Debugger
from cmrc.network import Network

# Three rounds of a loop that breaks two rules each time, and then continues.
SOURCE = """
        .text
start:  ldi 2,r7
        ldhi 2fh,ar0
        or 0f800h,ar0
        ldi 0,bk
again:  ldi *ar0++(1)%,r0
        stii r0,*ar0
        ldii *ar0,r1
        subi 1,r7
        bnn again
        nop
done:   b done
        .end
"""


def breaches_of_the_checks() -> Counter[str]:
    processor = Processor(assemble(SOURCE), checks=True)
    processor.run(max_cycles=2000)
    found: Counter[str] = Counter()
    for diagnostic in processor.diagnostics:
        found[diagnostic.rule] += diagnostic.count
    return found


def debugger_of(kind: str) -> Debugger:
    program = assemble(SOURCE)
    return (
        Processor(program).debug()
        if kind == "chip"
        else Network([program, assemble("start: b start")], links=["0.0:1.3"]).debug()
    )


@pytest.mark.parametrize("kind", ["chip", "network"])
def test_every_breach_of_a_rule_is_a_stop_there_and_back(kind: str) -> None:
    expected = breaches_of_the_checks()
    assert len(expected) == 2 and set(expected.values()) == {3}
    debugger = debugger_of(kind)
    debugger.on("rule")
    forth: list[tuple[int, str]] = []
    while (stop := debugger.go(100e-6)).hits:
        forth += [(stop.time_ps, hit.text) for hit in stop.hits]
    assert Counter(rule for _, text in forth for rule in expected if f" rule {rule} " in text) == expected
    instants = sorted({time for time, _ in forth})
    back = []
    while (stop := debugger.back()).hits:
        back.append(stop.time_ps)
    assert debugger.stop.time_ps == 0 and back == instants[::-1]


def test_one_rule_is_stopped_at_by_its_name() -> None:
    debugger = debugger_of("chip")
    debugger.on("rule", rule="circular")
    stops = 0
    while debugger.go(100e-6).hits:
        assert "circular" in debugger.stop.text
        stops += 1
    assert stops == 3


def test_any_means_no_rules_and_a_rule_that_is_none_is_refused() -> None:
    debugger = debugger_of("network")
    debugger.on("any")
    assert not any(" rule " in hit.text for hit in debugger.go(100e-6).hits)
    with pytest.raises(DebugError, match="circle is not a rule; delay_slot, .*circular, reserved are possible"):
        debugger.on("rule", rule="circle")


def test_the_dock_breaks_no_rule() -> None:
    debugger = cmrc.Simulation(settings={"run.duration_s": 0.05, "report.reference": "none", "machine.dsps": 2}).debug()
    debugger.on("rule", chip=1)
    assert not debugger.go(0.025).hits and debugger.stop.reason == "moved"
