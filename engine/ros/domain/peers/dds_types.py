"""Types of Cyclone DDS that are made from schemas, and qualities of service as rmw_cyclonedds has them."""

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
