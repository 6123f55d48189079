"""A dock under the debugger in short pieces: what stops it, and where, does not depend on the pieces or on conditions
that only print."""

from typing import Any

import cmrc
import pytest

END_S = 0.032


def debugger(**settings: Any) -> Any:
    return cmrc.Simulation(dsps=1, duration_s=0.3, settings=settings).debug()


def stops(debugger: Any, piece_s: float) -> list[int]:
    """The instants of all stops up to END_S, by calls of go() to multiples of the piece."""
    found = []
    pieces = 1
    while (until := min(pieces * piece_s, END_S)) <= END_S:
        stop = debugger.go(until)
        if stop.hits:
            found.append(stop.time_ps)
            continue
        assert stop.time_ps == round(until * 1e12)  # never behind it
        if until == END_S:
            break
        pieces += 1
    return found


@pytest.mark.parametrize("event", [{"task": "pid"}, {}])
def test_pieces_and_a_message_lose_no_stop(event: dict[str, str]) -> None:
    whole = debugger()
    whole.on("finish", **event)
    expected = stops(whole, END_S)
    assert len(expected) > 8
    for piece_s, log in ((0.0037, None), (0.001, "hello")):
        pieces = debugger()
        if log:
            pieces.on("claim", log=log)
            pieces.on_output(lambda text: None)
        pieces.on("finish", **event)
        assert stops(pieces, piece_s) == expected, (piece_s, log)


def test_a_message_is_printed_once_for_each_event_and_ignored_ones_are_counted() -> None:
    said: list[str] = []
    pieces = debugger()
    pieces.on("claim", log="hello")
    pieces.on_output(said.append)
    assert stops(pieces, 0.001) == []
    counted = debugger()
    counted.on("claim")
    claims = stops(counted, END_S)
    assert len(said) == len(claims)
    ignoring = debugger()
    ignoring.on("claim", ignore=len(claims) - 1)
    assert stops(ignoring, 0.0013) == claims[-1:]
