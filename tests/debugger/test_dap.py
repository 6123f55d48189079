"""The Debug Adapter Protocol with a client that is not ours: a program, a network, the dock; and input that is no
message."""

import base64
import json
import re
import socket
import struct
import subprocess
from pathlib import Path
from typing import Any

import pytest
from dap import events, responses
from editor import Editor
from locations import AT_ONCE_OPTIONS, BUILD
from sums import SUMS, write_program


@pytest.fixture
def program(tmp_path: Path) -> Path:
    return write_program(tmp_path)


def line_of(program: Path, text: str) -> int:
    return next(n for n, line in enumerate(program.read_text().splitlines(), 1) if text in line)


def break_at(editor: Editor, program: Path, line: int, **fields: Any) -> Any:
    return editor.ask(
        editor.send("setBreakpoints", source={"path": str(program)}, breakpoints=[{"line": line, **fields}]),
        responses.SetBreakpointsResponse,
    ).breakpoints[0]


def test_a_program_stops_at_a_source_line_and_shows_what_is_there(program: Path) -> None:
    with Editor() as editor:
        editor.begin(program=str(program))
        line = line_of(program, "sti     r1")
        set_there = break_at(editor, program, line)
        assert set_there.verified and set_there.line == line
        editor.configured()
        for total in SUMS:
            event = editor.stopped()
            assert event.reason == "breakpoint" and event.hitBreakpointIds == [str(set_there.id)]
            frames = editor.ask(editor.client.stack_trace(1), responses.StackTraceResponse).stackFrames
            assert [frame.line for frame in frames] == [line, line_of(program, "call    add")]
            assert frames[0].source.path == str(program)
            registers = editor.registers(frames[0].id)
            assert registers["AR7"].value.startswith("3143680 (002FF800h)")
            assert editor.value("r1") == f"{total} ({total:08X}h)" and int(editor.value("[total]").split()[0]) < total
            editor.client.continue_(1)
        editor.wait(events.TerminatedEvent)
        assert any("branches to itself" in text for text in editor.outputs)


def test_conditions_hit_counts_and_log_points(program: Path) -> None:
    with Editor() as editor:
        editor.begin(program=str(program), stopAtEnd=True)
        line = line_of(program, "sti     r1")
        break_at(editor, program, line, condition="r1 > 10", hitCondition="2")
        editor.configured()
        editor.stopped()
        assert editor.value("r1").startswith("14 ")
        break_at(editor, program, line, logMessage="sum {r1} of {r0}")
        editor.client.continue_(1)
        assert editor.stopped().description == "the run is over"
        assert [text for text in editor.outputs if text.startswith("sum")] == ["sum 15 (0000000Fh) of 1 (00000001h)\n"]
        assert break_at(editor, program, line, condition="r1 >").verified is False
        assert "hitCondition" in break_at(editor, program, line, hitCondition="often").message


def test_a_condition_without_a_value_is_a_stop_that_says_so(program: Path) -> None:
    with Editor() as editor:
        editor.begin(program=str(program), stopAtEnd=True)
        line = line_of(program, "sti     r1")
        number = break_at(editor, program, line, condition="1 / (r1 - r1)").id
        editor.configured()
        event = editor.stopped()
        assert event.reason == "breakpoint" and event.text.startswith("paused at")
        said = f'stop condition {number}, "if 1 / (r1 - r1)": a division by zero\n'
        assert said in editor.outputs
        forward, at = event.text, editor.value("time_s")
        break_at(editor, program, line)
        editor.client.continue_(1)
        assert editor.stopped().reason == "breakpoint"
        break_at(editor, program, line, condition="1 / (r1 - r1)")
        editor.client.reverse_continue(1)
        event = editor.stopped()
        assert event.text == forward and editor.value("time_s") == at


def test_steps_forward_and_back_come_to_the_same_lines(program: Path) -> None:
    with Editor() as editor:
        editor.begin(program=str(program), stopOnEntry=True)
        editor.configured()
        assert editor.stopped().reason == "entry"
        lines = [editor.top().line]
        for _ in range(10):
            editor.client.step_in(1)
            assert editor.stopped().reason == "step"
            lines.append(editor.top().line)
        assert line_of(program, "add:") in lines
        for line in reversed(lines[:-1]):
            editor.client.step_back(1, granularity="instruction")
            editor.stopped()
            assert editor.top().line == line
        for _ in range(5):
            editor.client.next(1)
            editor.stopped()
        assert editor.top().line == line_of(program, "loop:")
        editor.client.next(1)
        editor.stopped()
        assert editor.top().line == line_of(program, "subi") and editor.value("[total]").startswith("5 ")
        editor.client.step_in(1)
        editor.stopped()
        editor.client.step_in(1)
        editor.stopped()
        editor.client.step_in(1)
        editor.stopped()
        assert editor.top().line == line_of(program, "add:")
        editor.client.step_out(1)
        editor.stopped()
        assert editor.top().line == line_of(program, "subi") and editor.value("[total]").startswith("9 ")


