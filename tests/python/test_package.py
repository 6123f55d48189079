"""The package: what its import brings, its stubs, its installation from the build folder."""

import ast
import re
import shutil
import subprocess
import sys
from pathlib import Path

import cmrc
import pytest
import tomllib
from locations import BUILD, ROOT

HEAVY = (
    *("pandas", "pyarrow", "matplotlib", "dask", "distributed", "optuna", "duckdb", "mujoco", "gymnasium"),
    *("cmrc.sweeps", "cmrc.studies", "subprocess"),
)
"""Packages that a single run must not load."""


@pytest.mark.unsanitized
def test_the_import_brings_no_heavy_package() -> None:
    code = f"import sys, cmrc; print([name for name in {HEAVY!r} if name in sys.modules])"
    env = {"PYTHONPATH": str(Path(cmrc.__file__).parent.parent)}
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


SUBINTERPRETER = """
try:
    import _interpreters as interpreters
    run = interpreters.exec
except ImportError:
    import _xxsubinterpreters as interpreters
    run = interpreters.run_string
number = interpreters.create()
try:
    print(run(number, "import cmrc"))
except Exception as error:
    print(error)
"""


@pytest.mark.unsanitized
def test_a_subinterpreter_cannot_import_it() -> None:
    env = {"PYTHONPATH": str(Path(cmrc.__file__).parent.parent)}
    done = subprocess.run(
        [sys.executable, "-c", SUBINTERPRETER], env=env, capture_output=True, text=True, check=True, timeout=60
    )
    assert "ImportError" in done.stdout and "a subinterpreter cannot import it" in done.stdout


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


@pytest.mark.unsanitized
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
        [sys.executable, "-c", code],
        env={"PYTHONPATH": str(package.parent)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == f"{package}/__init__.py\n{said.stdout}"


PYPROJECT = (ROOT / "pyproject.toml").read_text()


def extras() -> dict[str, list[str]]:
    """What each extra of pyproject.toml installs, extras inside extras followed: names of distributions."""
    table = tomllib.loads(PYPROJECT)["project"]["optional-dependencies"]

    def names(extra: str) -> list[str]:
        found: list[str] = []
        for requirement in table[extra]:
            if inner := re.match(r"cmrc\[([\w,]+)\]", requirement):
                found += [name for each in inner[1].split(",") for name in names(each)]
            else:
                found.append(re.split(r"[>=;]", requirement)[0].strip())
        return found

    return {extra: names(extra) for extra in table}


def asked_for() -> list[tuple[str, str]]:
    """Module and extra of each call of extras.needed and extras.installed in the package."""
    found = []
    for path in sorted((ROOT / "python" / "cmrc").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.Call) or len(node.args) != 3:
                continue
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", None)
            extra = node.args[1]
            if name in ("needed", "installed") and isinstance(extra, ast.Constant):
                modules = [
                    each.value
                    for each in ast.walk(node.args[0])
                    if isinstance(each, ast.Constant) and isinstance(each.value, str)
                ]
                found += [(module.split(".")[0], extra.value) for module in modules]
    return found


def test_a_missing_package_is_in_the_extra_that_its_error_names() -> None:
    installs = extras()
    distribution = {"distributed": "dask[distributed]", "dask": "dask[distributed]"}
    asked = [pair for pair in asked_for() if pair[0] != "tomllib"]
    assert {extra for _, extra in asked} >= {"pandas", "plot", "sweep", "search"}
    wrong = [(module, extra) for module, extra in asked if distribution.get(module, module) not in installs[extra]]
    assert wrong == []


def test_all_installs_what_every_extra_for_users_does() -> None:
    installs = extras()
    for_users = {name for extra, names in installs.items() if extra not in ("test", "docs") for name in names}
    assert set(installs["all"]) == for_users


def test_the_starter_in_a_wheel_says_where_the_commands_are(tmp_path: Path) -> None:
    """In a wheel the program is in the package, and the command cmrc beside the script that starts the program."""
    package, scripts = tmp_path / "cmrc", tmp_path / "scripts"
    (package / "bin").mkdir(parents=True)
    scripts.mkdir()
    (package / "__init__.py").touch()
    shutil.copy(BUILD / "bin" / "emulator", package / "bin" / "emulator")
    shutil.copy(ROOT / "python" / "emulator", scripts / "emulator")
    (scripts / "cmrc").write_text('#!/bin/sh\necho cmrc "$@"\n')
    (scripts / "cmrc").chmod(0o755)
    command = [sys.executable, scripts / "emulator", "limits", "--dsps", "1,2"]
    env = {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("cmrc limits --dsps 1,2\n", "")


def test_a_configuration_without_packages_names_them_all(tmp_path: Path) -> None:
    cmake = shutil.which("cmake")
    if cmake is None:
        pytest.skip("cmake is missing")
    (tmp_path / "scripts" / "requirements").mkdir(parents=True)
    shutil.copy(ROOT / "CMakeLists.txt", tmp_path)
    listed = (ROOT / "scripts" / "requirements" / "debian.txt").read_text()
    absent = "libone-dev header no/one.h\ntwo program no-program-of-this-name\nlibthree-dev header no/three.h tests\n"
    (tmp_path / "scripts" / "requirements" / "debian.txt").write_text(listed + absent)
    for defined, named in (("", "libone-dev two libthree-dev"), ("-DSKBUILD=2", "libone-dev two")):
        command = [cmake, "-S", str(tmp_path), "-B", str(tmp_path / f"build{defined}"), *filter(None, [defined])]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode != 0
        assert f"apt-get install {named} " in " ".join(done.stderr.split()) + " "
