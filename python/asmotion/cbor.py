"""CBOR (RFC 8949) with typed arrays (RFC 8746): the encoding of messages.

Numbers in `array.array`, numpy arrays, `memoryview` and `NumberView` are written as one byte string, without a step for
each element, and are read as a `NumberView` on the received bytes.
"""

from __future__ import annotations

import struct
import sys
from array import array
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Union

from asmotion.numbers import NumberView

if TYPE_CHECKING:
    from asmotion.memory import SharedMemory

Buffer = Union[bytes, bytearray, memoryview]

DEPTH = 64
"""Levels of lists and maps that may be nested."""

SHARED_TAG = 6386541
"""Tag of a reference to shared memory: `[offset, length]` in place of a byte string."""

_LARGE = 1024
"""Size in bytes from which a buffer is passed on instead of being copied."""

# formats of `memoryview` and `array.array`, by element kind and size in bytes
_FORMATS = {
    **{("u", size): code for size, code in ((1, "B"), (2, "H"), (4, "I"), (8, "Q"))},
    **{("i", size): code for size, code in ((1, "b"), (2, "h"), (4, "i"), (8, "q"))},
    **{("f", size): code for size, code in ((4, "f"), (8, "d"))},
}
_LITTLE_TAGS = {
    ("u", 1): 64, ("u", 2): 69, ("u", 4): 70, ("u", 8): 71,
    ("i", 1): 72, ("i", 2): 77, ("i", 4): 78, ("i", 8): 79,
    ("f", 4): 85, ("f", 8): 86,
}  # fmt: skip
_BIG_TAGS = {
    ("u", 2): 65, ("u", 4): 66, ("u", 8): 67, ("i", 2): 73, ("i", 4): 74, ("i", 8): 75, ("f", 4): 81, ("f", 8): 82,
}  # fmt: skip
_NATIVE_TAGS = _LITTLE_TAGS if sys.byteorder == "little" else {**_LITTLE_TAGS, **_BIG_TAGS}
_ELEMENTS = {tag: (element, "little") for element, tag in _LITTLE_TAGS.items()}
_ELEMENTS.update({tag: (element, "big") for element, tag in _BIG_TAGS.items()})
_ELEMENTS[68] = (("u", 1), "little")  # clamped arithmetic
_HALVES = {80: ">", 84: "<"}
"""Tags of typed arrays of half precision, for which no format of `memoryview` exists in all versions."""
_REFUSED = {
    4: "a decimal fraction", 5: "a big float", 30: "a rational number", 40: "an array of several dimensions",
    76: "a reserved tag", 83: "128-bit floats", 87: "128-bit floats", 1040: "an array of several dimensions",
}  # fmt: skip
"""Tags whose content would have another meaning without them."""


_SIMPLE = {None: 0xF6, True: 0xF5, False: 0xF4}
_DOUBLE = struct.Struct(">d")
_DOUBLE_ITEM = struct.Struct(">Bd")


class CborError(ValueError):
    """Bytes that are not one CBOR item, or a value that has no form in CBOR."""


def dumps(value: Any) -> bytes:
    """Encodes a value.

    Raises:
        CborError: a value that has no form in CBOR, with its place.
    """
    return b"".join(encode(value))


def encode(value: Any, memory: SharedMemory | None = None) -> list[Buffer]:
    """Encodes a value as a sequence of buffers. Large ones are in `memory`, or else are those of the value.

    Raises:
        CborError: a value that has no form in CBOR, with its place.
    """
    writer = _Writer(memory)
    writer.write(value, DEPTH)
    writer.flush()
    return writer.parts


