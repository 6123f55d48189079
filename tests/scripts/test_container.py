"""The container file, the devcontainer and the hooks of pre-commit name what is in the tree. Nothing is built here."""

import json
import re

import pytest
import yaml
from locations import ROOT

CONTAINER = (ROOT / "Containerfile").read_text().splitlines()


def test_the_container_is_built_by_the_scripts_of_the_tree() -> None:
    steps = [line.split(maxsplit=1) for line in CONTAINER if line and not line.startswith("#")]
    assert {step for step, _ in steps} <= {"FROM", "RUN", "WORKDIR", "COPY", "CMD"}
    assert [rest for step, rest in steps if step == "FROM"] == ["debian:12 AS packages", "packages AS built"]
    for source in [word for step, rest in steps if step == "COPY" for word in rest.split()[:-1]]:
        assert (ROOT / source).exists(), source
    runs = [rest for step, rest in steps if step == "RUN"]
    assert runs[1:] == ["scripts/setup packages", "scripts/setup", "make build"]
    assert re.search(r"(?m)^\[\[ .*== packages \]\] && exit$", (ROOT / "scripts" / "setup").read_text())


def test_the_devcontainer_starts_from_a_stage_of_the_container() -> None:
    folder = ROOT / ".devcontainer"
    described = json.loads((folder / "devcontainer.json").read_text())
    assert (folder / described["build"]["dockerfile"]).resolve() == ROOT / "Containerfile"
    assert f"FROM debian:12 AS {described['build']['target']}" in CONTAINER
    command, target = described["postCreateCommand"].split()
    assert command == "make" and f"\n{target}:" in (ROOT / "Makefile").read_text()


HOOKS = [
    hook
    for repository in yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"]
    for hook in repository["hooks"]
]


def test_hooks_are_local() -> None:
    assert {each["repo"] for each in yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"]} == {
        "local"
    }


@pytest.mark.parametrize("hook", HOOKS, ids=lambda hook: hook["id"])
def test_a_hook_runs_a_tool_of_the_environment_on_files_that_exist(hook: dict[str, str]) -> None:
    tool, *arguments = hook["entry"].split()
    assert tool.startswith(".venv/bin/") and hook["language"] == "system"
    required = (ROOT / "scripts" / "requirements" / "dev.in").read_text()
    assert tool.removeprefix(".venv/bin/") in (*re.findall(r"(?m)^[\w-]+", required), "python")
    assert all((ROOT / word).exists() for word in arguments if "/" in word)
