"""Short digests of what can be written as JSON, for golden files."""

import hashlib
import json
from typing import Any


def digest(part: Any, digits: int = 16) -> str:
    return hashlib.sha256(json.dumps(part, sort_keys=True, default=str).encode()).hexdigest()[:digits]
