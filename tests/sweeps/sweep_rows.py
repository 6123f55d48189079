"""Rows of a sweep's folder, as runs with so many misses would have left them."""

import json
from typing import Any

from cmrc.sweeps import store
from cmrc.sweeps.identity import build
from sweep_helpers import report_with


def row(n: int, place: dict[str, Any], seed: int | None, misses: int | None) -> dict[str, Any]:
    report = report_with(
        tasks={"pid": {"misses": misses}},
        rates={"f_p": {"missed_share": (misses or 0) / 100}},
        errors={"load_m": {"rms": (misses or 0) * 1e-6}},
    )
    done = misses is not None
    return {
        "key": f"{n:064}",
        "status": store.DONE if done else store.REFUSED,
        "message": "" if done else "no",
        "seed": seed,
        "place": json.dumps(place),
        "settings": "{}",
        "hash": "",
        "build": build(),
        "emulator_version": "0",
        "elapsed_s": 1.0,
        "host": "",
        "report": store.packed(report) if done else None,
    }
