"""A missed job in plain English, from its chain of causes (docs/report.md, Why late)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

PARTS = {
    "host_late": "the host's refresh began late",
    "not_due": "it was in the list and not due yet",
    "host_refresh": "the host's refresh was running",
    "host_lock": "the host waited for the list",
    "doorbell": "a sleeping DSP had to be woken",
    "claim": "a DSP executed the instructions of the claim",
    "claim_bus_a": "the claim waited for bus A",
    "claim_bus_b": "the claim waited for bus B",
    "lock": "another DSP or the host held the list",
    "blocked": "every DSP ran a block that was claimed before this one could be",
    "behind_list": "every DSP ran a block, some with earlier places in the list",
    "no_dsp": "no DSP was running",
    "own_dsp_out": "the only DSP that may run it was out",
    "lost_run": "runs were lost, because their DSP failed",
    "watchdog": "the failure of its DSP was not noticed yet",
    "previous_out": "the block of an earlier tick was not done",
    "stopped_by_error": "an error had stopped the servo, or was not decided yet",
    "left_out": "the experiment left this tick out (scheduling.servo_*)",
    "execution.slow_clock": "its run was longer, because the DSP's clock was slow",
    "execution.execute": "its run was longer: more instructions",
    "slack": "there was less time than a usual run takes",
}
"""The meaning of a chain's part."""

REMEDIES = {
    "blocked": "one more DSP (machine.dsps), or shorter blocks (scheduling.slice_cycles)",
    "behind_list": "one more DSP (machine.dsps), or shorter blocks (scheduling.slice_cycles)",
    "host_late": "a host that is free at its tick (fewer refreshes: rates.refresh_frequency_hz)",
    "host_refresh": "a faster refresh (host.*, or fewer blocks in the list)",
    "host_lock": "fewer DSPs that poll the list (machine.idle_policy)",
    "lock": "fewer DSPs that poll the list (machine.idle_policy)",
    "doorbell": "DSPs that do not sleep (machine.idle_policy)",
    "claim_bus_a": "less traffic on bus A",
    "claim_bus_b": "less traffic on bus B",
    "no_dsp": "a DSP that works",
    "own_dsp_out": "a DSP that works, or no DSP of its own",
    "lost_run": "a DSP that works",
    "watchdog": "a shorter silence limit of the watchdog",
    "execution.slow_clock": "a DSP at full speed",
    "execution.bus_a_arbitration": "less traffic on bus A",
    "execution.bus_b_arbitration": "less traffic on bus B",
    "slack": "a faster DSP (machine.dsp_clock), or a lower rate",
}
"""How to make such a part shorter."""

_OUTCOMES = {
    "late": "was late",
    "unfinished": "was still running at the end of the run, past its deadline",
    "never_started": "had not been started at the end of the run, past its deadline",
    "lost": "was lost with its DSP",
    "dropped": "was dropped",
}


def explain(report: Mapping[str, Any], n: int | None = None) -> str:
    """A paragraph about the missed job of that index in ``report["misses"]``; None: the first by deadline.

    It names the blocks in the job's way, since when, and what would have avoided the miss. Raises IndexError if there
    is no such miss; if there is no miss at all, the text says so.
    """
    misses = report["misses"]
    if n is None:
        if not misses:
            left = int(report["misses_left_out"])
            return (
                "No job missed its deadline."
                if left == 0
                else (f"{left} jobs missed their deadlines, but the report lists none one by one (report.misses_max).")
            )
        n = min(range(len(misses)), key=lambda i: due_ps(misses[i]))
    if not -len(misses) <= n < len(misses):
        listed = f"{len(misses)} missed jobs one by one, 0 to {len(misses) - 1}" if misses else "no missed job"
        raise IndexError(f"n: {n} is out of range; the report lists {listed}")
    return " ".join(_sentences(misses, misses[n]))


def _sentences(misses: Sequence[Mapping[str, Any]], miss: Mapping[str, Any]) -> list[str]:
    job = _name(miss)
    if miss["outcome"] == "dropped" and "previous_out" in miss["parts_ps"] or _is_dropped_tick(miss):
        return _dropped(misses, miss)
    sentences = [f"The job {job} {_OUTCOMES.get(miss['outcome'], miss['outcome'])}: {_when(miss)}"]
    sentences += _in_the_way(miss)
    sentences += _avoidance(miss)
    return sentences


def _is_dropped_tick(miss: Mapping[str, Any]) -> bool:
    return miss["outcome"] == "dropped" and not miss["runs"]


def _dropped(misses: Sequence[Mapping[str, Any]], miss: Mapping[str, Any]) -> list[str]:
    job = _name(miss)
    due = f"its block was due at {_instant(miss['release_ps'])}"
    if miss["previous"] is None:
        cause = _largest(miss, 1)
        why = PARTS.get(cause[0][0], cause[0][0]) if cause else "the host skipped the refresh of its tick"
        return [f"The job {job} was dropped: {due}, and {why}."]
    out = f"the block of {miss['kind']} number {miss['previous']} was not done, and a kind has one block at a time"
    sentences = [f"The job {job} was dropped: {due}, but {out}."]
    same = (miss["kind"], miss["robot"], miss["previous"])
    earlier = next((m for m in misses if (m["kind"], m["robot"], m["number"]) == same), None)
    if earlier is not None and earlier is not miss:
        sentences += _sentences(misses, earlier)
    return sentences


