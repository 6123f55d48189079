"""Several processors and links, run in the simplest exact way: the earliest processor runs next."""

from __future__ import annotations

from typing import Any

from cmrc._core import c40, toolchain

CODE, DATA, STACK = 0x2FFC00, 0x2FF800, 0x2FFB00
HERTZ = 20_000_000


def processor(text: str) -> Any:
    """A processor on the default board with this program in on-chip RAM block 1; its stack is in block 0."""
    image = toolchain.assemble("        .text\n" + text, "test.asm", sections={".text": CODE})
    chip = c40.Processor("default")
    chip.load_image(image)
    chip.pc = CODE
    chip.set("SP", STACK)
    return chip


class Network:
    """Chips and links in the order of time: link events before accesses, accesses at one instant in the order of
    `order`."""

    def __init__(self, chips: list[Any], hertz: list[int] | None = None, order: list[int] | None = None) -> None:
        self.chips = chips
        self.hertz = hertz or [HERTZ] * len(chips)
        self.order = order or list(range(len(chips)))
        self.links: list[Any] = []
        self.ends: dict[tuple[int, int], tuple[Any, int]] = {}
        self.other: dict[tuple[int, int], tuple[int, int]] = {}
        self.waiting: dict[int, dict[str, Any]] = {}
        self.since: dict[int, int] = {}
        self.log: list[tuple[int, str, int, int]] = []
        """(chip, read or write, cycle in which the access began, cycle in which it took place)"""

    def join(self, a: int, port_a: int, b: int, port_b: int) -> Any:
        link = c40.Link((self.chips[a], port_a), (self.chips[b], port_b), (self.hertz[a], 1), (self.hertz[b], 1))
        self.links.append(link)
        self.ends[a, port_a], self.ends[b, port_b] = (link, 0), (link, 1)
        self.other[a, port_a], self.other[b, port_b] = (b, port_b), (a, port_a)
        return link

    def at(self, chip: int, cycle: int) -> int:
        return cycle * 10**12 // self.hertz[chip]

    def first_cycle(self, chip: int, time: int) -> int:
        cycle = time * self.hertz[chip] // 10**12
        while self.at(chip, cycle) < time:
            cycle += 1
        return cycle

    def run(self, until: int) -> None:
        """To an instant in picoseconds; accesses from then on wait."""
        while True:
            event = min((link.next_event for link in self.links if link.next_event is not None), default=until)
            turns = [(self._next(n), i, n) for i, n in enumerate(self.order)]
            now, _, n = min(turns)
            if min(event, now) >= until:
                return
            if event <= now:
                unready = [m for m in self.waiting if not self._ready(m)]
                for link in self.links:
                    link.advance_to(event)
                self.since.update({m: event for m in unready if self._ready(m)})
            elif n in self.waiting and self._ready(n) and self.at(n, self._cycle(n)) == now:
                for link in self.links:
                    link.advance_to(now)
                cycle = self._cycle(n)
                stop = self.waiting.pop(n)
                self.chips[n].complete_port(cycle)
                self.log.append((n, "write" if stop["write"] else "read", stop["access_cycle"], cycle))
            else:
                self._advance(n, min(until, self._horizon(n)))

    def _next(self, n: int) -> int:
        """The earliest instant at which a chip could do something."""
        own = self.at(n, self.chips[n].settled) if n not in self.waiting or self.chips[n].dma_active else 2**62
        access = self.at(n, self._cycle(n)) if n in self.waiting and self._ready(n) else 2**62
        return min(own, access)

    def _horizon(self, n: int) -> int:
        if not self.chips[n].watches_ports:
            return 2**62
        horizon = 2**62
        for (m, port), (link, _) in self.ends.items():
            if m == n:
                horizon = min(horizon, link.next_event or horizon, self._next(self.other[m, port][0]) + link.lookahead)
        return horizon

    def _advance(self, n: int, until: int) -> None:
        chip = self.chips[n]
        before = chip.settled
        stop = chip.run(self.first_cycle(n, until) - chip.cycle)
        if stop["reason"] == "limit" and chip.settled == before and n not in self.waiting:
            stop = chip.run(1)  # the DMA is behind its processor, whose next instruction decides how the DMA continues
        assert stop["reason"] in ("port_access", "limit", "horizon"), stop
        if stop["reason"] == "port_access" and n not in self.waiting:
            self.waiting[n] = stop
            self.since[n] = 0

    def _cycle(self, n: int) -> int:
        return max(self.waiting[n]["access_cycle"], self.first_cycle(n, self.since[n]))

    def _ready(self, n: int) -> bool:
        stop = self.waiting[n]
        port = self.chips[n].port(stop["port"])
        if stop["address"] & 0xF == 1 and not stop["write"]:
            return len(port["input"]) > 0
        if stop["address"] & 0xF == 2 and stop["write"]:
            return len(port["output"]) < 8
        return True

    def balance(self) -> None:
        """For each direction of each link: written = read + in FIFOs + under way + lost + discarded by resets."""
        for (n, number), (link, side) in self.ends.items():
            m, other = self.other[n, number]
            mine, theirs, counters = self.chips[n].port(number), self.chips[m].port(other), link.counters(side)
            assert mine["written"] == mine["sent"] + len(mine["output"]) + mine["discarded_output"]
            assert mine["sent"] == counters["sent"] == counters["arrived"] + counters["under_way"] + counters["lost"]
            assert (
                theirs["received"]
                == counters["arrived"]
                == theirs["read"] + len(theirs["input"]) + theirs["discarded_input"]
            )