def test_data_function_and_instruction_breakpoints_and_back_again(program: Path) -> None:
    with Editor() as editor:
        editor.begin(program=str(program), stopOnEntry=True, stopAtEnd=True)
        editor.configured()
        editor.stopped()
        info = editor.ask(editor.client.data_breakpoint_info("total"), responses.DataBreakpointInfoResponse)
        assert info.dataId and set(info.accessTypes) == {"read", "write", "readWrite"}
        editor.ask(
            editor.send("setDataBreakpoints", breakpoints=[{"dataId": info.dataId, "accessType": "write"}]),
            responses.SetDataBreakpointsResponse,
        )
        strange = editor.ask(
            editor.send(
                "setDataBreakpoints",
                breakpoints=[
                    {"dataId": info.dataId, "accessType": "execute"},
                    {"dataId": "0:R0", "accessType": "read"},
                    {"dataId": info.dataId},
                ],
            ),
            responses.SetDataBreakpointsResponse,
        )
        assert [one.verified for one in strange.breakpoints] == [False, False, True]
        assert strange.breakpoints[0].message == 'accessType "execute": read, write or readWrite is expected'
        for total in SUMS:
            editor.client.continue_(1)
            assert editor.stopped().reason == "data breakpoint"
            assert editor.value("[total]").startswith(f"{total} ")
        for total in reversed(SUMS[:-1]):
            editor.client.reverse_continue(1)
            editor.stopped()
            assert editor.value("[total]").startswith(f"{total} ")
        editor.ask(editor.send("setDataBreakpoints", breakpoints=[]), responses.SetDataBreakpointsResponse)
        named = (
            editor.ask(
                editor.send("setFunctionBreakpoints", breakpoints=[{"name": "add"}, {"name": "nothing"}]),
                responses.SetFunctionBreakpointsResponse,
            )
            and editor.bodies["setFunctionBreakpoints"]["breakpoints"]
        )
        assert [one["verified"] for one in named] == [True, False]
        editor.client.continue_(1)
        assert editor.stopped().hitBreakpointIds == [str(named[0]["id"])]
        editor.ask(editor.send("setFunctionBreakpoints", breakpoints=[]), responses.SetFunctionBreakpointsResponse)
        reference = editor.top().instructionPointerReference
        editor.ask(
            editor.send("setInstructionBreakpoints", breakpoints=[{"instructionReference": reference, "offset": 2}]),
            responses.SetInstructionBreakpointsResponse,
        )
        editor.client.continue_(1)
        editor.stopped()
        assert editor.top().line == line_of(program, "sti     r1")


def test_memory_instructions_and_changes_by_hand(program: Path) -> None:
    with Editor() as editor:
        editor.begin(program=str(program), stopOnEntry=True, stopAtEnd=True)
        editor.configured()
        editor.stopped()
        start = editor.top().instructionPointerReference
        editor.ask(
            editor.send("disassemble", memoryReference=start, instructionOffset=-1, instructionCount=4),
            responses.DisassembleResponse,
        )
        rows = editor.bodies["disassemble"]["instructions"]
        first = int(start, 16)
        assert [int(row["address"], 16) for row in rows] == [first - 1, first, first + 1, first + 2]
        assert (
            "ldpk" in rows[1]["instruction"]
            and rows[1]["symbol"] == "start"
            and rows[1]["line"] == line_of(program, "start:")
        )
        words = struct.unpack(
            "<2I", base64.b64decode(editor.ask(editor.client.read_memory(start, 8), responses.ReadMemoryResponse).data)
        )
        assert f"{words[0]:08X}" == rows[1]["instructionBytes"]
        part = editor.ask(editor.client.read_memory(start, 3, offset=2), responses.ReadMemoryResponse)
        assert struct.unpack("<2I", base64.b64decode(part.data)) == words and int(part.address, 16) == first
        total = editor.ask(editor.client.evaluate("total"), responses.EvaluateResponse).memoryReference
        editor.ask(
            editor.client.write_memory(total, base64.b64encode(struct.pack("<I", 100)).decode()),
            responses.WriteMemoryResponse,
        )
        assert any("new branch" in text for text in editor.outputs)
        scope = editor.ask(editor.client.scopes(editor.top().id), responses.ScopesResponse).scopes[0]
        editor.ask(editor.client.variables(scope.variablesReference), responses.VariablesResponse)
        answer = editor.ask(
            editor.client.set_variable(scope.variablesReference, "R3", "f(total) * 0 + 1.5"),
            responses.SetVariableResponse,
        )
        assert re.fullmatch(r"1\.5 \(integer \d+\)", answer.value)
        editor.client.continue_(1)
        editor.stopped()
        assert editor.value("[total]").startswith(f"{100 + SUMS[-1]} ") and editor.value("f(r3)") == "1.5"