def _when(miss: Mapping[str, Any]) -> str:
    released = f"it was released at {_instant(miss['release_ps'])}"
    if miss["deadline_ps"] is None:
        return f"{released}, has no deadline, and its account ends at {_instant(miss['end_ps'])}."
    ended = "ended" if miss["outcome"] == "late" else "had not ended"
    return (
        f"{released}, had its deadline at {_instant(miss['deadline_ps'])}, and {ended} at "
        f"{_instant(miss['end_ps'])}, {_duration(miss['lateness_ps'])} too late"
        + (f"; a usual run takes {_duration(miss['usual_ps'])}." if miss["usual_ps"] is not None else ".")
    )


def _in_the_way(miss: Mapping[str, Any]) -> list[str]:
    sentences = []
    behind = sorted(miss["behind"], key=lambda block: -block["share_ps"])
    if behind:
        blocks = [_block(block) for block in behind[:3]]
        waited = sum(block["share_ps"] for block in behind)
        since = min(block["from_ps"] for block in behind)
        more = f", and {len(behind) - 3} more" if len(behind) > 3 else ""
        sentences.append(f"It was blocked for {_duration(waited)}, since {_instant(since)}, by {_list(blocks, more)}.")
    others = [(part, ps) for part, ps in _largest(miss, 5) if part not in ("blocked", "behind_list", "slack")][:4]
    whole = sum(ps for part, ps in miss["parts_ps"].items() if ps > 0 and part != "slack")
    others = [(part, ps) for part, ps in others if ps >= 0.05 * whole]
    if others:
        sentences.append(
            "Of its time " + _list([f"{_duration(ps)} passed while {_part(part)}" for part, ps in others]) + "."
        )
    if (short := miss["parts_ps"].get("slack", 0)) > 0:
        sentences.append(f"Its deadline left {_duration(short)} less than a usual run takes.")
    return sentences


def _block(block: Mapping[str, Any]) -> str:
    overtook = ", when this one could have been claimed, too" if block["overtook"] else ""
    return f"{_name(block)} on DSP {block['dsp']} (claimed at {_instant(block['claimed_ps'])}{overtook})"


def _avoidance(miss: Mapping[str, Any]) -> list[str]:
    sentences = []
    if miss["unavoidable_ps"] is not None:
        sentences.append(f"From {_instant(miss['unavoidable_ps'])} on it could not be in time any more.")
    late = miss["lateness_ps"]
    if late is None or late <= 0:
        return sentences
    late += _missing_ps(miss)
    parts = [(part, ps) for part, ps in _largest(miss, len(miss["parts_ps"]))]
    alone = [(part, ps) for part, ps in parts if ps >= late]
    if alone:
        part, ps = alone[0]
        without = (
            f"If its deadline had left time for a usual run ({_duration(ps)} more)"
            if part == "slack"
            else f"Without the {_duration(ps)} in which {_part(part)}"
        )
        done = "at its deadline" if ps == late else f"{_duration(ps - late)} before its deadline"
        sentences.append(f"{without}, the job would have been done {done}{_remedy([part])}.")
        return sentences
    chosen: list[str] = []
    gained = 0
    for part, ps in parts:
        chosen.append(part)
        gained += ps
        if gained >= late:
            break
    if gained >= late and chosen:
        sentences.append(
            f"No single cause made it late, but these together: {'; '.join(_part(part) for part in chosen)}. Without "
            f"them the job would have been in time{_remedy(chosen)}."
        )
    return sentences


def _missing_ps(miss: Mapping[str, Any]) -> int:
    """The rest of a usual run that a job without an end still needed when its account ended."""
    if miss["outcome"] == "late":
        return 0
    return -sum(
        int(ps)
        for part, ps in miss["parts_ps"].items()
        if ps < 0 and (part + ".").startswith(("not_run.", "execution."))
    )


def _remedy(parts: Sequence[str]) -> str:
    remedies = list(dict.fromkeys(REMEDIES[part] for part in parts if part in REMEDIES))
    return f"; this helps: {'; or '.join(remedies)}" if remedies else ""


def _largest(miss: Mapping[str, Any], most: int) -> list[tuple[str, int]]:
    found = [(part, int(ps)) for part, ps in miss["parts_ps"].items() if ps > 0]
    return sorted(found, key=lambda pair: -pair[1])[:most]


def _part(part: str) -> str:
    if part in PARTS:
        return PARTS[part]
    if part.startswith("execution."):
        return f"its run was longer than usual ({part.removeprefix('execution.').replace('_', ' ')})"
    return part.replace("_", " ")


def _name(of: Mapping[str, Any]) -> str:
    robot = "the crane" if of["robot"] == 0 else f"AGV {of['robot'] - 1}"
    return f"{of['kind']} number {of['number']} of {robot}"


def due_ps(miss: Mapping[str, Any]) -> int:
    """The instant by which missed jobs are ordered: the deadline, or the release of a job that has none."""
    return int(miss["deadline_ps"] if miss["deadline_ps"] is not None else miss["release_ps"])


def _instant(ps: int) -> str:
    return f"{ps / 1e12:.9f}".rstrip("0").rstrip(".") + " s"


def _duration(ps: float) -> str:
    for unit, size in (("s", 1e12), ("ms", 1e9), ("us", 1e6), ("ns", 1e3)):
        if abs(ps) >= size:
            return f"{ps / size:.4g} {unit}"
    return f"{ps:.4g} ps"


def _list(parts: Sequence[str], more: str = "") -> str:
    if more:
        return ", ".join(parts) + more
    return parts[0] if len(parts) == 1 else ", ".join(parts[:-1]) + " and " + parts[-1]
