"""A client of the Debug Adapter Protocol that is not ours (PyPI dap-python), at `emulator dap`. It checks every message
against the protocol."""

from __future__ import annotations

import select
import subprocess
import time
from collections.abc import Callable
from typing import Any, Self

import dap
from dap import events, responses
from dap.base import ErrorResponse
from locations import BUILD

PATIENCE_S = 60  # of a hang, not of a slow machine


class Editor:
    def __init__(self, *options: str) -> None:
        self.process = subprocess.Popen(
            [BUILD / "bin" / "emulator", "dap", *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self.client = dap.Client("c40")
        answered = self.client.handler.handle_response

        def with_nothing(response: Any) -> Any:
            """The library takes the answer's body for the whole answer where the protocol has no body."""
            self.bodies[response.command] = response.body
            if response.success and response.body is None:
                self.client._pending_requests.pop(response.request_seq)
                return response
            return answered(response)

        self.client.handler.handle_response = with_nothing
        happened = self.client.handler.handle_event

        def with_numbers(event: Any) -> Any:
            """The library takes the protocol's `number[]` for texts."""
            if event.body and "hitBreakpointIds" in event.body:
                assert all(isinstance(number, int) for number in event.body["hitBreakpointIds"])
                event.body["hitBreakpointIds"] = [str(number) for number in event.body["hitBreakpointIds"]]
            return happened(event)

        self.client.handler.handle_event = with_numbers
        self.heard: list[Any] = []
        self.outputs: list[str] = []
        self.bodies: dict[str, Any] = {}  # as they came

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.communicate()

    def _read(self) -> None:
        assert self.process.stdin is not None and self.process.stdout is not None
        if to_send := self.client.send():
            self.process.stdin.write(to_send)
            self.process.stdin.flush()
        ready, _, _ = select.select([self.process.stdout], [], [], 0.05)
        if ready:
            data = self.process.stdout.read1(1 << 20)  # type: ignore[attr-defined]
            if not data:
                raise EOFError("the adapter has ended")
            for message in self.client.receive(data):
                if isinstance(message, events.OutputEvent):
                    self.outputs.append(message.output)
                self.heard.append(message)

    def wait(self, wanted: type | Callable[[Any], bool]) -> Any:
        """The next message of that class; what came before it is gone."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            while self.heard:
                message = self.heard.pop(0)
                if isinstance(message, wanted) if isinstance(wanted, type) else wanted(message):
                    return message
                if (
                    isinstance(message, ErrorResponse)
                    and isinstance(wanted, type)
                    and wanted.__name__.endswith("Response")
                ):
                    raise AssertionError(message)
            self._read()
        raise AssertionError(f"no {wanted} came")

    def ask(self, request: int, answer: type) -> Any:
        assert request > 0
        return self.wait(answer)

    def send(self, command: str, **arguments: Any) -> int:
        return int(self.client.send_request(command, arguments))

    def refused(self, command: str, arguments: dict[str, Any] | None = None) -> str:
        self.client.send_request(command, arguments)
        return str(self.wait(ErrorResponse).message)

    def begin(self, **arguments: Any) -> None:
        self.wait(responses.Initialized)
        self.client.send_request("launch", arguments)
        self.wait(events.InitializedEvent)

    def configured(self) -> None:
        self.client.configuration_done()

    def stopped(self) -> Any:
        event = self.wait(events.StoppedEvent)
        assert event.allThreadsStopped
        return event

    def top(self, thread: int = 1) -> Any:
        return self.ask(self.client.stack_trace(thread), responses.StackTraceResponse).stackFrames[0]

    def value(self, expression: str, frame: int | None = None) -> str:
        return str(self.ask(self.client.evaluate(expression, frame), responses.EvaluateResponse).result)

    def registers(self, frame: int) -> dict[str, Any]:
        scope = self.ask(self.client.scopes(frame), responses.ScopesResponse).scopes[0]
        assert scope.name == "Registers"
        return {
            v.name: v
            for v in self.ask(self.client.variables(scope.variablesReference), responses.VariablesResponse).variables
        }
