from typing import Any

event_header: str
instruction_header: str

def line(record: dict[str, Any], slot: int = 0) -> str: ...
