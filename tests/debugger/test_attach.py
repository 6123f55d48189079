"""An editor at a run that is there: by `emulator --debug`, and from Python."""

import json
import socket
import subprocess
import threading
from pathlib import Path
from typing import Any

import cmrc
import pytest
from locations import AT_ONCE_OPTIONS, BUILD

RUN = [
    BUILD / "bin" / "emulator",
    "--quiet",
    "--dsps",
    "2",
    "--duration",
    "0.3",
    "--set",
    "report.reference=none",
    *AT_ONCE_OPTIONS,
]


class Client:
    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=60)
        self.bytes = b""
        self.number = 0

    def ask(self, command: str, **arguments: Any) -> dict[str, Any]:
        self.number += 1
        text = json.dumps({"seq": self.number, "type": "request", "command": command, "arguments": arguments}).encode()
        self.socket.sendall(b"Content-Length: %d\r\n\r\n%s" % (len(text), text))
        while True:
            message = self.next()
            if message["type"] == "response" and message["request_seq"] == self.number:
                return message

    def event(self, name: str) -> dict[str, Any]:
        while True:
            message = self.next()
            if message["type"] == "event" and message["event"] == name:
                return message.get("body", {})  # type: ignore[no-any-return]

    def next(self) -> dict[str, Any]:
        while b"\r\n\r\n" not in self.bytes:
            self.bytes += self.some()
        head, rest = self.bytes.split(b"\r\n\r\n", 1)
        length = int(head.split(b":")[1])
        while len(rest) < length:
            rest += self.some()
        self.bytes = rest[length:]
        return json.loads(rest[:length])  # type: ignore[no-any-return]

    def some(self) -> bytes:
        data = self.socket.recv(65536)
        assert data, "the run has closed the connection"
        return data


def attach(client: Client) -> None:
    assert client.ask("initialize")["success"]
    assert client.ask("attach")["success"]
    client.ask("configurationDone")
    assert client.event("stopped")["reason"] == "entry"


def attached(report: Path) -> "tuple[subprocess.Popen[str], Client]":
    """A run that waits for an editor, and an editor that has attached to it."""
    run = subprocess.Popen(
        [*RUN, "--report", report, "--debug", "0", "--debug-wait"], stderr=subprocess.PIPE, text=True
    )
    assert run.stderr is not None
    client = Client(int(run.stderr.readline().split("port ")[1].split()[0]))
    attach(client)
    return run, client


def hash_of(report: Path) -> str:
    return str(json.loads(report.read_text())["hash"])


@pytest.mark.parametrize("end", [False, True])
def test_an_editor_attaches_to_a_run_that_waits_and_lets_it_continue_or_ends_it(tmp_path: Path, end: bool) -> None:
    report, alone = tmp_path / "report.json", tmp_path / "alone.json"
    run, client = attached(report)
    assert client.ask("setFunctionBreakpoints", breakpoints=[{"name": "kernel_pid"}])["body"]["breakpoints"][0][
        "verified"
    ]
    for _ in range(3):
        client.ask("continue", threadId=1)
        assert client.event("stopped")["reason"] == "breakpoint"
    client.ask("stepBack", threadId=1)
    client.event("stopped")
    client.ask("disconnect", terminateDebuggee=end)
    run.wait(60)
    assert json.loads(report.read_text())["stop_reason"] == ("interrupted" if end else "completed")
    if end:
        return
    subprocess.run([*RUN, "--report", alone], check=True)
    assert hash_of(report) == hash_of(alone)


def test_an_editor_that_vanishes_lets_the_run_continue(tmp_path: Path) -> None:
    report, alone = tmp_path / "report.json", tmp_path / "alone.json"
    run, client = attached(report)
    client.ask("continue", threadId=1)
    client.socket.close()
    run.wait(60)
    subprocess.run([*RUN, "--report", alone], check=True)
    assert hash_of(report) == hash_of(alone)


def test_python_lets_an_editor_attach() -> None:
    run = cmrc.Simulation(settings={"run.duration_s": 0.1, "machine.dsps": 2, "report.reference": "none"})
    debugger = run.debug()
    ports: list[int] = []
    there = threading.Event()
    outcome: list[bool] = []

    def on_port(port: int) -> None:
        ports.append(port)
        there.set()

    def serve() -> None:
        outcome.append(debugger.listen(told=on_port))

    thread = threading.Thread(target=serve)
    thread.start()
    there.wait(60)
    client = Client(ports[0])
    attach(client)
    assert len(client.ask("threads")["body"]["threads"]) == 2
    client.ask("disconnect", terminateDebuggee=False)
    thread.join(60)
    assert outcome == [True]
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(OSError, match="another one"):
            debugger.listen(taken.getsockname()[1])


def test_what_a_run_collects_cannot_be_taken_back() -> None:
    """A page, kept events and a profile are of the whole run, each instant once: no way leads back."""
    settings = {"run.duration_s": 0.03, "machine.dsps": 2, "report.reference": "none"}
    snapshot = cmrc.Simulation(settings=settings).snapshot()
    recorded = cmrc.Simulation(settings=settings)
    recorded.record()
    for run, how in (
        (recorded, r"after record\(\)"),
        (cmrc.Simulation(settings=settings, keep_events=True), "with keep_events=True"),
        (cmrc.Simulation(settings=settings, profile=True), "with profile=True"),
    ):
        with pytest.raises(
            RuntimeError, match=f"debug: not {how}: what is collected beside the run cannot be taken back"
        ):
            run.debug()
        with pytest.raises(RuntimeError, match=f"restore: not {how}: "):
            run.restore(snapshot)
        assert run.run().hash
    run = cmrc.Simulation(settings=settings)
    debugger = run.debug()
    with pytest.raises(RuntimeError, match="record: .*the debugger is to be closed first"):
        run.record()
    debugger.on("claim", task="pid")
    debugger.go()
    debugger.close()
    run.restore(snapshot)
    run.record()
    assert run.run().hash == recorded.result().hash


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--debug-wait"], "needs --debug"),
        (["--debug", "70000"], "--debug"),
        (["--debug", "0", "--profile", "/tmp/p"], "--profile has collected cannot be taken back"),
        (["--debug", "0", "--page", "/tmp/p.html"], "--page has collected cannot be taken back"),
        (["--debug", "0", "--perfetto", "/tmp/p"], "--perfetto has collected cannot be taken back"),
        (["--debug", "0", "--trace", "/tmp/p"], "--trace has collected cannot be taken back"),
    ],
)
def test_what_makes_no_sense_is_refused(options: list[str], message: str) -> None:
    done = subprocess.run([*RUN, *options], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2 and message in done.stderr
