"""A component's end of the program protocol, written from docs/program-protocol.md with the standard library alone."""

import os
import socket
import struct

PACKED = {64: "B", 69: "<H", 70: "<I", 71: "<Q", 72: "b", 77: "<h", 78: "<i", 79: "<q", 85: "<f", 86: "<d"}


def head(major, number):
    for extra, (limit, form) in enumerate([(24, None), (1 << 8, ">B"), (1 << 16, ">H"), (1 << 32, ">I"), (1 << 64, ">Q")]):
        if number < limit:
            return bytes([major << 5 | number]) if form is None else bytes([major << 5 | 23 + extra]) + struct.pack(form, number)
    raise ValueError(number)


def encode(value):
    if value is None:
        return b"\xf6"
    if isinstance(value, bool):
        return b"\xf5" if value else b"\xf4"
    if isinstance(value, int):
        return head(0, value) if value >= 0 else head(1, -1 - value)
    if isinstance(value, float):
        return b"\xfb" + struct.pack(">d", value)
    if isinstance(value, bytes):
        return head(2, len(value)) + value
    if isinstance(value, str):
        text = value.encode()
        return head(3, len(text)) + text
    if isinstance(value, dict):
        return head(5, len(value)) + b"".join(encode(key) + encode(it) for key, it in value.items())
    return head(4, len(value)) + b"".join(map(encode, value))


def decode(data, at=0):
    """Returns a value and the position behind it."""
    major, extra = data[at] >> 5, data[at] & 31
    at += 1
    number = extra
    if extra >= 24:
        size = 1 << extra - 24
        number, bits, at = int.from_bytes(data[at:at + size], "big"), data[at:at + size], at + size
    if major == 0:
        return number, at
    if major == 1:
        return -1 - number, at
    if major in (2, 3):
        chunk = data[at:at + number]
        return chunk if major == 2 else chunk.decode(), at + number
    if major == 4:
        items = []
        for _ in range(number):
            item, at = decode(data, at)
            items.append(item)
        return items, at
    if major == 5:
        items = {}
        for _ in range(number):
            key, at = decode(data, at)
            items[key], at = decode(data, at)
        return items, at
    if major == 6:
        content, at = decode(data, at)
        form = PACKED.get(number)
        return ([it for it, in struct.iter_unpack(form, content)] if form else content), at
    if extra == 27:
        return struct.unpack(">d", bits)[0], at
    if extra == 26:
        return struct.unpack(">f", bits)[0], at
    return {20: False, 21: True, 22: None, 23: None}[extra], at


def connect():
    connection = socket.socket(socket.AF_UNIX)
    connection.connect(os.environ["ASMOTION_SOCKET"])
    return connection


def receive(connection):
    """Returns the next request; None at the end."""
    def exactly(count):
        data = b""
        while len(data) < count:
            chunk = connection.recv(count - len(data))
            if not chunk:
                raise EOFError
            data += chunk
        return data
    try:
        return decode(exactly(struct.unpack("<I", exactly(4))[0]))[0]
    except EOFError:
        return None


def send(connection, message):
    data = encode(message)
    connection.sendall(struct.pack("<I", len(data)) + data)


def serve(declaration, hooks):
    """Answers requests. `hooks` maps their types to functions; the others are answered with `ok`."""
    connection = connect()
    answers = {"cycle": {"type": "done"}, "recover": {"type": "done"}, "serve": {"type": "done"}, "stop": {"type": "done"},
               "inspect": {"type": "inspected", "fields": []}, "freeze": {"type": "unsupported"}, "thaw": {"type": "unsupported"}}
    while (request := receive(connection)) is not None and request["type"] != "exit":
        kind = request["type"]
        if kind == "hello":
            send(connection, {"type": "declare", "protocol": 1, **declaration})
        elif kind in hooks:
            send(connection, hooks[kind](request))
        else:
            send(connection, answers.get(kind, {"type": "ok"}))


def record(name, **fields):
    """The schema of a message type whose fields have these shapes."""
    fields = [{"name": field, "schema": {"name": "", "shape": shape}} for field, shape in fields.items()]
    return {"name": name, "shape": {"record": fields}}
