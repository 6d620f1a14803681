"""Errors of components and calls."""

from __future__ import annotations

import os
import traceback

_PACKAGE = os.path.dirname(__file__)


class Fault(Exception):
    """Reason that a cycle or an operation failed, with a code in capitals for programs and a text for people.

    Raised by an operation, it is the reply to the caller; raised by `update` or a hook, it is a fault of the component.
    """

    def __init__(self, code: str, text: str = "") -> None:
        super().__init__(code, text)
        self.code = code
        self.text = text

    def __str__(self) -> str:
        return f"{self.code}: {self.text}" if self.text else self.code


class CallError(Fault):
    """End of a call without a result.

    `kind` is `timeout`, `unavailable`, `stopped`, `cancelled` or `fault`. For a fault, `code` is that of the provider,
    else the kind in capitals. An operation that does not catch it passes it on to its caller.
    """

    _TEXTS = {
        "timeout": "no answer before the deadline",
        "unavailable": "no server is available",
        "stopped": "the component that provides it does not run",
        "cancelled": "cancelled by the caller",
    }

    def __init__(self, kind: str, code: str = "", text: str = "") -> None:
        super().__init__(code or kind.upper(), text or self._TEXTS.get(kind, ""))
        self.kind = kind


class DeclarationError(Exception):
    """Mistake in the class of a component or message, with its place and the way out."""


class MismatchError(TypeError):
    """Value that does not fit its type, with its place."""


class UsageError(RuntimeError):
    """Use of a port, reference or property at a time or in a way that is not possible."""


def fault_of(error: BaseException) -> dict[str, str]:
    """Returns code and text of the fault that an exception is; for a program's mistake with the lines that led to it."""
    if isinstance(error, Fault):
        return {"code": error.code, "text": error.text}
    lines = traceback.format_exception_only(type(error), error)
    text = "".join(lines).strip()
    for frame in traceback.extract_tb(error.__traceback__):
        if not frame.filename.startswith(_PACKAGE) and not frame.filename.startswith("<"):
            place = f"{os.path.basename(frame.filename)}:{frame.lineno}, in {frame.name}"
            text += f"\n  {place}: {frame.line}" if frame.line else f"\n  {place}"
    return {"text": text}
