"""Source texts to a linked program, or to the errors of the link."""

import pytest
from cmrc._core import toolchain


def contents(image: toolchain.Image) -> dict[str, tuple[int, list[int]]]:
    return {section.name: (section.address, list(section.words)) for section in image.sections}


def link(*sources: str, map: str = "") -> toolchain.Image:
    objects = [toolchain.assemble_object(source, name=f"{chr(97 + i)}.o") for i, source in enumerate(sources)]
    return toolchain.link(objects, map=map)[0]


def link_errors(*sources: str, map: str = "") -> list[str]:
    with pytest.raises(toolchain.LinkError) as caught:
        link(*sources, map=map)
    return str(caught.value).splitlines()
