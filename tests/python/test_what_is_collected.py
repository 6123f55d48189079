"""Python's garbage collector finds an object that a device or a debugger's listener knows, and that knows them."""

import gc
import weakref

import cmrc
import pytest
from cmrc import c40, network

ENDLESS = c40.assemble("   .text\nx: b x\n")


class Device:
    words = 4
    owner = None

    def read(self, offset: int, cycle: int) -> int:
        return 5

    def write(self, offset: int, value: int, cycle: int) -> None:
        pass

    def save(self) -> bytes:
        return b""

    def load(self, state: bytes) -> None:
        pass


class Watcher:
    def __init__(self) -> None:
        self.simulation = cmrc.Simulation(dsps=1, duration_s=0.03, settings={"report.reference": "none"})
        self.debugger = self.simulation.debug()
        self.debugger.on("claim", log="claimed")
        self.debugger.on_output(self.heard)
        self.texts: list[str] = []
        self.debugger.go()

    def heard(self, text: str) -> None:
        self.texts.append(text)


def test_a_device_that_knows_its_processor() -> None:
    device = Device()
    device.owner = c40.Processor(ENDLESS, devices={0xC0000000: device})  # type: ignore[assignment]
    gone = weakref.ref(device)
    del device
    gc.collect()
    assert gone() is None


def test_a_device_that_knows_its_network() -> None:
    device = Device()
    device.owner = network.Network([ENDLESS], devices={0: {0xC0000000: device}})  # type: ignore[assignment]
    gone = weakref.ref(device)
    del device
    gc.collect()
    assert gone() is None


def test_a_listener_that_knows_its_debugger() -> None:
    watcher = Watcher()
    assert watcher.texts
    gone = weakref.ref(watcher)
    del watcher
    gc.collect()
    assert gone() is None


READS = c40.assemble("   .text\n   ldhi 0c000h,ar0\n   ldi *ar0,r0\nx: b x\n")


@pytest.mark.parametrize("of", ["run", "fork", "debug", "fork of a fork"])
def test_a_device_lives_as_long_as_what_runs_it(of: str) -> None:
    processor = c40.Processor(READS, devices={0xC0000000: Device()})
    net = network.Network([READS], devices={0: {0xC0000000: Device()}})
    gc.collect()
    if of == "debug":
        one, other = processor.debug(), net.debug()
        del processor, net
        gc.collect()
        for debugger in (one, other):
            debugger.break_at("x")
            debugger.go()
            assert debugger.registers()["R0"] is not None
            debugger.back()
        return
    for _ in range(["run", "fork", "fork of a fork"].index(of)):
        processor, net = processor.fork(), net.fork()
        gc.collect()
    processor.run(100)
    net.run(max_cycles=100)
    assert processor.registers["R0"] & 0xFF == 5 == net.chips[0].registers["R0"] & 0xFF


def test_what_is_left_of_a_network_can_be_read() -> None:
    chip = network.Network([READS], devices={0: {0xC0000000: Device()}}).chips[0]
    gc.collect()
    assert chip.registers["R0"] & 0xFF == 0 and chip.console == b"" and chip.not_modelled == [] and chip.message
