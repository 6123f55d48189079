"""Random programs of what makes the chip's timing difficult, written from the manual's rules: code that changes itself,
the cache's control, wait states that change while accesses are under way, DMA of all priorities, timers from four
cycles up, IDLE, repeats under interrupts, annulled slots, traps, stack and vectors off chip, pins.

A program is a list of fragments and a setting, so that one that fails can be shrunk (nasty_runs.py).
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field

CYCLES = 900
"""Length of a run; a program that ends earlier repeats its last branch, or sleeps."""

CHIP, LOCAL, SLOW, GLOBAL = 0x2FF800, 0x300C00, 0x40000000, 0x80000000
DATA = {"chip": CHIP, "local": LOCAL, "slow": SLOW + 0x100, "global": GLOBAL + 0x600}
CODE = {"chip": 0x2FFC00, "local": 0x300000}
STACK = {"chip": 0x2FFA80, "local": 0x300F00, "global": GLOBAL + 0x700}
VECTORS = {"chip": 0x2FFA00, "local": 0x300A00, "global": GLOBAL + 0x200}
TRAPS = {"chip": 0x2FF800, "local": 0x300800, "global": GLOBAL}

BOARD = """
name = "nasty"
clock_mhz = 40
gmicr = 0x{gmicr:08X}
lmicr = 0x{lmicr:08X}
[[region]]
name = "local"
base = 0x300000
words = 0x1000
bus = "local"
waits = {local}
page_waits = {page}
[[region]]
name = "slow"
base = 0x40000000
words = 0x200
bus = "local"
waits = {slow}
[[region]]
name = "global"
base = 0x80000000
words = 0x800
bus = "global"
waits = {fast}
"""


def interface(rng: random.Random) -> int:
    """GMICR, LMICR: software wait states 0 to 3 on both strobes, ready from pin, counter, either or both."""
    sww, waits = (rng.choice([0, 1, 2, 3]) for _ in range(2)), (rng.randrange(4) for _ in range(2))
    s0, s1 = sww
    w0, w1 = waits
    return 0x1DEA4000 | s0 << 4 | s1 << 6 | w0 << 8 | w1 << 11 | rng.choice([0, 1 << 29])


def constant(value: int, register: str = "r9") -> str:
    return f"        ldhi 0{value >> 16 & 0xFFFF:x}h,{register}\n        or 0{value & 0xFFFF:x}h,{register}\n"


# Instructions that are legal everywhere, in slots and under RPTS too. AR4 and AR5 each go round a circular buffer of
# sixteen words.
PLAIN = [
    "nop", "addi 1,r0", "addi3 r0,r1,r2", "mpyi3 r2,r1,r3", "ldi *ar4++(1)%,r0", "ldi *ar5,r1", "sti r1,*ar5++(1)%", "sti r0,*ar4", "sti r2,*+ar4(1)",
    "xor r3,r2", "cmpi r0,r1", "ldigt r0,r2", "lsh -3,r2", "ldf *ar4,r4", "addf3 r4,r6,r5", "stf r5,*+ar5(1)", "ldi r2,r8", "addc r8,r1", "nop *ar4++(1)%",
    "addi3 *ar4,*ar5,r1", "ldi *ar4,r1\n     || ldi *ar5,r3", "sti r1,*ar4\n     || sti r2,*ar5", "addi3 *ar4,r1,r2\n     || sti r3,*ar5",
]  # fmt: skip


def plain(rng: random.Random, count: int) -> str:
    return "".join(f"        {rng.choice(PLAIN)}\n" for _ in range(count))


def single(rng: random.Random) -> str:
    """One word, for slots and RPTS."""
    return f"        {rng.choice([text for text in PLAIN if '||' not in text])}\n"


def slots(rng: random.Random) -> str:
    return "".join(single(rng) for _ in range(3))


def repeat_block(rng: random.Random, n: int) -> str:
    passes = rng.choice([0, 1, 2, 5, 11])
    if rng.random() < 0.5:
        return f"        ldi {passes},rc\n        rptb e{n}\n{plain(rng, rng.randrange(4))}e{n}:{single(rng)}"
    return (
        f"        ldi {passes},rc\n        rptbd e{n}\n{slots(rng)}{plain(rng, rng.randrange(1, 4))}e{n}:{single(rng)}"
    )


def repeat_around_branch(rng: random.Random, n: int) -> str:
    """A branch inside the block, far enough from its end."""
    return f"        ldi {rng.randrange(1, 6)},rc\n        rptb e{n}\n        cmpi r0,r1\n        bgt m{n}\n{plain(rng, 2)}m{n}:    nop\n{slots(rng)}e{n}:{single(rng)}"


def modify(rng: random.Random, n: int) -> str:
    """A store into code: into the distant routine, or a given number of words ahead. The stored word is an
    instruction."""
    word = f"        ldi @words+{rng.randrange(4)},r10\n"
    if rng.random() < 0.5:
        return (
            word
            + f"        sti r10,@patch+{rng.randrange(3)}\n"
            + rng.choice(["        call patch\n", plain(rng, 3) + "        call patch\n"])
        )
    return word + f"        sti r10,@m{n}\n" + "        nop\n" * rng.randrange(7) + f"m{n}:    addi 7,r7\n"


def timer(rng: random.Random, n: int) -> str:
    which = rng.choice([0, 0, 1])
    base = 0x20 + 0x10 * which
    start = rng.choice([0x2C0, 0x2C0, 0x3C0, 0x280, 0x380, 0])
    return (
        f"        ldi {rng.choice([2, 3, 5, 11, 20, 37, 50, 90])},r9\n        sti r9,*+ar6({base + 8})\n        ldi {start},r9\n        sti r9,*+ar6({base})\n"
        + rng.choice(["", "        ldi 1,iie\n", "        ldhi 8000h,r9\n        or 1,r9\n        ldi r9,iie\n"])
    )


def look(rng: random.Random, n: int) -> str:
    """A read of a peripheral register, with and without a stall before it."""
    where = rng.choice([0x20, 0x24, 0x28, 0x34, 0xA0, 0xA1, 0xA3, 0xA4, 0xB3, 0xC0, 0x40, 0])
    return (
        rng.choice(["", "        addi 0,ar6\n", "        ldi *ar5,r1\n"])
        + f"        ldi *+ar6({where}),r7\n        xor r7,r3\n"
    )


def control_dma(rng: random.Random, n: int) -> str:
    channel = rng.choice([0, 0, 1, 2, 5])
    control = (
        rng.choice([3, 3, 3, 1, 2, 0]) << 22
        | rng.choice([0, 1, 3])
        | rng.choice([1, 1, 1, 2]) << 2
        | rng.choice([0, 1 << 18])
        | rng.choice([0, 0, 0, 1 << 6, 1 << 7])
    )
    count = f"        ldi {rng.choice([1, 2, 5, 13, 40])},r9\n        sti r9,*+ar6({0xA3 + 16 * channel})\n"
    return count + constant(control) + f"        sti r9,*+ar6({0xA0 + 16 * channel})\n"


def subroutine(rng: random.Random, n: int) -> str:
    return rng.choice(
        ["        call sub\n", "        cmpi r1,r2\n        callgt sub\n", f"        laj sub2\n{slots(rng)}", "        trapu 3\n", "        cmpi r1,r0\n        trapge 3\n",
         f"        latu 4\n{slots(rng)}"]
    )  # fmt: skip


def branch(rng: random.Random, n: int) -> str:
    condition = rng.choice(["eq", "ne", "gt", "le", "u"])
    kind = rng.choice(["b{c} e{n}\n", "b{c}d e{n}\n{s}", "b{c}at e{n}\n{s}", "b{c}af e{n}\n{s}"])
    annulled = rng.choice(
        [
            slots(rng),
            "        lda ar4,ar2\n        ldpk 2fh\n        nop\n",
            "        ldi *ar4++(1)%,r0\n        nop *ar5++(1)%\n        ldi 5,r1\n",
        ]
    )
    return (
        "        cmpi r0,r2\n        "
        + kind.format(c=condition, n=n, s=annulled)
        + plain(rng, 2)
        + f"e{n}:    nop\n        ldp @words\n"
    )


def loop(rng: random.Random, n: int) -> str:
    if rng.random() < 0.5:
        return f"        ldi {rng.randrange(1, 6)},ar2\nl{n}:    nop\n{plain(rng, 2)}        dbu ar2,l{n}\n"
    return f"        ldi {rng.randrange(1, 6)},ar2\nl{n}:    nop\n{plain(rng, 1)}        dbud ar2,l{n}\n{slots(rng)}"


def cache(rng: random.Random, n: int) -> str:
    return (
        f"        {rng.choice(['or 0800h,st', 'or 1800h,st', 'or 0400h,st', 'andn 0400h,st', 'andn 0800h,st', 'or 1000h,st', 'or 0C00h,st'])}\n"
        + rng.choice(["", single(rng)])
    )


def interrupts(rng: random.Random, n: int) -> str:
    return rng.choice(
        ["        or 2000h,st\n", "        andn 2000h,st\n", "        ldi 1,iie\n", "        ldhi 0fe00h,iie\n", "        ldi 0,iie\n", "        ldi 9,iif\n", "        ldi 99h,iif\n",
         "        ldi 0,iif\n", "        ldi 3,die\n", "        ldi 0,die\n", "        ldi 1234h,die\n"]
    )  # fmt: skip


def waits(rng: random.Random, n: int) -> str:
    return constant(interface(rng)) + f"        sti r9,*+ar6({rng.choice([0, 4])})\n" + rng.choice(["", plain(rng, 2)])


KINDS: list[tuple[int, Callable[[random.Random, int], str]]] = [
    (6, lambda rng, n: plain(rng, rng.randrange(1, 7))),
    (4, repeat_block),
    (1, repeat_around_branch),
    (2, lambda rng, n: f"        rpts {rng.choice([0, 1, 2, 9, 30])}\n{single(rng)}"),
    (4, modify),
    (4, timer),
    (3, look),
    (5, control_dma),
    (3, subroutine),
    (4, branch),
    (2, loop),
    (3, cache),
    (4, interrupts),
    (2, waits),
    (1, lambda rng, n: f"        {rng.choice(['idle', 'idle', 'idle2'])}\n"),
    (
        2,
        lambda rng, n: (
            "        push r1\n        pop r2\n"
            if rng.random() < 0.5
            else "        push r3\n        pushf r5\n        popf r6\n        pop r1\n"
        ),
    ),
    (1, lambda rng, n: f"        sti r1,*+ar6({0x42 + 0x10 * rng.randrange(3)})\n"),
]

TAIL = """
        dbu ar3,again
