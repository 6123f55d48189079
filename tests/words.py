"""Words of memory as numbers."""


def signed(word: int, bits: int = 32) -> int:
    word &= (1 << bits) - 1
    return word - (1 << bits) if word >> bits - 1 else word
