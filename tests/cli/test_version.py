"""One version, from git, in C++ and Python; no hash has it."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import cmrc
import pytest
from cmrc import _core
from cmrc.sweeps import identity
from locations import BUILD, ROOT

VERSION = re.compile(r"\d+\.\d+\.\d+(\.dev\d+\+g[0-9a-f]{7,}(\.d\d{8})?)?")
scm = pytest.mark.skipif(shutil.which("git") is None, reason="git is missing")


def test_the_command_and_the_package_have_one_version(run) -> None:
    assert run("--version").stdout == f"emulator {cmrc.__version__}\n"
    assert VERSION.fullmatch(cmrc.__version__), cmrc.__version__
    other = subprocess.run([BUILD / "bin" / "cmrc", "--version"], capture_output=True, text=True, check=True)
    assert other.stdout == f"cmrc {cmrc.__version__}\n"


def test_a_build_is_the_same_under_another_version() -> None:
    library = Path(_core.__file__).read_bytes()
    mine = identity.digest_without_version(library, cmrc.__version__)
    name = cmrc.__version__.encode()
    other = library.replace(name.ljust(64, b"\0"), b"7.6.5.dev4+g3210fed".ljust(64, b"\0"))
    assert other != library
    assert identity.digest_without_version(other, "7.6.5.dev4+g3210fed") == mine == identity.build()
    changed = bytearray(library)
    changed[len(changed) // 2] ^= 1
    assert identity.digest_without_version(bytes(changed), cmrc.__version__) != mine
    with pytest.raises(ValueError, match="occurs 0 times"):
        identity.digest_without_version(library, "7.6.5")


def asked(folder: Path) -> str:
    command = [sys.executable, "-W", "ignore", "-m", "setuptools_scm"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout.strip()


def git(folder: Path, *words: str) -> None:
    author = ("-c", "user.name=a", "-c", "user.email=a@b")
    subprocess.run(["git", *author, *words], cwd=folder, check=True, capture_output=True)


@scm
def test_the_version_follows_tags_and_is_known_without_git(tmp_path: Path) -> None:
    source = tmp_path / "source"
    source.mkdir()
    shutil.copy(ROOT / "pyproject.toml", source)
    assert asked(source) == "0.0.0"
    (source / "PKG-INFO").write_text("Metadata-Version: 2.1\nName: cmrc\nVersion: 1.2.3\n")
    assert asked(source) == "1.2.3"
    (source / "PKG-INFO").unlink()
    git(source, "init", "-q")
    git(source, "add", ".")
    git(source, "commit", "-qm", "one")
    assert re.fullmatch(r"0\.1\.0\.dev1\+g[0-9a-f]{9,}", asked(source))
    git(source, "tag", "v0.1.0")
    assert asked(source) == "0.1.0"
    git(source, "commit", "-q", "--allow-empty", "-m", "two")
    assert re.fullmatch(r"0\.2\.0\.dev1\+g[0-9a-f]{9,}", asked(source))
    git(tmp_path, "clone", "-q", "--depth", "1", "--no-tags", source.as_uri(), "shallow")
    assert re.fullmatch(r"0\.1\.0\.dev1\+g[0-9a-f]{9,}", asked(tmp_path / "shallow"))


def test_a_module_in_the_users_folder_is_not_taken_for_one_of_python(tmp_path: Path) -> None:
    for name in ("signal", "dis", "select", "cmrc"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('a module of the user')\n")
    command = [BUILD / "bin" / "cmrc", "limits", "--help"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
