"""What a network is described by, and what it reports."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class NetworkStop:
    """Why a run ended: ``ended`` (every chip has ended, or sleeps and nothing can wake it), ``deadlock`` (no event is
    left, and chips wait) or ``limit``."""

    reason: str
    time_ps: int


@dataclass(frozen=True)
class Traffic:
    """Words of one direction of a link that left the sending FIFO: sent = arrived + under_way + lost. ``tokens``: how
    often the sender got the token."""

    sent: int
    arrived: int
    under_way: int
    lost: int
    tokens: int


@dataclass(frozen=True)
class Event:
    """An event of a link (``word``, ``token``, ``lost``, ``dead``, ``cut``, ``restored``), of a net (``rise``,
    ``fall``, ``missed``), or of a chip (``discarded``, ``reset``, ``hold``, ``release``, ``pull_out``).

    ``place`` is the number of the link, net or chip. ``side`` is 0 for the link's first end and 1 for its second; for
    ``discarded`` the port, for ``missed`` the chip. ``count``: bytes of a lost word that had crossed; for a discarded
    word 1 for the input FIFO, 0 for the output FIFO. ``text`` is the line of a link trace.
    """

    kind: str
    time_ps: int
    place: int
    side: int
    word: int
    count: int
    text: str


@dataclass(frozen=True)
class PeripheralEvent:
    """An event of a chip's peripherals: ``port_write`` and ``port_read`` (``number`` the port, ``value`` the word,
    ``channel`` the DMA channel, None for the processor), ``dma_start`` and ``dma_end`` (``number`` the channel;
    ``value`` its control word when START or AUX START became 11; at the end 1 for the auxiliary half), ``timer``,
    ``interrupt`` (``number`` its place in the vector table, ``value`` the interrupted address)."""

    chip: int
    time_ps: int
    kind: str
    cycle: int
    number: int
    value: int
    channel: int | None


@dataclass(frozen=True)
class SharedMemory:
    """Words that several chips access, each at an address inside a window of its board. ``waits``: cycles of an access
    beyond one."""

    name: str
    words: int
    places: Mapping[int, int]
    """Chip to address of word 0."""
    waits: int = 0
    dual_port: bool = False
    """A dual-port memory: its two chips wait for one another only at the same word, and its last two words are
    mailboxes (docs/networks.md)."""
    pins: Mapping[int, str] | None = None
    """For a dual-port memory: chip to the pin that its mailbox pulls low (``IIOF0`` to ``IIOF3``, ``NMI``)."""


@dataclass(frozen=True)
class Link:
    """A link: its ends as (chip, port), and the words from the first to the second end (``forth``) and ``back``."""

    a: tuple[int, int]
    b: tuple[int, int]
    cut: bool
    token_lost: bool
    forth: Traffic
    back: Traffic


@dataclass(frozen=True)
class Net:
    """A wire between pins: ``pins`` as given, its present ``level``, its ``edges`` so far, and how many pulses
    receivers have ``missed``: of a missed pulse neither edge is seen."""

    name: str
    pins: str
    level: bool
    edges: int
    missed: int