class _Writer:
    def __init__(self, memory: SharedMemory | None) -> None:
        self.memory = memory
        self.parts: list[Buffer] = []
        self.pending = bytearray()

    def flush(self) -> None:
        if self.pending:
            self.parts.append(self.pending)
            self.pending = bytearray()

    def head(self, major: int, count: int) -> None:
        kind = major << 5
        if count < 24:
            self.pending.append(kind | count)
        elif count < 0x100:
            self.pending += struct.pack(">BB", kind | 24, count)
        elif count < 0x1_0000:
            self.pending += struct.pack(">BH", kind | 25, count)
        elif count < 0x1_0000_0000:
            self.pending += struct.pack(">BI", kind | 26, count)
        else:
            self.pending += struct.pack(">BQ", kind | 27, count)

    def raw(self, buffer: Buffer) -> None:
        if len(buffer) < _LARGE:
            self.pending += buffer
        else:
            self.flush()
            self.parts.append(buffer)

    def byte_string(self, content: Buffer) -> None:
        offset = self.memory.store(content) if self.memory is not None else None
        if offset is None:
            self.head(2, len(content))
            self.raw(content)
            return
        self.head(6, SHARED_TAG)
        self.head(4, 2)
        self.head(0, offset)
        self.head(0, len(content))

    def write(self, value: Any, depth: int) -> None:
        kind = type(value)
        if kind is float:
            self.pending += _DOUBLE_ITEM.pack(0xFB, value)
        elif kind is int:
            self.whole(value)
        elif kind is str:
            self.text(value)
        elif value is None or kind is bool:
            self.pending.append(_SIMPLE[value])
        elif depth == 0:
            raise CborError(f"lists and maps are nested more than {DEPTH} deep")
        elif kind is dict or isinstance(value, Mapping):
            self.mapping(value, depth - 1)
        elif kind is list or kind is tuple:
            self.head(4, len(value))
            for index, element in enumerate(value):
                try:
                    self.write(element, depth - 1)
                except CborError as error:
                    raise _within(f"[{index}]", error) from None
        elif isinstance(value, (bytes, bytearray)):
            self.byte_string(value)
        else:
            self.other(value, depth)

    def whole(self, value: int) -> None:
        if not -(1 << 63) <= value < 1 << 63:
            raise CborError(f"the integer {value} does not fit into 64 signed bits")
        if value >= 0:
            self.head(0, value)
        else:
            self.head(1, -1 - value)

    def text(self, value: str) -> None:
        text = value.encode()
        self.head(3, len(text))
        self.raw(text)

    def mapping(self, value: Mapping[Any, Any], depth: int) -> None:
        self.head(5, len(value))
        for key, element in value.items():
            if not isinstance(key, str):
                raise CborError(f"the key {key!r} is not a text")
            self.text(key)
            try:
                self.write(element, depth)
            except CborError as error:
                raise _within(f".{key}", error) from None

    def other(self, value: Any, depth: int) -> None:
        """Writes subclasses of the plain types, numbers of numpy, and arrays."""
        for plain in (bool, int, float, str):
            if isinstance(value, plain):
                self.write(plain(value), depth)
                return
        try:
            memory = value.memory if isinstance(value, NumberView) else memoryview(value)
        except TypeError:
            if hasattr(value, "item") and not hasattr(value, "__len__"):
                self.write(value.item(), depth)
            elif isinstance(value, (list, tuple)):
                self.write(list(value), depth)
            else:
                raise CborError(f"a value of the type {type(value).__name__} has no form as data") from None
            return
        self.numbers(value, memory, depth)

    def numbers(self, value: Any, memory: memoryview, depth: int) -> None:
        if memory.ndim == 0:
            self.write(value.item(), depth)
            return
        if memory.ndim != 1:
            raise CborError(f"an array has {memory.ndim} dimensions; use `.ravel()`")
        letter = memory.format.lstrip("@=<" if sys.byteorder == "little" else "@=>")
        kind = "f" if letter in "fd" else "i" if letter in "bhilqn" else "u" if letter in "BHILQN" else ""
        tag = _NATIVE_TAGS.get((kind, memory.itemsize))
        if tag is None:
            self.write(list(value.tolist()), depth)
            return
        try:
            content: Buffer = memory.cast("B")
        except TypeError:  # a stride, or a format with a prefix
            content = memory.tobytes()
        if tag != 64:  # a byte string is a list of bytes as it is
            self.head(6, tag)
        self.byte_string(content)


def _within(place: str, error: CborError) -> CborError:
    text = str(error)
    if text.startswith("at "):
        return CborError(f"at {place}{text[3:]}")
    return CborError(f"at {place}: {text}")


def loads(data: Buffer, memory: SharedMemory | None = None) -> Any:
    """Decodes exactly one item, which may refer to `memory`. Byte strings and typed arrays are a `NumberView` on `data`.

    Raises:
        CborError: `data` is not exactly one CBOR item.
    """
    reader = _Reader(memoryview(data).cast("B"), memory)
    value = reader.read(DEPTH)
    if reader.at != len(reader.memory):
        raise CborError(f"{len(reader.memory) - reader.at} bytes after the end")
    return value


_BREAK = object()


