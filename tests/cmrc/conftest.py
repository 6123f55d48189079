"""The DSP programs with kernels of users in them, once for each module that runs them."""

from pathlib import Path

import own_dsp_run
import pytest
from files_of_docks import files_of_users


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With boards and layouts of random docks beside them."""
    return files_of_users(tmp_path_factory.mktemp("programs"))


@pytest.fixture(scope="module")
def own_programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With the kernel of tasks that have a DSP of their own."""
    return own_dsp_run.programs_in(tmp_path_factory.mktemp("own") / "programs")
