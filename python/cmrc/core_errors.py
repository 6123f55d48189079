"""Our words where the extension module refuses arguments in its own."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

_REFUSED = re.compile(r"\w*\(\): incompatible (?:function|constructor) arguments")
_SIGNATURE = re.compile(r"^    \d+\. [\w.]*\((.*)\)(?: -> .*)?$", re.MULTILINE)
_WORDS = (
    (r"typing\.SupportsFloat \| typing\.SupportsIndex", "a number"),
    (r"typing\.SupportsInt \| typing\.SupportsIndex", "a whole number"),
    (r'typing\.Annotated\[collections\.abc\.Sequence\[([^\]]*)\], "FixedSize\((\d+)\)"\]', r"a list of \2, each \1"),
    (r"collections\.abc\.Sequence\[([^\]]*)\]", r"a list, each \1"),
    (r"cmrc\._core\.\w+\.", ""),
    (r"typing\.|collections\.abc\.", ""),
)
_LONGEST = 60


def in_our_words(name: str, function: Function) -> Function:
    """The same function; a TypeError for arguments that it does not take has ``name``, what was given, and what is
    expected."""

    @functools.wraps(function)
    def checked(*given: Any, **keywords: Any) -> Any:
        try:
            return function(*given, **keywords)
        except TypeError as error:
            raise reworded(name, error, given, keywords) from None

    del checked.__dict__["__wrapped__"]  # inspect cannot read the signature there
    return checked  # type: ignore[return-value]


def reworded(name: str, error: TypeError, given: tuple[Any, ...], keywords: dict[str, Any]) -> TypeError:
    """The error in our words, if the extension module has refused arguments; else the same error."""
    message = str(error)
    if not _REFUSED.match(message) and "No constructor defined" not in message:
        return error
    return TypeError(_message(name, message, given, keywords))


def _message(name: str, message: str, given: tuple[Any, ...], keywords: dict[str, Any]) -> str:
    expected = [_plain(found) for found in _SIGNATURE.findall(message)]
    if not expected:
        return f"{name}: cannot be called; only the package makes such an object; one of the package is expected"
    values = given[1:] if "self: " in message or "constructor" in message else given
    shown = ", ".join([_shown(value) for value in values] + [f"{key}={_shown(one)}" for key, one in keywords.items()])
    right = " or ".join(expected)
    return f"{name}: {shown or 'nothing'} cannot be used; {right} is expected"


def _plain(signature: str) -> str:
    text = re.sub(r"^self: [^,]*(?:, |$)", "", signature)
    for pattern, words in _WORDS:
        text = re.sub(pattern, words, text)
    text = re.sub(r"^arg0: ", "", text) if text.count(": ") == 1 else f"({text})"
    return text if text != "()" else "no argument"


def _shown(value: object) -> str:
    text = repr(value)
    if "object at 0x" in text:
        return type(value).__name__
    return f"{text if len(text) <= _LONGEST else text[: _LONGEST - 3] + '...'} ({type(value).__name__})"


def class_in_our_words(cls: type, name: str) -> None:
    """The constructor, the members that can be set, and the methods of a class of the extension module."""
    for member, value in list(vars(cls).items()):
        if isinstance(value, property) and value.fset is not None:
            setter = in_our_words(f"{name}.{member}", value.fset)
            setattr(cls, member, property(value.fget, setter, value.fdel, value.__doc__))
        elif member == "__init__":
            setattr(cls, member, in_our_words(name, value))
        elif isinstance(value, staticmethod):
            setattr(cls, member, staticmethod(in_our_words(f"{name}.{member}", value.__func__)))
        elif type(value).__name__ == "instancemethod" and not member.startswith("_"):
            setattr(cls, member, in_our_words(f"{name}.{member}", value))
