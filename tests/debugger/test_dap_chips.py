"""The Debug Adapter Protocol with several chips and several files of one name: what a reference denotes; and the
client's own way to count lines and to write paths."""

import base64
import re
import struct
import time
from pathlib import Path
from typing import Any

import pytest
from command_line import emulator
from dap import events, responses
from editor import Editor
from sums import write_program

ONE = (
    "start:  ldi 10,r0\n        nop\n        nop\n        nop\nend:    b end\n        .data\ntab:    .word 0AAAA0000h\n"
)
OTHER = "start:  ldi 20,r0\n        nop\nend:    b end\n        .data\ntab:    .word 0BBBB0000h\n"
ENDLESS = "start:  ldi 0,r0\nloop:   addi 1,r0\n        nop\n        b loop\n"


@pytest.fixture
def chips(tmp_path: Path) -> list[str]:
    """Two programs of one name."""
    paths = [tmp_path / name / "main.asm" for name in ("one", "other")]
    for path, text in zip(paths, (ONE, OTHER), strict=True):
        path.parent.mkdir()
        path.write_text(text)
    return [str(path) for path in paths]


def begun(editor: Editor, program: Any, **arguments: Any) -> None:
    editor.begin(program=program, stopOnEntry=True, stopAtEnd=True, **arguments)
    editor.configured()
    editor.stopped()


def body(editor: Editor, command: str, answer: type, **arguments: Any) -> Any:
    editor.ask(editor.send(command, **arguments), answer)
    return editor.bodies[command]


def breakpoints(editor: Editor, path: str, *lines: int, **fields: Any) -> Any:
    wanted = [{"line": line, **fields} for line in lines]
    answer = body(editor, "setBreakpoints", responses.SetBreakpointsResponse, source={"path": path}, breakpoints=wanted)
    return answer["breakpoints"]


def word_at(editor: Editor, reference: str) -> int:
    data = editor.ask(editor.client.read_memory(reference, 4), responses.ReadMemoryResponse).data
    return int(struct.unpack("<I", base64.b64decode(data))[0])


def first_instruction(editor: Editor, top: Any) -> Any:
    """The rows of `disassemble` for the instruction at which a frame stands."""
    return body(
        editor,
        "disassemble",
        responses.DisassembleResponse,
        memoryReference=top.instructionPointerReference,
        instructionCount=1,
    )["instructions"]


def test_a_reference_is_to_the_chip_of_the_frame_that_gave_it(chips: list[str]) -> None:
    with Editor() as editor:
        begun(editor, chips, link=["0.0:1.3"])
        tables = [(0xAAAA0000, "0Ah"), (0xBBBB0000, "14h")]
        references = []
        for thread, (word, loaded) in enumerate(tables, 1):
            top = editor.top(thread)
            rows = first_instruction(editor, top)
            assert re.search(rf"ldi +{int(loaded[:-1], 16)}, *r0", rows[0]["instruction"]), rows
            assert rows[0]["address"] == "0x00300000" and rows[0]["location"]["path"] == chips[thread - 1]
            answer = editor.ask(editor.client.evaluate("[tab]", top.id), responses.EvaluateResponse)
            references.append(answer.memoryReference)
            assert word_at(editor, answer.memoryReference) == word
        changed = base64.b64encode(struct.pack("<I", 42)).decode()
        editor.ask(editor.client.write_memory(references[1], changed), responses.WriteMemoryResponse)
        assert [word_at(editor, reference) for reference in references] == [0xAAAA0000, 42]
        frame = editor.top(2)
        set_there = body(
            editor,
            "setInstructionBreakpoints",
            responses.SetInstructionBreakpointsResponse,
            breakpoints=[{"instructionReference": frame.instructionPointerReference, "offset": 1}],
        )["breakpoints"]
        assert set_there[0]["instructionReference"] == "1:0x00300001"
        editor.client.continue_(1)
        assert editor.stopped().threadId == 2
        editor.client.continue_(1)
        assert editor.stopped().description == "the run is over"
        assert "1:0x00300000 of chip 1" in editor.refused("readMemory", {"memoryReference": "2:0x300000", "count": 4})


def test_a_breakpoint_is_in_the_named_file_only(chips: list[str]) -> None:
    with Editor() as editor:
        begun(editor, chips, link=["0.0:1.3"])
        (answer,) = breakpoints(editor, chips[0], 3)
        assert answer["verified"] and answer["source"]["path"] == chips[0] and answer["line"] == 3
        editor.client.continue_(1)
        event = editor.stopped()
        assert (event.threadId, event.hitBreakpointIds) == (1, [str(answer["id"])])
        editor.client.continue_(1)
        assert editor.stopped().description == "the run is over"


def test_a_line_with_several_addresses_has_one_number_and_one_count(tmp_path: Path) -> None:
    path = tmp_path / "many.asm"
    path.write_text(
        "m       .macro\n        addi 1,r0\n        .endm\nstart:  ldi 0,r0\nagain:  m\n        m\n        b again\n"
    )
    with Editor() as editor:
        begun(editor, str(path))
        (answer,) = breakpoints(editor, str(path), 2, hitCondition="4")
        editor.client.continue_(1)
        assert editor.stopped().hitBreakpointIds == [str(answer["id"])] and editor.value("r0").startswith("3 ")
        editor.client.continue_(1)
        assert editor.stopped().hitBreakpointIds == [str(answer["id"])] and editor.value("r0").startswith("4 ")
        (refused,) = breakpoints(editor, str(path), 2, hitCondition="== 3")
        assert not refused["verified"] and "a number, >= or > and a number" in refused["message"]


