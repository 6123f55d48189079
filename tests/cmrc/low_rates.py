"""Settings of a dock that is computed faster: a quarter of the default rates."""

from typing import Any

QUARTER_RATES = {
    "rates.refresh_frequency_hz": 2000,
    "rates.servo_frequency_hz": 250,
    "scheduling.alpha_refreshes": 6,
    "scheduling.beta_refreshes": 3,
}
LOW_RATES: dict[str, Any] = {"dsps": 1, **QUARTER_RATES, "report.reference": "none"}
AT_ONCE_AND_LOW: dict[str, Any] = {**LOW_RATES, "boot": "preloaded"}
"""The same, without a boot before it."""
