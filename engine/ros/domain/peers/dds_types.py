"""Types of Cyclone DDS that are made from schemas, values of them, and qualities of service as rmw_cyclonedds has them."""

import struct
from dataclasses import fields

from cyclonedds.core import Policy, Qos
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.util import duration

PRIMITIVES = {
    "bool": bool,
    "text": str,
    "i8": types.int8,
    "i16": types.int16,
    "i32": types.int32,
    "i64": types.int64,
    "u8": types.uint8,
    "u16": types.uint16,
    "u32": types.uint32,
    "u64": types.uint64,
    "f32": types.float32,
    "f64": types.float64,
}
made = {}


def of_schema(schema, type_name=None):
    """The Python type of a schema; `type_name` is that of a whole message in DDS."""
    shape = schema["shape"]
    if isinstance(shape, str):
        return PRIMITIVES[shape]
    ((kind, content),) = shape.items()
    if kind == "list":
        return types.sequence[of_schema(content)]
    if kind == "array":
        element, count = content
        return types.array[of_schema(element), count]
    name = type_name or schema["name"].replace("/", "::msg::dds_::") + "_"
    if name not in made:
        members = {field["name"]: of_schema(field["schema"]) for field in content}
        members = members or {"structure_needs_at_least_one_member": types.uint8}
        made[name] = make_idl_struct(name.split("::")[-1], name, members)
    return made[name]


def value_of(schema, chance, kind=None):
    """A value of a schema; `kind` is the Python type of a whole message."""
    shape = schema["shape"]
    if shape == "bool":
        return chance.random() < 0.5
    if shape == "text":
        return "".join(chance.choice("aZ/_ Öß日😀") for _ in range(chance.randrange(9)))
    if shape in ("f32", "f64"):
        # each bit pattern but those of NaN, whose payload Python may change
        size, code = (4, "<f") if shape == "f32" else (8, "<d")
        (number,) = struct.unpack(code, chance.randbytes(size))
        return number if number == number else float("inf")
    if isinstance(shape, str):
        bits = int(shape[1:])
        if shape[0] == "i":
            return chance.randrange(-(1 << bits - 1), 1 << bits - 1)
        # 64-bit unsigned integers beyond the signed ones are not data
        return chance.randrange(1 << min(bits, 63))
    ((form, content),) = shape.items()
    if form == "list":
        return [value_of(content, chance) for _ in range(chance.randrange(4))]
    if form == "array":
        element, count = content
        return [value_of(element, chance) for _ in range(count)]
    kind = kind or of_schema(schema)
    members = {field["name"]: value_of(field["schema"], chance) for field in content}
    return kind(**(members or {"structure_needs_at_least_one_member": 0}))


def with_header(kind, type_name):
    """The type of a request or reply in the mapping of rmw_cyclonedds."""
    members = {"guid": types.uint64, "seq": types.int64}
    members |= {field.name: kind.__annotations__[field.name] for field in fields(kind)}
    return make_idl_struct(type_name.split("::")[-1], type_name, members)


def qos_of(settings):
    reliable = settings.get("reliable", True)
    transient = settings.get("transient", False)
    depth = settings.get("depth", 10)
    deadline = settings.get("deadline")
    policies = [Policy.Deadline(duration(seconds=deadline))] if deadline else []
    return Qos(
        *policies,
        Policy.Reliability.Reliable(duration(seconds=1)) if reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if transient else Policy.Durability.Volatile,
        Policy.History.KeepLast(depth),
        # as rmw_cyclonedds sets it: the messages for late readers are as many as the depth
        Policy.DurabilityService(0, Policy.History.KeepLast(depth), -1, -1, -1),
    )