@pytest.mark.parametrize(
    ("offset", "count", "first", "words"),
    [(-4, 4, -1, 1), (-5, 4, -2, 2), (-8, 1, -2, 1), (-3, 2, -1, 1), (-3, 4, -1, 2), (5, 4, 1, 2), (7, 1, 1, 1)],
)
def test_memory_is_read_in_whole_words_on_both_sides_of_its_place(
    program: Path, offset: int, count: int, first: int, words: int
) -> None:
    """Every word that has one of the wanted bytes."""
    with Editor() as editor:
        editor.begin(program=str(program), stopOnEntry=True, stopAtEnd=True)
        editor.configured()
        editor.stopped()
        place = "0x00300008"
        near = editor.ask(editor.client.read_memory("0x00300004", 40), responses.ReadMemoryResponse)
        found = editor.ask(editor.client.read_memory(place, count, offset=offset), responses.ReadMemoryResponse)
        assert int(found.address, 16) == int(place, 16) + first
        begin = 4 * (4 + first)
        assert base64.b64decode(found.data) == base64.b64decode(near.data)[begin : begin + 4 * words]


def test_bytes_behind_the_end_of_memory_are_counted(program: Path) -> None:
    with Editor() as editor:
        editor.begin(program=str(program), stopOnEntry=True, stopAtEnd=True)
        editor.configured()
        editor.stopped()
        found = editor.ask(editor.client.read_memory("0x003FFFFF", 12), responses.ReadMemoryResponse)
        assert len(base64.b64decode(found.data)) == 4 and found.unreadableBytes == 8


def test_the_dock_has_a_thread_for_each_dsp_and_source_that_is_built_in() -> None:
    settings = [word for word in AT_ONCE_OPTIONS if word != "--set"]
    with Editor() as editor:
        editor.begin(dsps=3, duration=0.05, set=[*settings, "report.reference=none"])
        editor.ask(
            editor.send("setFunctionBreakpoints", breakpoints=[{"name": "kernel_pid"}]),
            responses.SetFunctionBreakpointsResponse,
        )
        editor.configured()
        event = editor.stopped()
        threads = editor.ask(editor.client.threads(), responses.ThreadsResponse).threads
        assert [thread.id for thread in threads] == [1, 2, 3] and "pid" in threads[event.threadId - 1].name
        frame = editor.top(event.threadId)
        assert frame.source.sourceReference and frame.source.name == "pid.asm"
        text = editor.ask(editor.client.source(frame.source.sourceReference), responses.SourceResponse).content
        assert text.splitlines()[frame.line - 1].split() == ["ldi", "0,", "r0"]
        scopes = editor.ask(editor.client.scopes(frame.id), responses.ScopesResponse).scopes
        assert [scope.name for scope in scopes] == ["Registers", "Peripherals", "list", "dsps", "plant"]
        rows = editor.ask(editor.client.variables(scopes[2].variablesReference), responses.VariablesResponse).variables
        assert any("pid" in row.value for row in rows)
        editor.client.step_in(event.threadId)
        assert editor.stopped().threadId == event.threadId
        editor.ask(editor.send("setFunctionBreakpoints", breakpoints=[]), responses.SetFunctionBreakpointsResponse)
        editor.client.continue_(1)
        editor.wait(events.TerminatedEvent)


def test_a_run_is_paused_and_continues_and_ends_when_the_client_says_so(tmp_path: Path) -> None:
    path = tmp_path / "loop.asm"
    path.write_text("        .text\nstart:  addi 1,r0\n        b start\n")
    with Editor() as editor:
        editor.begin(program=str(path))
        editor.configured()
        for _ in range(2):
            editor.client.pause(1)
            event = editor.stopped()
            assert event.reason == "pause"
            editor.client.continue_(1)
        editor.client.evaluate("r0")  # while it runs: between two slices
        editor.wait(responses.EvaluateResponse)
        editor.client.disconnect()
        editor.wait(lambda message: getattr(message, "command", "") == "disconnect")
        assert editor.process.wait(20) == 0


