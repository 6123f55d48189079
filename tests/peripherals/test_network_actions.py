"""What is done to a network at an instant: links are cut, chips held, reset and pulled out."""

from __future__ import annotations

import random

import pytest
from cmrc.network import Network, NetworkError
from network_programs import DATA, PERIOD_PS, STOP, check_balance, mixed_network, program, receiver, sender, state


@pytest.mark.parametrize(("into", "bytes_over"), [(0, 0), (1, 0), (2, 1), (3, 2), (4, 3)])
def test_cutting_a_link_in_mid_word(into: int, bytes_over: int) -> None:
    def made() -> Network:
        return Network([program(sender(0, 12)), program(receiver(3, 11))], links=["0.0:1.3"], record_words=True)

    whole = made()
    whole.run()
    third = [event.time_ps for event in whole.events if event.kind == "word"][2]
    network = made()
    cut = third - (5 - into) * PERIOD_PS
    network.cut(0, cut / 1e6)
    network.restore(0, cut / 1e6 + 10)
    assert network.run().reason == "ended"
    (lost,) = [event for event in network.events if event.kind == "lost"]
    assert (lost.time_ps, lost.place, lost.side, lost.word, lost.count) == (cut, 0, 0, 3, bytes_over)
    assert network.chips[1].memory[DATA : DATA + 11] == [n for n in range(1, 13) if n != 3]
    assert network.links[0].forth.lost == 1
    check_balance(network)
    after = [event.time_ps for event in network.events if event.kind == "word"][2]
    assert after == cut + 10_000_000 + 5 * PERIOD_PS


def test_a_cut_for_good_is_a_deadlock_that_says_so() -> None:
    network = Network([program(sender(0, 12)), program(receiver(3, 12))], links=["0.0:1.3"])
    network.cut(0, 1.2)
    assert network.run().reason == "deadlock"
    assert [chip.status for chip in network.chips] == ["halt", "waiting"]
    assert "(the link is cut)" in network.chips[1].message


def test_reset_of_the_side_without_a_right_to_it_loses_the_token_and_says_what_was_discarded() -> None:
    """Chip 1 sends through a port that begins without the token, gets it, and is reset: then neither end has it."""
    network = Network([program(STOP), program(sender(3, 20))], links=["0.0:1.3"])
    network.reset(1, 5)
    network.run(until_us=50)
    assert network.links[0].token_lost
    kinds = [event.kind for event in network.events]
    assert kinds.count("reset") == 1 and kinds.count("dead") == 1
    discarded = [event for event in network.events if event.kind == "discarded"]
    assert discarded and {(event.place, event.side, event.count) for event in discarded} == {(1, 3, 0)}
    assert network.chips[1].port(3)["discarded_output"] == len(discarded)
    assert "(the token is lost)" in network.chips[1].message
    check_balance(network)


def test_a_link_that_is_cut_has_not_lost_its_token() -> None:
    network = Network([program(STOP), program(STOP)], links=["0.0:1.3"])
    network.cut(0, 1)
    network.run(until_us=2)
    assert (network.links[0].cut, network.links[0].token_lost) == (True, False)


def test_a_held_chip_does_nothing_and_continues() -> None:
    network = Network([program(sender(0, 40)), program(receiver(3, 40))], links=["0.0:1.3"])
    network.hold(1, 2)
    assert network.run().reason == "deadlock"  # until somebody releases it
    assert network.chips[1].status == "held"
    network.release(1, 200)
    assert network.run().reason == "ended"
    assert network.chips[1].memory[DATA : DATA + 40] == list(range(1, 41))
    assert network.chips[1].causes["halted"] in range(197 * 20, 199 * 20)


def test_a_chip_that_had_a_fault_has_it_when_it_is_released() -> None:
    network = Network([program("        .word 0FFFFFFFFh\n"), program(STOP)])
    network.hold(0, 2)
    network.release(0, 4)
    network.run(until_us=3)
    assert network.chips[0].status == "held"
    network.run(until_us=5)
    assert network.chips[0].status == "fault"


def test_a_chip_pulled_out_takes_its_links_with_it() -> None:
    network = Network([program(sender(0, 20)), program(receiver(3, 20))], links=["0.0:1.3"])
    network.pull_out(1, 2)
    assert network.run().reason == "deadlock"
    assert network.chips[1].status == "pulled_out" and network.links[0].cut
    assert network.chips[0].waits_for == 1 and "room in output FIFO 0" in network.chips[0].message
    check_balance(network)


