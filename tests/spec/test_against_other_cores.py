"""The specification itself against other cores: 16,000 cases of two C3x cores, one of them checked on a board."""

import lzma

from locations import ROOT

from spec.machine import Machine
from spec.state import NAMES, ST

COMMON = ROOT / "tests" / "c40" / "data" / "c3x-common-vectors.txt.xz"


def differences(line: str) -> list[str]:
    left, right = (dict(token.split("=") for token in side.split()) for side in line.split("->"))
    mask = int(left.pop("m"), 16)
    left.pop("id")
    machine = Machine(memory={0x1000: int(left.pop("op"), 16)})
    memory = {int(key[1:], 16): int(text, 16) for key, text in left.items() if key[0] == "@"}
    machine.memory.update(memory)
    for key, text in left.items():
        if key[0] != "@":
            machine.r[NAMES.index(key)] = int(text, 16)
    before = list(machine.r)
    machine.step()
    expected = {key: int(text, 16) for key, text in right.items()}
    found = []
    if machine.pc != expected.pop("PC"):
        found.append("PC")
    for code, name in enumerate(NAMES):
        compared = mask if code == ST else (1 << 40) - 1
        if (machine.r[code] ^ expected.get(name, before[code])) & compared:
            found.append(f"{name}: {machine.r[code]:X}")
    memory |= {int(key[1:], 16): word for key, word in expected.items() if key[0] == "@"}
    memory[0x1000] = machine.memory[0x1000]
    return found + [
        f"@{a:X}" for a in machine.memory.keys() | memory.keys() if machine.memory.get(a, 0) != memory.get(a, 0)
    ]


def test_the_specification_agrees_with_every_common_vector() -> None:
    with lzma.open(COMMON, "rt") as lines:
        wrong = [(line.split()[0], found) for line in lines if (found := differences(line))]
    assert not wrong, wrong[:10]
