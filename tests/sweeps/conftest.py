"""What the tests of sweeps share."""

import contextlib
from collections.abc import Iterator

import pytest
from cmrc.sweeps import session
from cmrc.sweeps.cluster import Workers


@pytest.fixture(scope="module")
def _worker() -> Iterator[Workers]:
    with session.cluster_of(None, 1, None) as found:
        yield found


@pytest.fixture
def one_worker(_worker: Workers, monkeypatch: pytest.MonkeyPatch) -> None:
    """The sweeps of this test have one worker together: the start of a cluster takes a second."""

    @contextlib.contextmanager
    def again(address: str | None, count: int | None, security: object) -> Iterator[Workers]:
        assert (address, count, security) == (None, 1, None)
        yield _worker

    monkeypatch.setattr(session, "cluster_of", again)
