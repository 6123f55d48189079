"""The package: what its import brings, its stubs, its installation from the build folder."""

import shutil
import subprocess
import sys
from pathlib import Path

import cmrc
import pytest
from locations import BUILD

HEAVY = (
    *("pandas", "pyarrow", "matplotlib", "dask", "distributed", "optuna", "duckdb", "mujoco", "gymnasium"),
    *("cmrc.sweeps", "cmrc.studies", "subprocess"),
)
"""What who makes one run does not wait for."""


def test_the_import_brings_no_heavy_package() -> None:
    code = f"import sys, cmrc; print([name for name in {HEAVY!r} if name in sys.modules])"
    env = {"PYTHONPATH": str(Path(cmrc.__file__).parent.parent)}
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_what_is_imported_later_is_there_all_the_same() -> None:
    assert set(cmrc.__all__) <= set(dir(cmrc)) and all(hasattr(cmrc, name) for name in cmrc.__all__)
    assert cmrc.sweep is cmrc.sweeps.sweep and cmrc.limits is cmrc.studies.limits
    with pytest.raises(AttributeError, match="module 'cmrc' has no attribute 'sweeep'"):
        cmrc.sweeep  # type: ignore[attr-defined]  # noqa: B018
    assert set(cmrc.plant.__all__) <= set(dir(cmrc.plant)) and cmrc.plant.CraneEnv.__name__ == "CraneEnv"


def test_stubs_stand_beside_the_extension() -> None:
    assert (Path(cmrc.__file__).parent / "_core" / "__init__.pyi").is_file()


def test_a_package_without_its_extension_says_so(tmp_path: Path) -> None:
    ours = Path(cmrc.__file__).parent
    shutil.copytree(ours, tmp_path / "cmrc", ignore=shutil.ignore_patterns("*.so"))
    command = [sys.executable, "-c", "import cmrc"]
    done = subprocess.run(command, env={"PYTHONPATH": str(tmp_path)}, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "has no extension module _core for this Python (cpython-" in done.stderr


def test_an_installed_tree_runs(tmp_path: Path) -> None:
    cmake = shutil.which("cmake")
    if cmake is None:
        pytest.skip("cmake is missing")
    subprocess.run([cmake, "--install", BUILD, "--prefix", tmp_path], check=True, capture_output=True)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bin", "lib"]
    assert [p.name for p in (tmp_path / "bin").iterdir()] == ["emulator"]
    said = subprocess.run([tmp_path / "bin" / "emulator", "--version"], capture_output=True, text=True, check=True)
    [package] = (tmp_path / "lib").glob("python*/site-packages/cmrc")
    assert (package / "c40_programs" / "dsp.asm").is_file()
    code = "import cmrc; print(cmrc.__file__); print('emulator', cmrc.__version__)"
    done = subprocess.run(
        [sys.executable, "-c", code], env={"PYTHONPATH": str(package.parent)}, capture_output=True, text=True, check=True
    )
    assert done.stdout == f"{package}/__init__.py\n{said.stdout}"