end:    bu end
sub:    addi 1,r7
        retsge
        subi 3,r7
        rets
sub2:   addi 2,r7
        bu r11
patch:  addi 1,r7
        addi 2,r7
        addi 3,r7
        rets
words:  addi 10,r7
        subi 1,r7
        xor r7,r3
        nop
isr:    push st
        addi 1,ar0
        ldi *ar4,ar7
        pop st
        reti
trap3:  addi 5,r7
        reti
trap4:  push ar0
        pop ar0
        bu r11
nmi:    addi 1,ar1
        reti
"""


@dataclass(frozen=True)
class Program:
    seed: int
    fragments: tuple[str, ...]
    places: dict[str, str]
    waits: dict[str, int]
    registers: dict[str, int]
    channels: dict[int, dict[int, tuple[str, int]]] = field(default_factory=dict)
    pins: tuple[tuple[int, int], ...] = ()
    """(cycle, IIOF pin; 4 is NMI)"""
    clocks: tuple[float, float] = (40, 40)
    rounds: int = 1

    @property
    def text(self) -> str:
        return "        .text\nstart:  ldp @words\nagain:  ldhi 10h,ar6\n" + "".join(self.fragments) + TAIL


def generate(seed: int) -> Program:
    rng = random.Random(seed)
    weights = [weight for weight, _ in KINDS]
    picked = rng.choices([kind for _, kind in KINDS], weights, k=rng.randrange(4, 22))
    channels: dict[int, dict[int, tuple[str, int]]] = {}
    for n in (0, 1, 2, 5):
        into_code = rng.random() < 0.15
        source = ("words", 0) if into_code else ("", DATA[rng.choice(list(DATA))] + rng.randrange(16))
        destination = ("patch", 0) if into_code else ("", DATA[rng.choice(list(DATA))] + 0x20 + rng.randrange(16))
        steps = rng.choice([0, 1]) if not into_code else 0
        channels[n] = {
            1: source,
            2: ("", steps),
            4: destination,
            5: ("", rng.choice([0, 1]) if not into_code else 0),
            3: ("", rng.choice([1, 3, 8, 30])),
        }
    return Program(
        seed=seed,
        fragments=tuple(kind(rng, n) for n, kind in enumerate(picked)),
        places={"code": rng.choice(list(CODE)), "stack": rng.choice(list(STACK)), "vectors": rng.choice(list(VECTORS)), "traps": rng.choice(list(TRAPS)),
                "ar4": rng.choice(list(DATA)), "ar5": rng.choice(list(DATA))},
        waits={"local": rng.choice([0, 0, 1, 3]), "slow": rng.choice([1, 2, 5, 15]), "fast": rng.choice([0, 0, 2]), "page": rng.choice([0, 0, 0, 2]),
               "gmicr": interface(rng), "lmicr": interface(rng)},
        registers={"ST": rng.choice([0, 0x800, 0x2000, 0x2800, 0x2800]), "IIE": rng.choice([0, 1, 0x80000001, 0xFE000001]), "IIF": rng.choice([0, 0x9999, 0x9]),
                   "DIE": rng.choice([0, 3, 0x1234])},
        channels=channels,
        pins=tuple(sorted((rng.randrange(10, CYCLES), rng.choice([0, 1, 4])) for _ in range(rng.choice([0, 0, 2, 6])))),
        clocks=(rng.choice([40, 50, 33.333]), rng.choice([40, 50, 60])),
        rounds=rng.choice([0, 1, 3]),
    )  # fmt: skip
