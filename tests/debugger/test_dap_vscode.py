"""The Debug Adapter Protocol by the client that VS Code's own adapters are tested with (npm,
@vscode/debugadapter-testsupport)."""

import shutil
import subprocess
from pathlib import Path

import pytest
from locations import BUILD, ROOT
from sums import write_program

MODULES = ROOT / "build-editor" / "node_modules"


@pytest.mark.skipif(
    shutil.which("node") is None, reason="Node is not installed: Debian 12 has version 18 (apt-get install nodejs npm)"
)
@pytest.mark.skipif(
    not MODULES.is_dir(), reason="scripts/setup editor installs @vscode/debugadapter-testsupport into build-editor"
)
def test_a_session_of_vs_codes_own_test_client(tmp_path: Path) -> None:
    program = write_program(tmp_path)
    script = shutil.copy(ROOT / "tests" / "debugger" / "vscode" / "session.js", MODULES.parent / "session.js")
    done = subprocess.run(
        ["node", script, BUILD / "bin" / "emulator", program], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
