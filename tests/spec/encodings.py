"""Every encoding with its operand forms (c40-isa.md 3 and 6), as builders of random words, some with a program
around."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

from .control_encodings import control_encodings
from .fields import (
    CONDITION_CODES,
    FORMS,
    INTEGER_CODES,
    NOP,
    R_CODES,
    Encoding,
    general,
    indirect_8,
    indirect_16,
    offset_8,
    one,
    part_word,
    perhaps_the_pointer,
    shift_count,
)

# c40-isa.md 6.1: op6, mnemonic, modes, source, destination (f: R0 to R11, n: any register).
GENERAL = """
0 absf rdim f f | 1 absi rdim n n | 2 addc rdim n n | 3 addf rdim f f | 4 addi rdim n n | 5 and rdim n n | 6 andn rdim n n
7 ash rdim n n | 8 cmpf rdim f f | 9 cmpi rdim n n | 10 fix rdim f n | 11 float rdim n f | 13 lde rdim f f | 14 ldf rdim f f
15 ldfi di f f | 16 ldi rdim n n | 17 ldii di n n | 18 ldm rdim f f | 19 lsh rdim n n | 20 mpyf rdim f f | 21 mpyi rdim n n
22 negb rdim n n | 23 negf rdim f f | 24 negi rdim n n | 26 norm rdim f f | 27 not rdim n n | 32 or rdim n n | 34 rnd rdim f f
40 stf di f f | 41 stfi di f f | 42 sti di n n | 43 stii di n n | 44 sigi di n n | 45 subb rdim n n | 46 subc rdim n n
47 subf rdim f f | 48 subi rdim n n | 49 subrb rdim n n | 50 subrf rdim f f | 51 subri rdim n n | 52 tstb rdim n n
53 xor rdim n n | 55 toieee rdim f f | 56 frieee di f f | 57 rsqrf rdim f f | 58 rcpf rdim f f | 59 mpyshi rdim n n
60 mpyuhi rdim n n | 61 lda rdim n a
"""
PART_WORDS = [f"{op}{n}" for op in ("lb", "lbu", "lwl", "lwr", "mb") for n in range(4)]
PART_WORDS += [f"{op}{n}" for op in ("lh", "lhu", "mh") for n in range(2)]
THREE = "addc addf addi and andn ash cmpf cmpi lsh mpyf mpyi or subb subf subi tstb xor mpyshi mpyuhi"
PAIRS = """stf_stf sti_sti ldf_ldf ldi_ldi absf_stf absi_sti addf_stf addi_sti and_sti ash_sti fix_sti float_stf ldf_stf ldi_sti
lsh_sti mpyf_stf mpyi_sti negf_stf negi_sti not_sti or_sti subf_stf subi_sti xor_sti toieee_stf frieee_stf"""
THREE_OPERAND_PAIRS = {6, 7, 8, 9, 14, 15, 16, 20, 21, 22, 23}


def general_encodings() -> Iterator[Encoding]:
    for entry in GENERAL.replace("|", "\n").split("\n"):
        if not entry.strip():
            continue
        op, name, modes, source, destination = entry.split()
        for letter in modes:
            mode = "rdim".index(letter)
            yield Encoding(name, FORMS[letter], one(general(int(op), mode, source, destination)))
    for sub, name in enumerate(PART_WORDS):
        for mode, letter in enumerate("rdim"):
            yield Encoding(name, FORMS[letter], one(part_word(sub, mode)))
    yield Encoding("stik", "direct", one(lambda rng: 0x15000000 | rng.getrandbits(21)))
    yield Encoding("stik", "indirect", one(lambda rng: 0x15600000 | rng.getrandbits(5) << 16 | indirect_16(rng)))
    for name, word, codes in (("pop", 0x0E200000, INTEGER_CODES), ("popf", 0x0EA00000, R_CODES),
                              ("push", 0x0F200000, INTEGER_CODES), ("pushf", 0x0FA00000, R_CODES),
                              ("rol", 0x11E00001, INTEGER_CODES), ("rolc", 0x12600001, INTEGER_CODES),
                              ("ror", 0x12E0FFFF, INTEGER_CODES), ("rorc", 0x1360FFFF, INTEGER_CODES)):  # fmt: skip
        yield Encoding(name, "register", one(lambda rng, w=word, c=codes: w | rng.choice(c) << 16))
    yield Encoding("nop", "", one(lambda rng: NOP))
    yield Encoding("nop", "indirect", one(lambda rng: 0x0CC00000 | indirect_16(rng)))
    yield Encoding("idle", "", one(lambda rng: 0x06000000))
    yield Encoding("idle2", "", one(lambda rng: 0x06000001))
    yield Encoding("swi", "", one(lambda rng: 0x66000000))
    yield Encoding("iack", "direct", one(lambda rng: 0x1B200000 | rng.getrandbits(16)))
    yield Encoding("iack", "indirect", one(lambda rng: 0x1B400000 | indirect_16(rng)))
    yield Encoding("ldpk", "immediate", one(lambda rng: 0x1F700000 | rng.getrandbits(16)))
    yield Encoding(
        "ldhi", "immediate", one(lambda rng: 0x1FE00000 | rng.choice(INTEGER_CODES) << 16 | rng.getrandbits(16))
    )
    yield Encoding(
        "ldep", "register", one(lambda rng: 0x76000000 | rng.choice(INTEGER_CODES) << 16 | rng.getrandbits(1))
    )
    yield Encoding(
        "ldpe", "register", one(lambda rng: 0x76800000 | rng.getrandbits(1) << 16 | rng.choice(INTEGER_CODES))
    )


def three_operand_encodings() -> Iterator[Encoding]:
    forms = (("register_register", "indirect_register", "register_indirect", "indirect_indirect"),
             ("register_immediate", "register_offset", "offset_immediate", "offset_offset"))  # fmt: skip
    for op, name in enumerate(THREE.split()):
        is_float, compares = name in ("addf", "cmpf", "mpyf", "subf"), name in ("cmpf", "cmpi", "tstb")
        codes = R_CODES if is_float else INTEGER_CODES
        for type2 in (0, 1):
            for t in range(4):
                if type2 and is_float and not t & 1:
                    continue

                def build(rng: Random, name=name, op=op, type2=type2, t=t, codes=codes, compares=compares) -> int:
                    register = rng.choice(codes)
                    if type2:
                        j = offset_8(rng) if t & 2 else register
                        i = shift_count(rng, 8) if name in ("ash", "lsh") and not t & 1 else rng.getrandbits(8)
                    else:
                        j = indirect_8(rng) if t & 1 else register
                        i = indirect_8(rng) if t & 2 else rng.choice(codes)
                    dst = 0 if compares else rng.choice(codes)
                    if not type2 and t:
                        n = (j if t & 1 else i) & 7
                        dst = dst if compares else perhaps_the_pointer(rng, dst, n, codes)
                        if t == 1:
                            i = perhaps_the_pointer(rng, i, n, codes)
                        elif t == 2:
                            j = perhaps_the_pointer(rng, j, n, codes)
                    return 0x20000000 | type2 << 28 | op << 23 | t << 21 | dst << 16 | j << 8 | i

                yield Encoding(f"{name}3", forms[type2][t], one(build))


def conditional_load_encodings() -> Iterator[Encoding]:
    for k, name in enumerate(("ldfcond", "ldicond")):
        kind = "fn"[k]
        for mode, letter in enumerate("rdim"):
            build = general(0, mode, kind, kind)
            yield Encoding(
                name,
                FORMS[letter],
                one(lambda rng, k=k, b=build: 0x40000000 | k << 28 | rng.choice(CONDITION_CODES) << 23 | b(rng)),
            )


def parallel_encodings() -> Iterator[Encoding]:
    for op, name in enumerate(PAIRS.split()):

        def build(rng: Random, op=op) -> int:
            a, b, c = (rng.getrandbits(3) for _ in range(3))
            if op == 2 or op == 3:
                c = 0
            elif op not in THREE_OPERAND_PAIRS:
                b = 0
            return 0xC0000000 | op << 25 | a << 22 | b << 19 | c << 16 | indirect_8(rng) << 8 | indirect_8(rng)

        yield Encoding(name, "indirect_indirect", one(build))
    for op, name in enumerate(("mpyf_addf", "mpyf_subf", "mpyi_addi", "mpyi_subi")):
        for p in range(4):

            def build_pair(rng: Random, op=op, p=p) -> int:
                return (
                    0x80000000 | op << 26 | p << 24 | rng.getrandbits(8) << 16 | indirect_8(rng) << 8 | indirect_8(rng)
                )

            yield Encoding(name, f"p{p}", one(build_pair))


def encodings() -> list[Encoding]:
    return [
        *general_encodings(),
        *three_operand_encodings(),
        *conditional_load_encodings(),
        *parallel_encodings(),
        *control_encodings(),
    ]
