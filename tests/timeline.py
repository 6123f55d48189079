"""A Perfetto trace read with the schema of PyPI's perfetto, as Perfetto's trace processor reads one: clocks, interned
names, slices by begin and end, flows by their number."""

from __future__ import annotations

import gzip
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from perfetto.protos.perfetto.trace import perfetto_trace_pb2 as schema

BOOT_TIME = 6
Event = schema.TrackEvent


@dataclass
class Slice:
    track: int
    name: str
    begin: int  # ps; as exact as the notes make it
    end: int
    begin_ns: int
    end_ns: int
    notes: dict[str, Any]
    parent: Slice | None = None


@dataclass
class Instant:
    track: int
    name: str
    at: int  # ps
    notes: dict[str, Any]
    flows: list[int]
    ended_flows: list[int]
    inside: Slice | None = None


@dataclass
class Timeline:
    """Slices by track in their order, instants, counters' values; tracks by their path of names."""

    paths: dict[int, tuple[str, ...]] = field(default_factory=dict)
    units: dict[int, str] = field(default_factory=dict)
    slices: dict[int, list[Slice]] = field(default_factory=lambda: defaultdict(list))
    instants: list[Instant] = field(default_factory=list)
    values: dict[int, list[tuple[int, float]]] = field(default_factory=lambda: defaultdict(list))

    def track(self, *path: str) -> int:
        (found,) = (uuid for uuid, name in self.paths.items() if name == path)
        return found

    def below(self, *path: str) -> Iterator[int]:
        return (uuid for uuid, name in self.paths.items() if name[: len(path)] == path and name != path)


def packets(path: Path) -> list[Any]:
    data = path.read_bytes()
    trace = schema.Trace()
    trace.ParseFromString(gzip.decompress(data) if path.suffix == ".gz" else data)
    return list(trace.packet)


@dataclass
class _Sequence:
    """The incremental state of a sequence of packets."""

    clocks: dict[int, list[Any]] = field(default_factory=dict)  # base ns, whether incremental
    track: int = 0
    clock: int = BOOT_TIME
    names: dict[int, str] = field(default_factory=dict)
    note_names: dict[int, str] = field(default_factory=dict)

    def time(self, packet: Any) -> int:
        clock = packet.timestamp_clock_id if packet.HasField("timestamp_clock_id") else self.clock
        if clock == BOOT_TIME:
            return int(packet.timestamp)
        base, incremental = self.clocks[clock]
        assert incremental
        self.clocks[clock][0] = base + packet.timestamp
        return int(base + packet.timestamp)


def read(path: Path) -> Timeline:
    """Raises AssertionError where the file breaks a rule of the format."""
    timeline = Timeline()
    sequences: dict[int, _Sequence] = {}
    raw: list[tuple[int, int, int, Any, _Sequence]] = []
    parents: dict[int, int] = {}
    names: dict[int, str] = {}
    for number, packet in enumerate(packets(path)):
        assert packet.trusted_packet_sequence_id != 0
        if packet.HasField("track_descriptor"):
            descriptor = packet.track_descriptor
            assert descriptor.uuid not in names, "a track is described twice"
            assert descriptor.parent_uuid == 0 or descriptor.parent_uuid in names, "a track before its parent"
            names[descriptor.uuid], parents[descriptor.uuid] = descriptor.name, descriptor.parent_uuid
            timeline.paths[descriptor.uuid] = (*timeline.paths.get(descriptor.parent_uuid, ()), descriptor.name)
            if descriptor.HasField("counter"):
                timeline.units[descriptor.uuid] = descriptor.counter.unit_name
            continue
        flags = packet.sequence_flags
        if flags & schema.TracePacket.SEQ_INCREMENTAL_STATE_CLEARED:
            assert packet.trusted_packet_sequence_id not in sequences, "a sequence loses its names and clocks"
            sequences[packet.trusted_packet_sequence_id] = _Sequence()
        state = sequences[packet.trusted_packet_sequence_id]
        for clock in packet.clock_snapshot.clocks:
            state.clocks[clock.clock_id] = [clock.timestamp, clock.is_incremental]
        if packet.HasField("trace_packet_defaults"):
            state.clock = packet.trace_packet_defaults.timestamp_clock_id
            state.track = packet.trace_packet_defaults.track_event_defaults.track_uuid
        for row in packet.interned_data.event_names:
            state.names[row.iid] = row.name
        for row in packet.interned_data.debug_annotation_names:
            state.note_names[row.iid] = row.name
        if packet.HasField("track_event"):
            event = packet.track_event
            track = event.track_uuid or state.track
            assert track in names, "an event of an unknown track"
            raw.append((state.time(packet), number, track, event, state))
    _draw(timeline, raw)
    return timeline