def test_a_chip_pulled_out_stands_from_that_instant_on_and_drives_no_pin() -> None:
    """Both count forever; chip 0 has IIOF1 as an output that is low. Without a driver the net is high."""
    count = "        ldi 0,r0\nloop:   addi 1,r0\n        b loop\n"
    network = Network(
        [program("        ldi 20h,iif\n" + count), program(count)], nets=["0.IIOF1>1.IIOF0"], record_words=True
    )
    network.pull_out(0, 2)
    network.run(until_us=4)
    counted, causes = network.chips[0].registers["R0"] & 0xFFFFFFFF, network.chips[0].causes
    assert 0 < counted < 2 * 20
    assert causes["halted"] in range(2 * 20 - 4, 2 * 20 + 1) and sum(causes.values()) == network.chips[0].cycles
    last = [event for event in network.events if event.kind in ("rise", "fall")][-1]
    assert (
        last.kind == "rise" and 0 <= last.time_ps - 2_000_000 <= 4 * PERIOD_PS
    )  # after the instruction that it was at
    network.run(until_us=10)
    assert network.chips[0].registers["R0"] & 0xFFFFFFFF == counted


@pytest.mark.parametrize("action", ["release", "hold", "reset", "pull_out"])
def test_a_chip_that_is_pulled_out_has_no_later_action(action: str) -> None:
    """It is refused when it is given, whichever of the two is given first; an earlier action is not."""

    def made() -> Network:
        return Network([program(sender(0, 20)), program(receiver(3, 20))], links=["0.0:1.3"])

    refused = f"{action} at 4000000 ps: chip 1 is pulled out at 3000000 ps"
    network = made()
    network.pull_out(1, 3)
    with pytest.raises(NetworkError, match=refused):
        getattr(network, action)(1, 4)
    network = made()
    getattr(network, action)(1, 4)
    with pytest.raises(NetworkError, match=refused):
        network.pull_out(1, 3)
    if action != "pull_out":
        getattr(network, action)(1, 2)
        network.pull_out(1, 5)
    network.reset(0, 6)
    network.run()
    assert network.chips[1].status == "pulled_out"
    with pytest.raises(NetworkError, match=f"{action} at 9000000 ps: chip 1 has been pulled out"):
        getattr(network, action)(1, 9)


def test_random_cuts_holds_and_resets_lose_no_word_unsaid() -> None:
    for seed in range(12):
        rng = random.Random(seed)
        network = mixed_network(seed)
        for _ in range(12):
            at = rng.uniform(1, 100)
            kind = rng.choice(["cut", "restore", "hold", "release", "reset"])
            getattr(network, kind)(rng.randrange(3), at)
        other = mixed_network(seed + 100)
        rng = random.Random(seed)
        for _ in range(12):
            at = rng.uniform(1, 100)
            kind = rng.choice(["cut", "restore", "hold", "release", "reset"])
            getattr(other, kind)(rng.randrange(3), at)
        network.run(until_us=120)
        other.run(until_us=120)
        check_balance(network)
        assert state(network) == state(other)
        lost = sum(traffic.lost for link in network.links for traffic in (link.forth, link.back))
        assert lost == sum(event.kind == "lost" for event in network.events)
        discarded = sum(
            chip.port(n)[f"discarded_{side}"]
            for chip in network.chips
            for n in range(6)
            for side in ("input", "output")
        )
        assert discarded == sum(event.kind == "discarded" for event in network.events)


def test_actions_at_one_instant_are_done_in_the_order_in_which_they_were_given() -> None:
    for names, status in ((("hold", "release"), "halt"), (("release", "hold"), "held")):
        network = Network([program("        rpts 99\n        nop\n" + STOP)] * 2, links=["0.0:1.3"])
        for name in names:
            getattr(network, name)(1, 1)
        network.run(until_us=50)
        assert network.chips[1].status == status


def test_an_action_may_be_at_the_very_time_up_to_which_a_network_has_been_run() -> None:
    network = Network([program("        rpts 999\n        nop\n" + STOP)] * 2, links=["0.0:1.3"])
    network.run(until_us=10)
    network.hold(1, 10)
    network.run(until_us=50)
    assert network.chips[1].status == "held"
