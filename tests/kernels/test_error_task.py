"""The error task's log: entries in order, the oldest overwritten, and no entry twice when its block is run again."""

from harness import WINDOW_A, Dsp


def test_the_log_keeps_the_last_sixteen() -> None:
    dsp = Dsp()
    s = dsp.symbols
    log = WINDOW_A + s["ER_BASE"]
    errors = [(100 + 7 * n, n % 12, 0x1000 + 0x100 * n, n + 1) for n in range(21)]
    for n, (tick, kind, area, generation) in enumerate(errors):
        dsp.chip.poke(s["TASK"] + s["TB_AREA"], area)
        dsp.chip.poke(s["TASK"] + s["TB_GENERATION"], generation)
        for _ in range(2 if n % 3 == 0 else 1):
            result, notify, _ = dsp.run("error", argument=kind, tick=tick)
            assert (result, notify) == (n + 1, 0)
        assert dsp.chip.peek(log) == n + 1
    for n in range(5, 21):
        assert tuple(dsp.chip.read(log + s["ER_LOG"] + 4 * (n % 16), 4)) == errors[n]
