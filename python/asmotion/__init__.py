"""Components of asmotion in Python, and a client of a running system.

A component is a class with ports, services, references and properties as attributes; `run` makes it a program that
asmotion starts, `Bench` tests it in virtual time, and `connect` observes and calls a running system.
"""

from asmotion.bench import Bench, MadeCall, Outcome, Request
from asmotion.client import Client, connect
from asmotion.component import (
    Call,
    Component,
    Cycle,
    In,
    Input,
    Interface,
    Operation,
    Out,
    Output,
    Pending,
    Property,
    Reference,
    Service,
)
from asmotion.errors import CallError, DeclarationError, Fault, MismatchError, UsageError
from asmotion.numbers import Numbers, NumberView
from asmotion.program import run
from asmotion.types import Length, Record, f32, f64, i8, i16, i32, i64, message, u8, u16, u32, u64

__all__ = [
    "Bench",
    "Call",
    "CallError",
    "Client",
    "Component",
    "Cycle",
    "DeclarationError",
    "Fault",
    "In",
    "Input",
    "Interface",
    "Length",
    "MadeCall",
    "MismatchError",
    "NumberView",
    "Numbers",
    "Operation",
    "Out",
    "Outcome",
    "Output",
    "Pending",
    "Property",
    "Record",
    "Reference",
    "Request",
    "Service",
    "UsageError",
    "connect",
    "f32",
    "f64",
    "i16",
    "i32",
    "i64",
    "i8",
    "message",
    "run",
    "u16",
    "u32",
    "u64",
    "u8",
]
