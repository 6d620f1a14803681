"""The state of a component between two cycles, as bytes that are equal for equal states."""

from __future__ import annotations

import dataclasses
import enum
import random
from collections import deque
from typing import Any

from asmotion import cbor
from asmotion.component import Call, Component, Engine, Pending
from asmotion.numbers import NumberView
from asmotion.types import Record

_VERSION = 1


class CannotFreeze(Exception):
    """A state that has no form as data, with the attribute that prevents it."""


def freeze(component: Component, engine: Engine) -> bytes:
    """Returns the attributes of a component, its inputs, and its calls and requests under way.

    Raises:
        CannotFreeze: an attribute has no form as data, or a coroutine is under way.
    """
    if engine.tasks:
        raise CannotFreeze("a coroutine is under way")
    attributes = {}
    for name, value in vars(component).items():
        if name != "_engine":
            attributes[name] = _pack(value, f"`{type(component).__name__}.{name}`")
    inputs = {
        name: [_data(port, port.read()), port.written_at, port.is_stale, port.lost] for name, port in engine.inputs.items()
    }
    calls = [[call.id, call._operation.reference, call._operation.name] for call in engine.calls.values()]
    pending = [[item.id, item.caller, item.deadline, _service_of(engine, item)] for item in engine.pending.values()]
    state = {
        "version": _VERSION,
        "attributes": attributes,
        "inputs": inputs,
        "calls": calls,
        "call_count": engine.call_count,
        "pending": pending,
    }
    return cbor.dumps(state)


def _data(port: Any, sample: Any) -> Any:
    return None if sample is None else port.form.dump(sample)


def _service_of(engine: Engine, item: Pending[Any]) -> list[str]:
    assert item._served is not None
    return [item._served.name, item._served.method.__name__]


def _pack(value: Any, place: str) -> Any:
    """Returns a value as data: plain values as they are, others as a map of kind and content."""
    if value is None or isinstance(value, (bool, int, float, str)) and not isinstance(value, enum.Enum):
        return value
    if isinstance(value, bytes):
        return {"bytes": value}
    if isinstance(value, Call):
        if value.is_done:
            raise CannotFreeze(f"{place} is a call that has ended; keep its result instead")
        return {"call": value.id}
    if isinstance(value, Pending):
        return {"pending": value.id}
    if isinstance(value, random.Random):
        return {"random": _pack(value.getstate(), place)}
    if type(value) is deque:
        return {"deque": [value.maxlen, [_pack(element, place) for element in value]]}
    for kind, cls in (("list", list), ("tuple", tuple)):
        if type(value) is cls:
            return {kind: [_pack(element, place) for element in value]}
    if type(value) in (set, frozenset):
        elements = [_pack(element, place) for element in value]
        return {type(value).__name__: sorted(elements, key=cbor.dumps)}
    if type(value) in (dict, Record):
        pairs = [[_pack(key, place), _pack(element, place)] for key, element in value.items()]
        return {type(value).__name__: pairs}
    if isinstance(value, NumberView):
        return {"numbers": value}
    if isinstance(value, enum.Enum):
        return {"enum": [*_path(type(value), place), value.name]}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {field.name: _pack(getattr(value, field.name), place) for field in dataclasses.fields(value)}
        return {"dataclass": [*_path(type(value), place), fields]}
    if type(value).__module__ == "numpy" and type(value).__name__ == "ndarray":
        return {"array": [value.ravel(), list(value.shape)]}
    raise CannotFreeze(f"{place} has the type {type(value).__name__}, which has no form as data")


def _path(cls: type[Any], place: str) -> list[str]:
    if "<locals>" in cls.__qualname__:
        raise CannotFreeze(f"{place} has the type {cls.__qualname__}, which is declared inside of a function")
    return [cls.__module__, cls.__qualname__]


def thaw(component: Component, engine: Engine, state: bytes) -> None:
    """Restores a state.

    Raises:
        ValueError: the bytes are not a state of this component.
    """
    data = cbor.loads(state)
    if not isinstance(data, dict) or data.get("version") != _VERSION:
        raise ValueError("these bytes are not the state of a component in Python")
    engine.calls.clear()
    engine.pending.clear()
    engine.call_count = data["call_count"]
    for id, reference, name in data["calls"]:
        engine.calls[id] = Call(engine, id, engine.references[reference]._operations[name])
    for id, caller, deadline, (name, method) in data["pending"]:
        engine.pending[id] = _pending(engine, component, id, caller, deadline, name, method)
    for name, (sample, written_at, is_stale, lost) in data["inputs"].items():
        port = engine.inputs[name]
        port._newest = None if sample is None else port.form.load(sample)
        port._all, port.written_at, port.is_stale, port.lost = [], written_at, is_stale, lost
    attributes = {name: _unpack(value, engine) for name, value in data["attributes"].items()}
    for name in set(vars(component)) - {"_engine"}:
        delattr(component, name)
    for name, value in attributes.items():
        setattr(component, name, value)


def _pending(
    engine: Engine, component: Component, id: int, caller: str, deadline: int | None, name: str, method: str
) -> Pending[Any]:
    item: Pending[Any] = Pending()
    item._engine, item.id, item.caller, item.deadline = engine, id, caller, deadline
    for service in type(component).declaration().services.values():
        for served in service.served:
            if served.name == name and served.method.__name__ == method:
                item._served = served
    return item


def _unpack(data: Any, engine: Engine) -> Any:
    if not isinstance(data, dict):
        return data
    ((kind, content),) = data.items()
    if kind == "call":
        return engine.calls[content]
    if kind == "pending":
        return engine.pending[content]
    if kind == "random":
        generator = random.Random()
        generator.setstate(_unpack(content, engine))
        return generator
    if kind == "deque":
        return deque((_unpack(element, engine) for element in content[1]), content[0])
    if kind in ("list", "tuple", "set", "frozenset"):
        make: Any = {"list": list, "tuple": tuple, "set": set, "frozenset": frozenset}[kind]
        return make(_unpack(element, engine) for element in content)
    if kind in ("dict", "Record"):
        pairs = {_unpack(key, engine): _unpack(element, engine) for key, element in content}
        return Record(pairs) if kind == "Record" else pairs
    if kind == "bytes":
        return bytes(content.memory)
    if kind == "numbers":
        return content
    if kind == "array":
        import numpy

        return numpy.array(content[0]).reshape(content[1])
    cls = _class_at(*content[:2])
    if kind == "enum":
        return cls[content[2]]
    fields = {name: _unpack(value, engine) for name, value in content[2].items()}
    instance = cls.__new__(cls)
    for name, value in fields.items():
        object.__setattr__(instance, name, value)
    return instance


def _class_at(module: str, path: str) -> Any:
    """Returns an enum or dataclass of a module that the program has imported; a state imports nothing."""
    import sys

    found: Any = sys.modules.get(module)
    for name in path.split("."):
        found = getattr(found, name, None)
    if not (isinstance(found, type) and (dataclasses.is_dataclass(found) or issubclass(found, enum.Enum))):
        raise ValueError(f"the state has a value of the type `{module}.{path}`, which this program does not have")
    return found
