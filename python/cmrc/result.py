"""The result of a run."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

from cmrc import arguments
from cmrc.table import Table

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

    from cmrc.differences import Comparable, Difference


class Profile:
    """The DSPs' cycles by place (docs/cli.md, Profiles): by task kind, and within each by routine and by source line.

    A group is a task kind, or the DSPs' time between tasks. Cycles of all groups add up to those of all DSPs, for each
    cause; a kind's cycles are those of its finished jobs, as in ``report["tasks"][kind]["execution_cycles"]``. Columns
    ``causes_...`` are cycles.
    """

    def __init__(self, data: Mapping[str, Any], text: str) -> None:
        self.data: dict[str, Any] = dict(data)
        """Everything, as in the JSON of ``emulator --profile FILE.json``."""
        self.text = text
        """The tables and the annotated source, as on the terminal."""

    @cached_property
    def groups(self) -> Table:
        """One row per group: jobs, instructions, cycles, causes, and the causes outside all instructions
        (``outside_...``)."""
        return Table.from_rows(
            {key: value for key, value in group.items() if key not in ("routines", "lines")}
            for group in self.data["groups"]
        )

    @cached_property
    def routines(self) -> Table:
        """One row per group and routine: calls, and cycles without the routines that it called; most cycles first
        within a group."""
        return self._parts("routines")

    @cached_property
    def lines(self) -> Table:
        """One row per group and executed instruction: address, file and line, source text, cycles."""
        return self._parts("lines")

    def _parts(self, key: str) -> Table:
        return Table.from_rows({"group": group["name"], **part} for group in self.data["groups"] for part in group[key])

    def __repr__(self) -> str:
        return f"<cmrc.Profile: {self.data['cycles']} cycles in {len(self.data['groups'])} groups>"


class Result:
    """A finished run: the report (docs/report.md) as tables and as a dict, and the plant's time series.

    It can be saved, copied and pickled, and compared with another (docs/experiments.md). Column names of tables have
    the units of the report's keys: ``_s`` seconds, ``_ps`` picoseconds, ``cycles``, ``clocks``.
    """

    def __init__(
        self,
        report: Mapping[str, Any],
        text: str,
        signals: Table,
        profile: Profile | None = None,
        events: str | None = None,
    ) -> None:
        self.report: dict[str, Any] = dict(report)
        """The whole report, as in the JSON of ``emulator --report``."""
        self.text = text
        """The report as on the terminal."""
        self.signals = signals
        """The plant's time series: column ``time_s`` and one column per signal, units in the names."""
        self.profile = profile
        """The DSPs' cycles by place; None unless the run was made with ``profile``."""
        self.events = events
        """The event trace (docs/trace.md); None unless the run was made with its events."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the result into one file, whole or not at all; ``load`` reads it. Raises OSError."""
        from cmrc import saved_result

        saved_result.save(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Result:
        """Reads a result that ``save`` wrote. Raises OSError; ResultError with the file's name for any other file."""
        from cmrc import saved_result

        return cls(**saved_result.load(path))

    def diff(self, other: Comparable) -> Difference:
        """The differences between this result and another (a result, a report, a file): ``cmrc.diff``."""
        from cmrc.differences import diff

        return diff(self, other)

    def explain(self, n: int | None = None) -> str:
        """A paragraph about a missed job, ``missed[n]``; None: the first by deadline.

        It names the blocks in the job's way, since when, and what would have avoided the miss. Raises IndexError if
        there is no such miss.
        """
        from cmrc.explanations import explain

        miss = None if n is None else arguments.whole("n", n, "the number of a missed job", -(2**63), 2**63 - 1)
        return explain(self.report, miss)

    def plot(self) -> Figure:
        """Deadlines, response times and the load's error on one sheet (``cmrc.plot``). Raises ImportError without
        matplotlib."""
        from cmrc.extras import needed

        needed("matplotlib", "plot", "plot")
        from cmrc import plot

        return plot.sheet(self)

    def to_frame(self) -> pandas.DataFrame:
        """A tidy frame: one row per task kind and metric, and with kind "run" per metric of the whole run.

        Columns ``kind``, ``metric``, ``unit``, ``value``; NaN if nothing was measured. Raises ImportError without
        pandas.
        """
        from cmrc.frames import to_frame

        return to_frame(self.report)

    @property
    def version(self) -> str:
        """Version of the emulator that made the run."""
        return str(self.report["emulator_version"])

    @property
    def hash(self) -> str:
        """SHA-256 of the run: equal for equal configurations, on every run."""
        return str(self.report["hash"])

    @property
    def stop_reason(self) -> str:
        """``completed``, ``interrupted``, ``job_done``, ``no_dsp_left``, ``drives_stopped`` or ``plant_fault``."""
        return str(self.report["stop_reason"])

    @property
    def misses(self) -> int:
        """Missed deadlines of all kinds."""
        return sum(int(task["misses"]) for task in self.report["tasks"].values())

    @property
    def missed(self) -> list[dict[str, Any]]:
        """Missed jobs one by one, each with the chain of causes that adds up to its lateness (docs/report.md, Why
        late).

        At most ``report.misses_max`` of them; ``report["misses_left_out"]`` is the number of the others.
        ``Table.from_rows(result.missed)`` is a table.
        """
        return list(self.report["misses"])

    @property
    def rates(self) -> dict[str, Any]:
        """f_p, f_t and f_a: demanded, released, missed, realised (docs/report.md, Rates). KeyError without a
        reference."""
        if self.report["rates"] is None:
            raise KeyError("rates: the run has no reference, or is not over")
        return dict(self.report["rates"])

    @property
    def errors(self) -> dict[str, Any]:
        """Load, joints, sway, vehicles and lag against the ideal run (docs/report.md, Errors). KeyError without a
        reference."""
        if self.report["errors"] is None:
            raise KeyError("errors: the run has no reference, or is not over")
        return dict(self.report["errors"])

    @cached_property
    def tasks(self) -> Table:
        """One row per task kind: the classes of jobs, response times (``response_ps_p99`` ...), causes."""
        return Table.from_rows({"kind": kind, **task} for kind, task in self.report["tasks"].items())

    @cached_property
    def dsps(self) -> Table:
        """One row per DSP: cycles, instructions, and the cycles by cause (``causes_execute`` ...)."""
        return Table.from_rows(self.report["dsps"])

    @cached_property
    def buses(self) -> Table:
        """One row per bus and master: its waits and words, and the bus's own clocks by use."""
        rows = []
        for name, bus in self.report["buses"].items():
            whole = {key: value for key, value in bus.items() if key not in ("masters", "targets")}
            rows += [{"bus": name, "master": master, **counts, **whole} for master, counts in bus["masters"].items()]
        return Table.from_rows(rows)

    @cached_property
    def cycles(self) -> Table:
        """One row per work cycle: t_3 to t_6, t_w, t_v, T_g, T_a and the time of delivery, in s; NaN if not reached."""
        return Table.from_rows(self.report["cycles"])

    def __repr__(self) -> str:
        return (
            f"<cmrc.Result: {self.report['simulated_s']} s on {len(self.report['dsps'])} DSPs, {self.misses} misses, "
            f"{self.report['containers_delivered']} delivered, {self.stop_reason}>"
        )

    def _repr_html_(self) -> str:
        from cmrc.frames import to_html

        return to_html(self.report, repr(self)[1:-1])