class _Reader:
    def __init__(self, memory: memoryview, shared: SharedMemory | None) -> None:
        self.memory = memory
        self.shared = shared
        self.at = 0

    def take(self, count: int) -> memoryview:
        end = self.at + count
        if end > len(self.memory):
            raise CborError("unexpected end")
        taken = self.memory[self.at : end]
        self.at = end
        return taken

    def argument(self, more: int) -> int | None:
        """Returns the argument of a head; `None` if the length is indefinite."""
        if more < 24:
            return more
        if more < 28:
            return int.from_bytes(self.take(1 << (more - 24)), "big")
        if more == 31:
            return None
        raise CborError(f"unknown initial byte with {more} in its lower bits")

    def read(self, depth: int) -> Any:
        value = self.item(depth)
        if value is _BREAK:
            raise CborError("a break outside of a list")
        return value

    def item(self, depth: int) -> Any:
        if depth == 0:
            raise CborError(f"lists and maps are nested more than {DEPTH} deep")
        at = self.at
        try:
            first = self.memory[at]
        except IndexError:
            raise CborError("unexpected end") from None
        self.at = at + 1
        major, more = first >> 5, first & 31
        if major == 7:
            return self.simple(more)
        argument = more if more < 24 else self.argument(more)
        if major == 2:
            return NumberView(self.take(argument) if argument is not None else memoryview(self.pieces(2)))
        if major == 3:
            return _utf8(self.take(argument) if argument is not None else self.pieces(3))
        if major == 4:
            return list(self.elements(argument, depth))
        if major == 5:
            return self.mapping(argument, depth)
        if argument is None:
            raise CborError("a number without an end")
        if major == 6:
            return self.tagged(argument, depth)
        return argument if major == 0 else -1 - argument

    def simple(self, more: int) -> Any:
        if more == 27:
            self.at += 8
            try:
                return _DOUBLE.unpack_from(self.memory, self.at - 8)[0]
            except struct.error:
                raise CborError("unexpected end") from None
        if more == 20 or more == 21:
            return more == 21
        if more == 22 or more == 23:
            return None
        if more in (25, 26):
            return struct.unpack({25: ">e", 26: ">f"}[more], self.take(1 << (more - 24)))[0]
        if more == 31:
            return _BREAK
        raise CborError(f"unknown simple value {more}")

    def pieces(self, major: int) -> bytes:
        pieces = []
        while (first := self.take(1)[0]) != 0xFF:
            piece = self.argument(first & 31)
            if first >> 5 != major or piece is None:
                raise CborError("a text in pieces of another kind")
            pieces.append(self.take(piece))
        return b"".join(pieces)

    def elements(self, count: int | None, depth: int) -> Any:
        if count is not None:
            if count > len(self.memory) - self.at:
                raise CborError("unexpected end")
            for _ in range(count):
                yield self.read(depth - 1)
            return
        while (value := self.item(depth - 1)) is not _BREAK:
            yield value

    def mapping(self, count: int | None, depth: int) -> dict[str, Any]:
        entries: dict[str, Any] = {}
        left = count
        while left is None or left > 0:
            key = self.item(depth - 1)
            if key is _BREAK and left is None:
                break
            if not isinstance(key, str):
                raise CborError("a break outside of a list" if key is _BREAK else f"the key {key!r} is not a text")
            value = self.item(depth - 1)
            if value is _BREAK:
                raise CborError(f"the key {key!r} has no value" if left is None else "a break outside of a list")
            entries[key] = value
            left = None if left is None else left - 1
        return entries

    def fetched(self, shared: SharedMemory, depth: int) -> memoryview:
        """Reads the content of a reference to shared memory."""
        reference = self.read(depth - 1)
        if not isinstance(reference, list) or [type(part) for part in reference] != [int, int]:
            raise CborError("a reference to shared memory is not an offset and a length")
        try:
            return shared.fetch(*reference)
        except ValueError as error:
            raise CborError(str(error)) from None

    def content(self, depth: int) -> memoryview | None:
        """Reads the content of a typed array; `None` if there is no byte string."""
        major = self.memory[self.at] >> 5 if self.at < len(self.memory) else None
        before = self.at
        if major == 2:
            length = self.argument(self.take(1)[0] & 31)
            if length is None:
                raise CborError("a typed array in pieces")
            return self.take(length)
        if major == 6 and self.argument(self.take(1)[0] & 31) == SHARED_TAG and self.shared is not None:
            return self.fetched(self.shared, depth)
        self.at = before
        return None

    def large_integer(self, tag: int, depth: int) -> int:
        content = self.read(depth - 1)
        if not isinstance(content, NumberView):
            raise CborError(f"the tag {tag}, a large integer, needs a byte string")
        value = int.from_bytes(content.memory, "big")
        return value if tag == 2 else -1 - value

    def halves(self, order: str, content: memoryview) -> NumberView:
        if len(content) % 2:
            raise CborError(f"a typed array of {len(content)} bytes has elements of 2 bytes")
        values = array("f", struct.unpack(f"{order}{len(content) // 2}e", content))
        return NumberView(memoryview(values))

    def tagged(self, tag: int, depth: int) -> Any:
        if tag == SHARED_TAG and self.shared is not None:
            return NumberView(self.fetched(self.shared, depth))
        if tag in _REFUSED:
            raise CborError(f"the tag {tag}, {_REFUSED[tag]}, is not supported")
        if tag in (2, 3):
            return self.large_integer(tag, depth)
        if tag not in _ELEMENTS and tag not in _HALVES:
            return self.read(depth - 1)
        content = self.content(depth)
        if content is None:
            raise CborError(f"the tag {tag}, a typed array, needs a byte string")
        if tag in _HALVES:
            return self.halves(_HALVES[tag], content)
        (element, order) = _ELEMENTS[tag]
        if len(content) % element[1]:
            raise CborError(f"a typed array of {len(content)} bytes has elements of {element[1]} bytes")
        memory, code = content, _FORMATS[element]
        if order == sys.byteorder or element[1] == 1:
            return NumberView(memory.cast(code))  # type: ignore[call-overload]
        swapped = array(code, bytes(memory))
        swapped.byteswap()
        return NumberView(memoryview(swapped))


def _utf8(content: Buffer) -> str:
    try:
        return str(content, "utf-8")
    except UnicodeDecodeError as error:
        raise CborError(f"a text that is not UTF-8: {error}") from None
