"""Boot streams that end early or name memory that does not exist, DMA into nothing, names of registers that do not
exist: what each chip says."""

from __future__ import annotations

import pytest
from cmrc.network import Network
from network_programs import DATA, IDLES, STOP, program
from scenarios import RUN, STOP_AT_END, channel, same_for_every_turn_order, stream_sender


@pytest.mark.parametrize("word", [(), (1,), (2, 3)])
def test_boot_streams_that_are_cut_short(word: tuple[int, ...]) -> None:
    stream = [0x3E39FFF0, 0x3E39FFF0, 8, 0x2FFC00, *word]

    def made(seed: int) -> Network:
        network = Network(
            [stream_sender(len(stream)), program(STOP)],
            links=["0.0:1.3"],
            boots=[1],
            turn_order=seed,
        )
        network.chips[0].memory[0x300000 : 0x300000 + len(stream)] = stream
        return network

    network = same_for_every_turn_order(made)
    chip = network.chips[1]
    assert chip.status == "waiting" and chip.waits_for == 0
    assert chip.message.startswith("waits for a word in input FIFO 3 from chip 0 port 0 since cycle ")
    assert f"(the boot loader, which has taken {len(stream)} words of its stream from port 3)" in chip.message


@pytest.mark.parametrize(("destination", "message"), [
    (0x200000, "write to 00200000h, which is reserved on board default"),
    (0x800, "write to 00000800h, which is in the boot ROM"),
    (0x100010, "analysis block"),
])  # fmt: skip
def test_boot_streams_that_name_memory_that_is_not_there(destination: int, message: str) -> None:
    stream = [0x3E39FFF0, 0x3E39FFF0, 1, destination, 7]
    network = Network(
        [stream_sender(len(stream)), program(STOP)],
        links=["0.0:1.3"],
        boots=[1],
    )
    network.chips[0].memory[0x300000 : 0x300000 + len(stream)] = stream
    assert network.run().reason == "ended"
    chip = network.chips[1]
    assert chip.status == "fault" and message in chip.message
    assert "(the boot loader, which has taken 5 words of its stream from port 3)" in chip.message
    assert "board default has RAM from 002FF800h, 00300000h, 40000000h, 80000000h on" in chip.message


@pytest.mark.parametrize(("destination", "status", "message"), [
    (0x200000, "fault", "DMA channel 4: write to 00200000h, which is reserved on board default"),
    (0x100010, "fault", "DMA channel 4: write to 00100010h, which is a register of the analysis block"),
    (0x70000000, "external_access", "DMA channel 4 writes 70000000h"),
])  # fmt: skip
def test_dma_into_nothing(destination: int, status: str, message: str) -> None:
    network = Network([program(IDLES), program(STOP)], links=["0.0:1.3"])
    channel(
        network.chips[0],
        4,
        RUN | STOP_AT_END,
        source=DATA,
        source_index=1,
        counter=3,
        destination=destination,
        destination_index=1,
    )
    assert network.run().reason == "ended"
    assert network.chips[0].status == status and message in network.chips[0].message


def test_names_of_registers_that_do_not_exist() -> None:
    chip = Network([program(STOP)]).chips[0]
    for ask in (chip.peripheral, chip.fields):
        with pytest.raises(IndexError, match=r"DMA7\.counter.*DMA\d\.counter"):
            ask("DMA7.counter")
    with pytest.raises(KeyError, match="no register is called R12"):
        chip.registers["R12"]
