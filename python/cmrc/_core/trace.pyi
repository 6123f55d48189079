from typing import Any

from cmrc._core.toolchain import Image

event_header: str
instruction_header: str
labelled_header: str

class Labels:
    def __init__(self, image: Image) -> None: ...
    @staticmethod
    def of_dock(image: Image) -> Labels: ...
    def name(self, address: int) -> str: ...

def line(record: dict[str, Any], slot: int = 0, labels: Labels | None = None) -> str: ...
