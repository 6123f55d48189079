"""A source text to words, or to its errors."""

import pytest
from cmrc._core import toolchain


def words(source: str, **options: object) -> list[int]:
    return list(toolchain.assemble(source, **options).sections[0].words)


def errors(source: str, **options: object) -> list[tuple[int, int, str]]:
    with pytest.raises(toolchain.AssemblyError) as caught:
        toolchain.assemble(source, **options)
    return [(d["line"], d["column"], d["message"]) for d in caught.value.diagnostics]
