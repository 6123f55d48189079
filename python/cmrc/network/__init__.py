"""Networks of TMS320C40s connected by their communication ports (docs/networks.md).

ring = cmrc.network.Network(program, topology="ring:8")
stop = ring.run()
ring.chips[0].memory[ring.chips[0].address("token")], ring.links[0].forth.sent
"""

from cmrc.network.description import NetworkError
from cmrc.network.network import Chip, Network
from cmrc.network.records import Event, Link, Net, NetworkStop, PeripheralEvent, SharedMemory, Traffic
from cmrc.snapshots import ChipSnapshot, SnapshotError

__all__ = [
    "Chip",
    "ChipSnapshot",
    "Event",
    "Link",
    "Net",
    "Network",
    "NetworkError",
    "NetworkStop",
    "PeripheralEvent",
    "SharedMemory",
    "SnapshotError",
    "Traffic",
]