def _notes(event: Any, state: _Sequence) -> dict[str, Any]:
    values = {}
    for note in event.debug_annotations:
        name = state.note_names[note.name_iid]
        assert name not in values, "a note is given twice"
        values[name] = note.int_value if note.HasField("int_value") else note.string_value
    return values


def _draw(timeline: Timeline, raw: list[tuple[int, int, int, Any, _Sequence]]) -> None:
    open_slices: dict[int, list[Slice]] = defaultdict(list)
    for at, _, track, event, state in sorted(raw, key=lambda row: row[:2]):
        stack = open_slices[track]
        name = state.names[event.name_iid] if event.name_iid else ""
        if event.type == Event.TYPE_COUNTER:
            assert track in timeline.units
            whole = event.HasField("counter_value")
            timeline.values[track].append((at, event.counter_value if whole else event.double_counter_value))
            continue
        assert track not in timeline.units
        notes = _notes(event, state)
        if event.type == Event.TYPE_SLICE_BEGIN:
            begin = notes.pop("begin_ps", at * 1000)
            assert begin // 1000 == at
            stack.append(Slice(track, name, begin, -1, at, -1, notes, stack[-1] if stack else None))
        elif event.type == Event.TYPE_SLICE_END:
            drawn = stack.pop()
            drawn.end, drawn.end_ns = notes.pop("end_ps", at * 1000), at
            assert drawn.end // 1000 == at
            assert not drawn.notes.keys() & notes.keys()
            drawn.notes |= notes
            timeline.slices[track].append(drawn)
        else:
            assert event.type == Event.TYPE_INSTANT
            exact = notes.pop("at_ps", at * 1000)
            assert exact // 1000 == at
            inside = stack[-1] if stack else None
            timeline.instants.append(
                Instant(track, name, exact, notes, list(event.flow_ids), list(event.terminating_flow_ids), inside)
            )
    assert not any(open_slices.values()), "a slice has no end"
    for drawn_slices in timeline.slices.values():
        drawn_slices.sort(key=lambda one: (one.begin, -one.end))


def check_order(timeline: Timeline) -> None:
    """Two slices of a track are apart, or one contains the other; counters advance in time."""
    for drawn in timeline.slices.values():
        last: dict[int, int] = {}
        for one in drawn:
            assert one.begin <= one.end and one.begin_ns <= one.end_ns
            beside = id(one.parent)
            assert last.get(beside, 0) <= one.begin, one
            last[beside] = one.end
            if one.parent is not None:
                assert one.parent.begin <= one.begin and one.end <= one.parent.end
    for values in timeline.values.values():
        times = [at for at, _ in values]
        assert times == sorted(set(times))


def flows(timeline: Timeline) -> dict[int, tuple[Instant, Instant]]:
    """Start and end of each flow; each flow has exactly one of both, in this order."""
    begun = {flow: one for one in timeline.instants for flow in one.flows}
    ended = {flow: one for one in timeline.instants for flow in one.ended_flows}
    assert sum(len(one.flows) for one in timeline.instants) == len(begun)
    assert sum(len(one.ended_flows) for one in timeline.instants) == len(ended)
    assert begun.keys() == ended.keys()
    assert all(begun[flow].at <= ended[flow].at for flow in begun)
    return {flow: (begun[flow], ended[flow]) for flow in begun}
