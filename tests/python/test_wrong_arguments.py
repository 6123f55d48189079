"""Each entry point with a wrong value: the message names the argument, the given value, and what would be right, in our
own words and not pybind11's."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cmrc
import numpy
import pytest
from cmrc import _core, c40, network, page, plant, plot
from cmrc.sweeps import Sweep
from matplotlib.figure import Figure

LOOP = c40.assemble("_start: addi 1,r0\n        b _start\n")
LONGEST = 200
TABLE = cmrc.Table(x=numpy.zeros(3))
RESULT = cmrc.run(dsps=1, duration_s=0.03, keep_events=True, settings={"report.reference": "none"})


def simulation(**more: Any) -> Any:
    return cmrc.Simulation(duration_s=0.05, settings={"report.reference": "none"}, **more)


def processor() -> Any:
    return c40.Processor(LOOP)


def chips(**more: Any) -> Any:
    return network.Network([LOOP, LOOP], links=["0.0:1.3"], **more)


def ran() -> Any:
    made = simulation()
    made.run_until(0.03)
    return made


W = TypeError
V = ValueError
NO_INSTANT = "time_s: "
# Typed as Any: what is wrong on purpose.
RUNS: dict[str, Callable[..., Any]] = {
    "Simulation": cmrc.Simulation,
    "run": cmrc.run,
    "limits": cmrc.limits,
    "compare": cmrc.compare,
}
SHARED: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"settings": [1]}, W, "settings: [1] (list)"),
    ({"settings": "dsps=1"}, W, "settings: 'dsps=1' (str)"),
    ({"settings": {1: 2}}, W, "settings, key: 1 (int)"),
    ({"settings": {"machine.dsps": [1]}}, V, "machine.dsps: <class 'list'>"),
    ({"settings": {"machine.dsps": None}}, V, "machine.dsps: <class 'NoneType'>"),
    ({"settings": {"machine": {"dsps": object}}}, V, "machine.dsps: <class 'type'>"),
    ({"seed": None}, V, "seed: <class 'NoneType'>"),
    ({"duration_s": math.nan}, V, "run.duration_s: nan"),
    ({"duration_s": "long"}, V, 'run.duration_s: "long"'),
    ({"events": {"at_s": 1}}, W, "events: {'at_s': 1} (dict)"),
    ({"events": "fail"}, W, "events: 'fail' (str)"),
    ({"events": 3}, W, "events: 3 (int)"),
    ({"events": [{}, 1]}, W, "events[1]: 1 (int)"),
    ({"events": [{"at_s": [1], "action": "fail"}]}, V, "at_s: <class 'list'>"),
    ({"preset": 3}, W, "preset: 3 (int)"),
    ({"config": 3}, W, "config: 3 (int)"),
    ({"config": b"x"}, W, "config: b'x' (bytes)"),
]
CALLS: dict[str, tuple[Callable[[], Any], type[Exception], str]] = {
    **{
        f"{name}({', '.join(f'{key}={value!r}' for key, value in wrong.items())})": (
            lambda make=make, wrong=wrong: make(**wrong),
            error,
            start,
        )
        for name, make in RUNS.items()
        for wrong, error, start in SHARED
    },
    "Simulation reference": (lambda: cmrc.Simulation(reference=3), W, "reference: 3 (int)"),
    "Simulation profile": (lambda: cmrc.Simulation(profile="no"), W, "profile: 'no' (str)"),
    "run dsps": (lambda: cmrc.run(dsps="two"), V, 'machine.dsps: "two"'),
    "Simulation.run on_progress": (lambda: simulation().run(3), W, "on_progress: <class 'int'>"),
    "on_progress returns a text": (lambda: simulation().run(lambda at, of: "x"), W, "on_progress: it returned 'x'"),
    "on_progress returns a list": (lambda: simulation().run(lambda at, of: []), W, "on_progress: it returned []"),
    "run_until nan": (lambda: simulation().run_until(math.nan), V, NO_INSTANT + "nan"),
    "run_until inf": (lambda: simulation().run_until(math.inf), V, NO_INSTANT + "inf"),
    "run_until -1": (lambda: simulation().run_until(-1), V, NO_INSTANT + "-1"),
    "run_until text": (lambda: simulation().run_until("1"), W, NO_INSTANT + "'1' (str)"),
    "run_until None": (lambda: simulation().run_until(None), W, NO_INSTANT + "None"),
    "run_until back": (lambda: ran().run_until(0.02), V, NO_INSTANT + "0.02 s has passed, the run is at 0.03 s"),
    "run_until back by little": (
        lambda: ran().run_until(numpy.float32(0.03)),
        V,
        NO_INSTANT + "0.0299999993 s has passed, the run is at 0.03 s",
    ),
    "at text": (lambda: simulation().at("x", "fail", dsp=0), V, 'events.at_s: "x"'),
    "at nan": (lambda: simulation().at(math.nan, "fail", dsp=0), V, "events.at_s: nan"),
    "at back": (lambda: ran().at(0.02, "fail", dsp=0), V, "events.at_s: 0.02 s has passed"),
    "at action": (lambda: simulation().at(0.01, 3, dsp=0), V, "events.action: 3"),
    "at list": (lambda: simulation().at(0.01, "fail", dsp=[0]), V, "dsp: <class 'list'>"),
    "peek text": (lambda: simulation().peek("0"), W, "offset: '0' (str)"),
    "peek -1": (lambda: simulation().peek(-1), V, "offset: -1"),
    "peek 10000h": (
        lambda: simulation().peek(0x10000),
        V,
        "offset: 65536 is out of range; an offset in shared memory, 0 to FFFFh, is expected",
    ),
    "dsp text": (lambda: simulation().dsp("0"), W, "slot: '0' (str)"),
    "dsp float": (lambda: simulation().dsp(1.0), W, "slot: 1.0 (float)"),
    "dsp -1": (lambda: simulation().dsp(-1), IndexError, "there is no slot -1; the slots are 0 to 3"),
    "dsp 99": (lambda: simulation().dsp(99), IndexError, "there is no slot 99; the slots are 0 to 3"),
    "limits dsps": (lambda: cmrc.limits(dsps=3), W, "dsps: 3 (int)"),
    "limits dsps text": (lambda: cmrc.limits(dsps="12"), W, "dsps: '12' (str)"),
    "limits dsps None": (lambda: cmrc.limits(dsps=[1, None]), W, "dsps[1]: None"),
    "limits cycles nan": (lambda: cmrc.limits(cycles=[math.nan]), V, "cycles[0]: nan"),
    "limits errors": (lambda: cmrc.limits(dsps=[1], errors="yes"), W, "errors: 'yes' (str)"),
    "limits on_progress": (lambda: cmrc.limits(dsps=[1], on_progress=3), W, "on_progress: 3 (int)"),
    "assemble None": (lambda: c40.assemble(None), W, "text: None"),
    "assemble bytes": (lambda: c40.assemble(b"x"), W, "text: b'x' (bytes)"),
    "assemble name": (lambda: c40.assemble("", name=3), W, "name: 3 (int)"),
    "assemble include_dirs": (lambda: c40.assemble("", include_dirs="abc"), W, "include_dirs: 'abc' (str)"),
    "assemble a folder": (lambda: c40.assemble("", include_dirs=[3]), W, "include_dirs[0]: 3 (int)"),
    "assemble symbols": (lambda: c40.assemble("", symbols=[1]), W, "symbols: [1] (list)"),
    "assemble a symbol": (lambda: c40.assemble("", symbols={"a": "b"}), W, "symbols['a']: 'b' (str)"),
    "assemble a symbol's range": (lambda: c40.assemble("", symbols={"a": -1}), V, "symbols['a']: -1"),
    "assemble a symbol's name": (lambda: c40.assemble("", symbols={1: 1}), W, "symbols, key: 1 (int)"),
    "assemble sections": (lambda: c40.assemble("", sections={".text": 2**40}), V, "sections['.text']: 1099511627776"),
    "assemble entry": (lambda: c40.assemble("", entry=3), W, "entry: 3 (int)"),
    "assemble dialect": (lambda: c40.assemble("", dialect=3), W, "dialect: 3 (int)"),
    "assemble another dialect": (lambda: c40.assemble("", dialect="x"), V, "dialect: "),
    "assemble_file": (lambda: c40.assemble_file(None), W, "path: None"),
    "read_coff": (lambda: c40.read_coff(3), W, "path: 3 (int)"),
    "write_coff program": (lambda: c40.write_coff(3, Path("x")), W, "program: 3 (int)"),
    "write_coff path": (lambda: c40.write_coff(LOOP, 3), W, "path: 3 (int)"),
    "disassemble text": (lambda: c40.disassemble("x"), W, "words: 'x' (str)"),
    "disassemble None": (lambda: c40.disassemble(None), W, "words: None"),
    "disassemble -1": (lambda: c40.disassemble(-1), V, "words: -1"),
    "disassemble a list": (lambda: c40.disassemble([0, "x"]), W, "words[1]: 'x' (str)"),
    "disassemble pc": (lambda: c40.disassemble(0, "x"), W, "pc: 'x' (str)"),
    "Processor": (lambda: c40.Processor(3), W, "program: 3 (int)"),
    "Processor board": (lambda: c40.Processor(board=3), W, "board: 3 (int)"),
    "Processor checks": (lambda: c40.Processor(checks=3), W, "checks: 3 (int)"),
    "load": (lambda: processor().load(None), W, "program: None"),
    "memory text": (lambda: processor().memory["uart"], W, "memory: 'uart' (str)"),
    "memory None": (lambda: processor().memory[None], W, "memory: None"),
    "memory float": (lambda: processor().memory[1.5], W, "memory: 1.5 (float)"),
    "memory -1": (lambda: processor().memory[-1], IndexError, "memory: -1"),
    "memory beyond": (lambda: processor().memory[2**32], IndexError, "memory: 4294967296"),
    "memory slice": (lambda: processor().memory["a":"b"], W, "memory: 'a' (str)"),
    "memory = text": (lambda: processor().memory.__setitem__(0x300000, "x"), W, "a word: 'x' (str)"),
    "memory = float": (lambda: processor().memory.__setitem__(0x300000, 1.5), W, "a word: 1.5 (float)"),
    "memory = too much": (lambda: processor().memory.__setitem__(0x300000, 2**32), V, "a word: 4294967296"),
    "memory slice = word": (lambda: processor().memory.__setitem__(slice(0x300000, 0x300001), 1), W, "memory: 1 (int)"),
    "memory slice = texts": (
        lambda: processor().memory.__setitem__(slice(0x300000, 0x300002), ["x", "y"]),
        W,
        "a word: 'x' (str)",
    ),
    "memory word = list": (lambda: processor().memory.__setitem__(0x300000, [1]), W, "a word: [1] (list)"),
    "read_floats": (lambda: processor().memory.read_floats("x", 1), W, "memory: 'x' (str)"),
    "write_floats": (lambda: processor().memory.write_floats(0x300000, ["x"]), W, "values[0]: 'x' (str)"),
    "registers": (lambda: processor().registers[3], W, "registers: 3 (int)"),
    "registers = text": (lambda: processor().registers.__setitem__("R0", "x"), W, "R0: 'x' (str)"),
    "registers = float": (lambda: processor().registers.__setitem__("AR0", 1.5), W, "AR0: 1.5 (float)"),
    "registers = too much": (lambda: processor().registers.__setitem__("AR0", 2**32), V, "AR0: 4294967296"),
    "floats": (lambda: processor().floats[3], W, "registers: 3 (int)"),
    "floats = text": (lambda: processor().floats.__setitem__("R0", "x"), W, "R0: 'x' (str)"),
    "Processor.type": (lambda: processor().type("\u20ac"), V, "text: '\u20ac' cannot be used; text of one-byte"),
    "Processor.type surrogate": (lambda: processor().type("\ud800"), V, r"text: '\ud800' cannot be used"),
    "Processor.run text": (lambda: processor().run("x"), W, "max_cycles: 'x' (str)"),
    "Processor.run float": (lambda: processor().run(1.5), W, "max_cycles: 1.5 (float)"),
    "Processor.run -1": (lambda: processor().run(-1), V, "max_cycles: -1"),
    "Processor.run huge": (lambda: processor().run(2**70), V, "max_cycles: "),
    "Processor.run until": (lambda: processor().run(10, until=1.5), W, "address: 1.5 (float)"),
    "Processor.run until -1": (lambda: processor().run(10, until=-1), V, "address: -1"),
    "Processor.pc": (lambda: setattr(processor(), "pc", None), W, "address: None"),
    "Processor.trace": (lambda: processor().trace("x"), W, "max_cycles: 'x' (str)"),
    "raise_interrupt": (lambda: processor().raise_interrupt(3), W, "source: 3 (int)"),
    "port": (lambda: processor().port("x"), W, "number: 'x' (str)"),
    "port 9": (lambda: processor().port(9), V, "number: 9"),
    "peripheral": (lambda: processor().peripheral(3), W, "name: 3 (int)"),
    "fields": (lambda: processor().fields(None), W, "name: None"),
    "complete_read": (lambda: processor().complete_read("x"), W, "a word: 'x' (str)"),
    "complete_read waits": (lambda: processor().complete_read(1, transfer=-1), V, "transfer: -1"),
    "config toml": (lambda: _core.cmrc.config({"run.seed": 1}), W, "toml: {'run.seed': 1} (dict)"),
    "config preset": (lambda: _core.cmrc.config(preset=3), W, "preset: 3 (int)"),
    "run_until beyond a double": (
        lambda: simulation().run_until(10**400),
        V,
        "time_s: 1000000000",
    ),
    "run_until beyond all digits": (
        lambda: simulation().run_until(-(10**5000)),
        V,
        "time_s: a number of thousands of digits is beyond the range of a double",
    ),
    "slot beyond all digits": (
        lambda: ran().dsp(10**5000),
        V,
        "slot: a number of thousands of digits is out of range",
    ),
    "path of thousands of digits": (
        lambda: cmrc.read_snapshot(10**5000),
        W,
        "path: a number of thousands of digits (int)",
    ),
    "cut after the end of time": (
        lambda: chips().cut(0, 1e308),
        V,
        "at_us: 1e+308 us is out of range; an instant in us, 0 to 9e12,",
    ),
    "cut beyond a double": (lambda: chips().cut(0, 10**309), V, "at_us: 1000"),
    "Network": (lambda: network.Network(3), W, "programs: 3 (int)"),
    "Network program": (lambda: network.Network([3]), W, "programs: 3 (int)"),
    "Network links": (lambda: network.Network([LOOP], links=3), W, "links: 3 (int)"),
    "Network link": (lambda: network.Network([LOOP, LOOP], links=[3]), W, "links[0]: 3 (int)"),
    "Network link cycles": (
        lambda: network.Network([LOOP, LOOP], links=[("0.0:1.3", {"word_cycles": "x"})]),
        W,
        "links[0], word_cycles: 'x' (str)",
    ),
    "Network topology": (lambda: network.Network(LOOP, topology=3), W, "topology: 3 (int)"),
    "Network clocks": (lambda: chips(clocks_mhz="x"), W, "clocks_mhz: 'x' (str)"),
    "Network boards": (lambda: chips(boards=3), W, "boards: 3 (int)"),
    "Network names": (lambda: chips(names=[1, 2]), W, "names: 1 (int)"),
    "Network memories": (lambda: chips(memories=[3]), W, "memories[0]: 3 (int)"),
    "Network turn_order": (lambda: chips(turn_order="x"), W, "turn_order: 'x' (str)"),
    "Network until": (lambda: chips(until=1.5), W, "until: 1.5 (float)"),
    "Network.from_file": (lambda: network.Network.from_file(3), W, "path: 3 (int)"),
    "Network.run text": (lambda: chips().run(until_us="x"), W, "until_us: 'x' (str)"),
    "Network.run nan": (lambda: chips().run(until_us=math.nan), V, "until_us: nan"),
    "Network.run inf": (lambda: chips().run(until_us=math.inf), V, "until_us: inf"),
    "Network.run -1": (lambda: chips().run(until_us=-1), V, "until_us: -1"),
    "Network.run cycles": (lambda: chips().run(max_cycles="x"), W, "max_cycles: 'x' (str)"),
    "Network.run huge": (lambda: chips().run(max_cycles=10**30), V, "max_cycles: 1"),
    "Network.cut": (lambda: chips().cut("x", 1), W, "link: 'x' (str)"),
    "Network.cut nan": (lambda: chips().cut(0, math.nan), V, "at_us: nan"),
    "Network.hold": (lambda: chips().hold(-1, 1), V, "chip: -1"),
    "Network.memory": (lambda: chips().memory(3), IndexError, "number: there is no shared memory 3"),
    "Network.write_memory": (
        lambda: chips().write_memory(3, 0, [1]),
        IndexError,
        "number: there is no shared memory 3",
    ),
    "run an array": (lambda: cmrc.run(dsps=numpy.zeros(3)), V, "dsps: <class 'numpy.ndarray'>"),
    "run a dictionary": (lambda: cmrc.run(dsps={}), V, "dsps: <class 'dict'>"),
    "settings a dictionary": (
        lambda: cmrc.Simulation(settings={"machine": {"dsps": {}}}),
        V,
        "machine.dsps: <class 'dict'>",
    ),
    "settings an array": (
        lambda: cmrc.Simulation(settings={"machine": {"dsps": numpy.zeros(3)}}),
        V,
        "machine.dsps: <class 'numpy.ndarray'>",
    ),
    "events an array": (
        lambda: cmrc.Simulation(events=[{"at_s": numpy.zeros(2), "action": "fail", "dsp": 0}]),
        V,
        "events[0].at_s: <class 'numpy.ndarray'>",
    ),
    "at an array": (lambda: simulation().at(0.01, "fail", dsp=numpy.zeros(2)), V, "dsp: <class 'numpy.ndarray'>"),
    "write_snapshot path": (lambda: cmrc.write_snapshot(None, simulation().snapshot()), W, "path: None"),
    "extended_to_float text": (lambda: c40.extended_to_float("x"), W, "register: 'x' (str)"),
    "extended_to_float float": (lambda: c40.extended_to_float(3.5), W, "register: 3.5 (float)"),
    "extended_to_float nan": (lambda: c40.extended_to_float(math.nan), W, "register: nan (float)"),
    "extended_to_float -1": (lambda: c40.extended_to_float(-1), V, "register: -1"),
    "single_to_float list": (lambda: c40.single_to_float([1]), W, "word: [1] (list)"),
    "single_to_float -1": (lambda: c40.single_to_float(-1), V, "word: -1"),
    "float_to_extended text": (lambda: c40.float_to_extended("x"), W, "value: 'x' (str)"),
    "float_to_single None": (lambda: c40.float_to_single(None), W, "value: None"),
    "float_to_single nan": (lambda: c40.float_to_single(math.nan), V, "value: nan"),
    "float_to_single 1e300": (lambda: c40.float_to_single(1e300), OverflowError, "value: 1e+300"),
    "decode text": (lambda: c40.decode("x"), W, "word: 'x' (str)"),
    "decode -1": (lambda: c40.decode(-1), V, "word: -1"),
    "decode cpu": (lambda: c40.decode(0, cpu=3), W, "cpu: 3 (int)"),
    "encodings cpu": (lambda: c40.encodings(cpu=None), W, "cpu: None"),
    "read_rom": (lambda: c40.read_rom(3), W, "path: 3 (int)"),
    "read_rom width": (lambda: c40.read_rom("x", width="8"), W, "width: '8' (str)"),
    "Processor.trace labels": (lambda: processor().trace(1, labels=1), W, "labels: 1 (int)"),
    "Network without programs": (lambda: network.Network([]), V, "programs: there is none"),
    "Network topology beside two programs": (lambda: chips(topology=3.5), W, "topology: 3.5 (float)"),
    "Network boots": (lambda: chips(boots=3), W, "boots: 3 (int)"),
    "Network boots a text": (lambda: chips(boots=["x"]), W, "boots[0]: 'x' (str)"),
    "Network clocks an object": (lambda: chips(clocks_mhz=object), W, "clocks_mhz: <class 'object'> (type)"),
    "Network.run array": (lambda: chips().run(until_us=numpy.zeros(2)), W, "until_us: array([0., 0.]) (ndarray)"),
    "SharedMemory pins": (
        lambda: chips(memories=[network.SharedMemory("m", 16, {0: 0x70000000}, pins=["NMI"])]),
        W,
        "memories[0].pins: ['NMI'] (list)",
    ),
    "Debugger.remove": (lambda: processor().debug().remove("x"), W, "number: 'x' (str)"),
    "Debugger.remove 2**31": (lambda: processor().debug().remove(2**31), V, "number: 2147483648 is out of range"),
    "Debugger.break_at ignore": (lambda: processor().debug().break_at(0, ignore="x"), W, "ignore: 'x' (str)"),
    "Network.drive level": (lambda: chips().drive(0, 1, 0), W, "level: 1 (int)"),
    "device beyond the end": (
        lambda: c40.Processor(devices={0xFFFF_FFFE: type("D", (), {"words": 3, "read": int, "write": int})()}),
        V,
        "devices: words of the one at FFFFFFFEh: 3 is out of range",
    ),
    "a long argument of the core": (lambda: plant.gantry_crane("x" * 99), W, f"gantry_crane: '{'x' * 56}... (str)"),
    "a text of 60 characters": (lambda: c40.decode("x" * 58), W, f"word: '{'x' * 58}' (str)"),
    "a text of 61 characters": (lambda: c40.decode("x" * 59), W, f"word: '{'x' * 56}... (str)"),
    "Debugger.enable": (lambda: processor().debug().enable(None), W, "number: None"),
    "Debugger.call": (lambda: processor().debug().call(7, print), V, "there is no stop condition 7"),
    "Debugger.step": (lambda: processor().debug().step(3), W, "how: 3 (int)"),
    "Debugger.step_back": (lambda: processor().debug().step_back(None), W, "how: None"),
    "Debugger.on": (lambda: processor().debug().on(3), W, "kind: 3 (int)"),
    "Debugger.break_at": (lambda: processor().debug().break_at(0, log=3), W, "log: 3 (int)"),
    "Debugger.places": (lambda: processor().debug().places("loop", chip="x"), W, "chip: 'x' (str)"),
    "Debugger.break_at chip": (lambda: processor().debug().break_at("_start", chip=1.5), W, "chip: 1.5 (float)"),
    "Debugger.watch chip": (lambda: processor().debug().watch(0, chip=7), V, "there is no chip 7"),
    "Debugger.watch on": (lambda: processor().debug().watch(0, on=3), V, "on: 3 is unknown"),
    "Debugger.stack": (lambda: processor().debug().stack(chip=1), V, "there is no chip 1; 0 to 0"),
    "Debugger.go inf": (lambda: processor().debug().go(math.inf), V, "time_s: inf"),
    "Debugger.on_output": (lambda: processor().debug().on_output(3), W, "heard: 3 (int)"),
    "plot.sheet": (lambda: plot.sheet(3), W, "result: 3 (int)"),
    "plot.overview": (lambda: plot.overview([1]), W, "recording: [1] (list)"),
    "plot.cdf axes": (lambda: plot.cdf(RESULT, 3), W, "axes: 3 (int)"),
    "plot.gantt from_s": (lambda: plot.gantt(RESULT, Figure().subplots(), "x", 1.0), W, "from_s: 'x' (str)"),
    "sweep folder": (lambda: cmrc.sweep({"fixed": {}}, 3), W, "folder: 3 (int)"),
    "Sweep.rerun": (lambda: Sweep.rerun(None, 3), W, "run: 3 (int)"),
    "plot.grid x": (lambda: plot.grid(object.__new__(Sweep), Figure().subplots(), x=3), W, "x: 3 (int)"),
    "Limits.limit": (
        lambda: cmrc.limits(dsps=[1], settings={"run.duration_s": 0.021}).limit("servo"),
        KeyError,
        "\"scan: 'servo' was not scanned; one of dsps",
    ),
    "plot.grid": (lambda: plot.grid(None, None), W, "sweep: None"),
    "Sweep": (lambda: Sweep(3), W, "folder: 3 (int)"),
    "Table a column": (lambda: TABLE["y"], KeyError, "\"there is no column 'y'; one of x is expected"),
    "Table.from_rows": (lambda: cmrc.Table.from_rows(["a"]), W, "rows: 'a' (str)"),
    "Table.row": (lambda: TABLE.row(5), IndexError, "index: there is no row 5"),
    "Table.row text": (lambda: TABLE.row("x"), W, "index: 'x' (str)"),
    "Scene config": (lambda: plant.Scene(3), W, "config: 3 (int)"),
    "Scene agvs": (lambda: plant.Scene(agvs=17), V, "agvs: 17"),
    "Scene.lock": (lambda: plant.Scene().lock(3), W, "closed: 3 (int)"),
    "Scene.agv": (lambda: plant.Scene().agv(1), V, "index: 1"),
    "Scene.ranges": (lambda: plant.Scene().ranges("x"), W, "index: 'x' (str)"),
    "Scene.restore": (lambda: plant.Scene().restore(3), W, "snapshot: 3 (int)"),
    "Scene.step": (lambda: plant.Scene().step(None, "x"), W, "dt: 'x' (str)"),
    "Scene.drive": (lambda: plant.Scene().drive(0, None, 0.0, 0.0), W, "speed (m/s): None"),
    "Scene.hold": (lambda: plant.Scene().hold(0, "x"), W, "seconds: 'x' (str)"),
    "CraneEnv dt": (lambda: plant.CraneEnv([12.0, 16.0, 14.0], dt="x"), W, "dt: 'x' (str)"),
    "CraneEnv duration": (lambda: plant.CraneEnv([12.0, 16.0, 14.0], duration=None), W, "duration: None"),
    "CraneEnv.reset": (lambda: plant.CraneEnv([12.0, 16.0, 14.0]).reset(options=3), W, "options: 3 (int)"),
    "Crane.sensitivity": (lambda: plant.Crane().sensitivity([0.0] * 5, "x"), W, "seconds: 'x' (str)"),
    "Crane.step": (
        lambda: plant.Crane().step(numpy.zeros(5), "x"),
        W,
        "Crane.step: array([0., 0., 0., 0., 0.]) (ndarray), 'x' (str)",
    ),
    "Agv.step": (lambda: plant.Agv().step("x", 0.0, 0.0, 0.01), W, "Agv.step: 'x' (str)"),
    "Recording": (lambda: page.Recording(1), W, "data: 1 (int)"),
    "Recording.read": (lambda: page.Recording.read(3), W, "path: 3 (int)"),
    "Crane config": (lambda: plant.Crane(numpy.zeros(3)), W, "config: array([0., 0., 0.]) (ndarray)"),
    "Crane.restore": (lambda: plant.Crane().restore(3), W, "snapshot: 3 (int)"),
    "Crane.set_load": (lambda: plant.Crane().set_load("x"), W, "mass: 'x' (str)"),
    "Crane.linearize": (lambda: plant.Crane().linearize(3), W, "state: 3 (int)"),
    "Agv config": (lambda: plant.Agv(3), W, "config: 3 (int)"),
    "Agv.restore": (lambda: plant.Agv().restore(3), W, "snapshot: 3 (int)"),
    "Agv.set_load": (lambda: plant.Agv().set_load(1.0, "x"), W, "inertia: 'x' (str)"),
    "default_dock": (lambda: plant.default_dock("x"), W, "default_dock: 'x' (str) cannot be used; agv_count: a whole"),
    "apply_layout": (lambda: plant.apply_layout(3, ""), W, "apply_layout: 3 (int), '' (str)"),
    "inverse_kinematics": (lambda: plant.inverse_kinematics(3), W, "inverse_kinematics: 3 (int)"),
    "Snapshot.from_bytes": (
        lambda: cmrc.Snapshot.from_bytes("x"),
        W,
        "Snapshot.from_bytes: 'x' (str) cannot be used; bytes",
    ),
    "Pose": (lambda: plant.Pose("x"), W, "Pose: 'x' (str) cannot be used; (x: a number, y: a number, heading: a numb"),
    "Signal": (lambda: plant.Signal(3), W, "Signal: "),
    "Dock": (lambda: plant.Dock(None), W, "Dock: None (NoneType) cannot be used; config: DockConfig"),
    "Dock.advance_to": (
        lambda: plant.Dock(plant.default_dock()).advance_to("x"),
        W,
        "Dock.advance_to: 'x' (str) cannot be used; t: a whole number",
    ),
    "DriveParameters.coulomb": (
        lambda: setattr(plant.DriveParameters(), "coulomb", "x"),
        W,
        "DriveParameters.coulomb: 'x' (str) cannot be used; a number",
    ),
    "DockConfig.crane": (lambda: setattr(plant.default_dock(), "crane", 3), W, "DockConfig.crane: 3 (int)"),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_wrong_argument_is_refused_in_our_words(name: str) -> None:
    call, error, start = CALLS[name]
    with pytest.raises(error) as found:
        call()
    message = str(found.value)
    assert message.startswith(start), message
    assert message.rstrip('"').endswith((" is expected", " are", " is expected (s)")) or "; the " in message, message
    assert len(message) < LONGEST
    for word in ("cmrc._core", "incompatible", "C++", "typing."):
        assert word not in message


def test_a_run_that_is_not_over_says_so() -> None:
    made = simulation()
    before = made.result()
    assert (before.stop_reason, before.report["simulated_s"]) == ("under_way", 0.0)
    assert "The run is not over." in before.text
    made.run_until(0.03)
    assert made.result().stop_reason == "under_way"
    made.run_until(0.03)  # no way back, but to stay is allowed
    made.run_until(1.0)
    assert made.result().stop_reason == "completed" and "not over" not in made.result().text


def test_numbers_of_numpy_are_numbers() -> None:
    made = processor()
    made.memory[numpy.int64(0x300010)] = numpy.uint32(7)
    assert made.memory[numpy.uint32(0x300010)] == 7 and made.run(numpy.int32(4)).reason == "limit"
    run = simulation()
    run.run_until(numpy.float64(0.02))
    assert run.time_s == 0.02 and run.dsp(numpy.int8(0)).plugged
