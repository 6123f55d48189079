"""What each claim is: an experiment on the emulator, and what is read from its runs."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from cmrc.results.judgement import Row, Verdict
from cmrc.results.runs import Reports, Run
from cmrc.simulation import Setting

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def parameter(default: Any, meaning: str, quick: Any = None, least: float | None = None) -> Any:
    """A field of a claim: its default, what ``--help`` says of it, its value with ``--quick``, if that differs, and the
    least number that it can have. None: a whole number is at least 0, any other number is above 0."""
    metadata = {"help": meaning, "quick": default if quick is None else quick, "least": least}
    return dataclasses.field(default=default, metadata=metadata)


@dataclasses.dataclass(frozen=True)
class Claim(ABC):
    """One claim. Its fields are what a user may change, each made by ``parameter``."""

    NUMBER: ClassVar[int]
    NAME: ClassVar[str]
    TITLE: ClassVar[str]
    PART: ClassVar[str] = ""
    """The label of a run by which the section has parts."""
    PARTS: ClassVar[Mapping[str, str]] = {}
    """What these parts are called, where that is not the label's value."""
    DRAWN: ClassVar[tuple[str, ...]] = ()
    """Labels that are drawn: the settings that go with them are not listed run by run."""
    LABELS: ClassVar[Mapping[str, str]] = {}
    """What runs with a value of a label are called: the braces get the value."""

    @classmethod
    def quick(cls) -> Claim:
        """A shrunken experiment, which shows nothing but that it runs."""
        return cls(**{one.name: one.metadata["quick"] for one in dataclasses.fields(cls)})

    def part(self, run: Run) -> str:
        """The part of the section to which a run belongs; empty without parts."""
        value = str(run.label.get(self.PART, ""))
        return self.PARTS.get(value, value)

    def named(self, label: str, value: Setting) -> str:
        """What runs with this value of a label are called."""
        return self.LABELS.get(label, "{}").format(f"{value:g}" if isinstance(value, float) else value)

    @abstractmethod
    def runs(self) -> list[Run]:
        """The runs to make."""

    @abstractmethod
    def rows(self, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
        """The numbers, from the reports of the runs."""

    @abstractmethod
    def verdict(self, all_rows: Sequence[Row]) -> Verdict:
        """The judgement, from the rows alone."""

    @abstractmethod
    def section(self, all_rows: Sequence[Row]) -> str:
        """What was run, and tables."""

    @abstractmethod
    def draw(self, all_rows: Sequence[Row], figure: Figure) -> None:
        """The plot."""