@pytest.mark.parametrize(
    ("command", "arguments", "message"),
    [
        ("nonsense", {}, "is unknown"),
        ("stackTrace", {"threadId": 77}, "threads 1 to 1"),
        ("stackTrace", {}, "threadId is missing"),
        ("stackTrace", {"threadId": "one"}, "threadId is missing"),
        ("variables", {"variablesReference": 999}, "variablesReference 999"),
        ("scopes", {"frameId": 10**11}, "frameId"),
        ("scopes", {"frameId": -5}, "frameId"),
        ("evaluate", {"expression": "r0 +"}, "column"),
        ("evaluate", {"expression": "(" * 10000}, "nested too deep"),
        ("readMemory", {"memoryReference": "nowhere", "count": 4}, "an address"),
        ("readMemory", {"memoryReference": "0x300000", "count": 10**9}, "count"),
        ("readMemory", {"memoryReference": "0x300000", "count": 10**18}, "out of range"),
        ("writeMemory", {"memoryReference": "0x300000", "data": "!!"}, "base64"),
        ("writeMemory", {"memoryReference": "0x300000", "data": "AAA="}, "whole words"),
        ("disassemble", {"memoryReference": "0x300000", "instructionCount": 10**7}, "instructionCount"),
        ("setBreakpoints", {}, "arguments that do not fit"),
        ("setBreakpoints", {"source": {"path": "x"}, "breakpoints": [{"line": "three"}]}, "arguments that do not fit"),
        ("setVariable", {"variablesReference": 1, "name": "R0", "value": "1"}, "only registers"),
        ("source", {"sourceReference": 5}, "sourceReference 5"),
        ("launch", {"program": "again.asm"}, "already a debuggee"),
        ("attach", {}, "nothing runs here"),
        ("exceptionInfo", {"threadId": 0}, "threads 1 to 1"),
    ],
)  # fmt: skip
def test_requests_that_make_no_sense_are_refused_with_a_reason(
    program: Path, command: str, arguments: dict[str, Any], message: str
) -> None:
    with Editor() as editor:
        editor.begin(program=str(program), stopOnEntry=True)
        editor.configured()
        editor.stopped()
        assert message in editor.refused(command, arguments)
        assert editor.value("1 + 1").startswith("2 ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [({"program": "/nowhere.asm"}, "nowhere.asm"), ({"program": 5}, "launch: program"), ({"dsps": "four"}, "launch: dsps"), ({"dsps": 99}, "dsps"), ({"network": "/nowhere.toml"}, "nowhere.toml"), ({"program": "x.asm", "dsps": 2}, "are for the dock")],
)  # fmt: skip
def test_what_cannot_be_launched_is_said_and_something_else_may_be(
    program: Path, arguments: dict[str, Any], message: str
) -> None:
    with Editor() as editor:
        editor.wait(responses.Initialized)
        assert message in editor.refused("launch", arguments)
        assert "there is no debuggee yet" in editor.refused("continue", {"threadId": 1})
        editor.client.send_request("launch", {"program": str(program)})
        editor.wait(events.InitializedEvent)


def framed(text: str) -> bytes:
    return f"Content-Length: {len(text.encode())}\r\n\r\n{text}".encode()


@pytest.mark.parametrize(
    ("sent", "status", "said"),
    [
        (b"", 0, b""),
        (b"Content-Length: 20\r\n\r\n{", 0, b""),
        (b"Content-Length: many\r\n\r\n", 2, b"is not a number"),
        (b"Content-Length: 99999999999\r\n\r\n", 2, b"up to"),
        (b"hello\r\n\r\n", 2, b"is not a header"),
        (b"x" * 5000, 2, b"does not end"),
        (framed("[1, 2"), 0, b""),
        (framed("[" * 100000), 0, b""),
        (framed('{"type": "request", "command": 7, "seq": "x"}'), 0, b""),
        (framed(json.dumps({"type": "response", "command": "x", "seq": 1})), 0, b""),
    ],
)
def test_what_is_no_message_ends_cleanly(sent: bytes, status: int, said: bytes) -> None:
    done = subprocess.run([BUILD / "bin" / "emulator", "dap"], input=sent, capture_output=True, timeout=60, check=False)
    assert done.returncode == status
    assert said in done.stderr


def test_clients_come_to_a_port_one_after_the_other_and_a_port_that_is_taken_is_refused(program: Path) -> None:
    server = subprocess.Popen([BUILD / "bin" / "emulator", "dap", "--listen", "0"], stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        port = int(server.stdout.readline().split("port ")[1].split()[0])
        for _ in range(2):
            with socket.create_connection(("127.0.0.1", port), timeout=60) as client:
                client.sendall(
                    framed(json.dumps({"seq": 1, "type": "request", "command": "initialize", "arguments": {}}))
                )
                assert b"supportsStepBack" in client.recv(65536)
        taken = subprocess.run(
            [BUILD / "bin" / "emulator", "dap", "--listen", str(port)],
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        assert taken.returncode == 2 and f"port {port}" in taken.stderr
    finally:
        server.kill()
        server.wait()