def test_a_uri_may_end_with_an_escape(tmp_path: Path) -> None:
    with Editor() as editor:
        editor.wait(responses.Initialized)
        editor.client.send_request("initialize", {"adapterID": "c40", "pathFormat": "uri"})
        editor.client.send_request("launch", {"program": str(write_program(tmp_path)), "stopAtEnd": True})
        editor.wait(events.InitializedEvent)
        (answer,) = breakpoints(editor, "file:///nowhere/a%20b%C3%BC", 1)
        assert "of /nowhere/a b\u00fc or after it" in answer["message"]
        (answer,) = breakpoints(editor, "file:///nowhere/a%2", 1)
        assert "of /nowhere/a%2 or after it" in answer["message"]


@pytest.mark.parametrize(("count", "hit"), [("3", 3), (">= 3", 3), ("> 3", 4), (">0", 1)])
def test_a_hit_condition_names_the_first_hit_that_stops(tmp_path: Path, count: str, hit: int) -> None:
    path = tmp_path / "round.asm"
    path.write_text("start:  ldi 0,r0\nagain:  addi 1,r0\n        b again\n")
    with Editor() as editor:
        begun(editor, str(path))
        breakpoints(editor, str(path), 2, hitCondition=count)
        editor.client.continue_(1)
        editor.stopped()
        assert editor.value("r0").startswith(f"{hit - 1} ")


@pytest.mark.parametrize("command", ["next", "stepIn", "stepBack", "reverseContinue"])
def test_a_step_of_a_running_machine_ends_the_run(tmp_path: Path, command: str) -> None:
    path = tmp_path / "endless.asm"
    path.write_text(ENDLESS)
    with Editor() as editor:
        begun(editor, str(path))
        editor.client.continue_(1)
        editor.value("cycle")  # between two slices
        editor.send(command, threadId=1)
        editor.stopped()
        before = editor.value("cycle")
        time.sleep(0.2)
        assert editor.value("cycle") == before


def test_the_client_may_count_from_zero_and_write_paths_as_uris(tmp_path: Path) -> None:
    program = write_program(tmp_path)
    named = tmp_path / "a b%c.asm"
    program.rename(named)
    uri = named.as_uri()
    line = next(n for n, text in enumerate(named.read_text().splitlines()) if "sti     r1" in text)
    with Editor() as editor:
        editor.wait(responses.Initialized)
        editor.client.send_request(
            "initialize",
            {"adapterID": "c40", "linesStartAt1": False, "columnsStartAt1": False, "pathFormat": "uri"},
        )
        editor.client.send_request("launch", {"program": str(named), "stopAtEnd": True})
        editor.wait(events.InitializedEvent)
        (answer,) = breakpoints(editor, uri, line)
        assert answer["verified"] and answer["line"] == line and answer["source"]["path"] == uri
        places = body(
            editor,
            "breakpointLocations",
            responses.BreakpointLocationsResponse,
            source={"path": uri},
            line=line - 1,
            endLine=line + 1,
        )["breakpoints"]
        assert [place["line"] for place in places] == [line - 1, line, line + 1]
        editor.configured()
        editor.stopped()
        top = editor.top()
        assert (top.line, top.column, top.source.path) == (line, 0, uri)
        rows = first_instruction(editor, top)
        assert rows[0]["line"] == line and rows[0]["location"]["path"] == uri
        assert "path or uri is expected" in editor.refused("initialize", {"adapterID": "c40", "pathFormat": "dos"})


def test_the_source_of_an_executable_is_found_beside_it(tmp_path: Path) -> None:
    write_program(tmp_path)
    assert emulator("asm", "sums.asm", "-o", "sums.out", folder=tmp_path).returncode == 0
    with Editor() as editor:
        begun(editor, str(tmp_path / "sums.out"))
        source = editor.top().source
        assert source.path == str(tmp_path / "sums.asm") and not source.sourceReference
        (answer,) = breakpoints(editor, source.path, 8)
        assert answer["verified"]


def test_the_new_value_of_a_register_is_its_integer_too(tmp_path: Path) -> None:
    with Editor() as editor:
        begun(editor, str(write_program(tmp_path)))
        scope = editor.ask(editor.client.scopes(editor.top().id), responses.ScopesResponse).scopes[0]
        editor.ask(editor.client.variables(scope.variablesReference), responses.VariablesResponse)
        editor.ask(editor.client.set_variable(scope.variablesReference, "R1", "3 + 4"), responses.SetVariableResponse)
        answer = editor.bodies["setVariable"]
        assert answer["value"].endswith(" (integer 7)") and answer["variablesReference"] > 0
        parts = editor.ask(editor.client.variables(answer["variablesReference"]), responses.VariablesResponse).variables
        assert {part.name: part.value for part in parts}["integer"] == "7"
        assert editor.registers(editor.top().id)["R1"].value == answer["value"]


def test_a_breakpoint_at_the_end_of_a_program_is_a_stop(tmp_path: Path) -> None:
    path = tmp_path / "ends.asm"
    path.write_text("start:  nop\ndone:   b done\n")
    with Editor() as editor:
        editor.begin(program=str(path))
        (answer,) = breakpoints(editor, str(path), 2)
        editor.configured()
        assert editor.stopped().hitBreakpointIds == [str(answer["id"])]
        editor.client.continue_(1)
        editor.wait(events.TerminatedEvent)
