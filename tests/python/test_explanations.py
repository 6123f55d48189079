"""What ``Result.explain`` says of a chain of causes that is given."""

from typing import Any

import cmrc

US = 1_000_000  # ps


def explained(parts_us: dict[str, int], lateness_us: int, outcome: str = "late", **more: Any) -> str:
    """Of a job that was due 1 s after the start, and has these parts of a chain."""
    miss = {
        "kind": "pid", "number": 7, "robot": 0, "outcome": outcome, "release_ps": 10**12 - 900 * US,
        "deadline_ps": 10**12, "end_ps": 10**12 + lateness_us * US, "lateness_ps": lateness_us * US, "usual_ps": None,
        "unavoidable_ps": None, "parts_ps": {part: us * US for part, us in parts_us.items()}, "behind": [],
        "runs": [{}], "previous": None, **more,
    }  # fmt: skip
    return cmrc.Result({"misses": [miss], "misses_left_out": 0}, "", cmrc.Table()).explain()


def behind(number: int, share_us: int, from_us: int) -> dict[str, Any]:
    claimed = {"claimed_ps": from_us * US, "overtook": False}
    return {
        "kind": "identify",
        "number": number,
        "robot": 1,
        "dsp": 2,
        "share_ps": share_us * US,
        "from_ps": from_us * US,
    } | claimed


def test_a_job_was_blocked_since_the_first_block_in_its_way_not_since_the_longest() -> None:
    text = explained({"blocked": 50}, 50, behind=[behind(3, 10, 40), behind(4, 40, 70)])
    assert "It was blocked for 50 us, since 0.00004 s, by identify number 4 of AGV 0 on DSP 2" in text


def test_an_explanation_names_three_blocks_and_counts_the_others() -> None:
    for blocks, shown, more in ((2, 2, ""), (3, 3, ""), (4, 3, ", and 1 more."), (7, 3, ", and 4 more.")):
        text = explained({"blocked": 50}, 50, behind=[behind(n, 10, 40) for n in range(blocks)])
        assert text.count("identify number") == shown and more in text
        assert (", and 0 more" in text, " and identify number" in text) == (False, not more)


def test_an_explanation_leaves_out_what_is_less_than_a_twentieth_of_the_time() -> None:
    text = explained({"claim": 1000, "lock": 60, "doorbell": 40}, 1100)
    assert "1 ms passed while a DSP executed" in text and "60 us passed while another DSP" in text
    assert "40 us passed" not in text


def test_causes_that_just_make_up_the_lateness_together_avoid_it_together() -> None:
    text = explained({"lock": 60, "doorbell": 40, "claim": 30, "slack": -30}, 100)
    assert (
        "No single cause made it late, but these together: another DSP or the host held the list; a sleeping DSP had to "
        "be woken. Without them the job would have been in time" in text
    )


def test_too_little_time_from_the_start_is_no_time_that_passed() -> None:
    text = explained({"claim": 40, "slack": 1000}, 1040)
    assert "Of its time 40 us passed while a DSP executed" in text and "Its deadline left 1 ms less than" in text
    assert "these together" in text and "passed while there was less time" not in text
    alone = explained({"claim": 40, "slack": 1000}, 900)
    assert "If its deadline had left time for a usual run (1 ms more), the job would have been done" in alone


def test_what_a_job_still_needed_is_the_rest_of_its_run_and_no_slack() -> None:
    """It ran 30 us less than a usual run takes when its account ended, 100 us too late."""
    text = explained({"lock": 200, "execution.execute": -30, "slack": -70}, 100, "unfinished")
    assert "the job would have been done 70 us before its deadline" in text
