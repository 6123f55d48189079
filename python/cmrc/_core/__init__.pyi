# The part of the C++ core that the package uses. tests/python/test_stubs.py checks that all of it exists.
from cmrc._core import c40 as c40
from cmrc._core import cmrc as cmrc
from cmrc._core import debug as debug
from cmrc._core import io as io
from cmrc._core import isa as isa
from cmrc._core import network as network
from cmrc._core import plant as plant
from cmrc._core import report as report
from cmrc._core import toolchain as toolchain
from cmrc._core import trace as trace
from cmrc._core import why_late as why_late
from cmrc.errors import Error

class SnapshotError(Error, ValueError): ...

def kind_of_snapshot(sealed: bytes, /) -> str: ...
