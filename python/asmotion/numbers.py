"""Lists of numbers that share memory with a received message."""

from __future__ import annotations

import sys
from array import array
from collections.abc import Iterator, Sequence
from typing import Any, Protocol, TypeVar, overload

N_co = TypeVar("N_co", covariant=True)


class Numbers(Protocol[N_co]):
    """Type of fields that contain numbers: a list, a tuple, `array.array`, a numpy array or a `NumberView`.

    Received messages contain a `NumberView`; every other kind may be written.
    """

    def __len__(self) -> int: ...

    def __getitem__(self, index: int, /) -> N_co: ...

    def __iter__(self) -> Iterator[N_co]: ...


class NumberView(Sequence[Any]):
    """Numbers of a received message, read-only and without a copy.

    `numpy.asarray(view)` and `memoryview(view.memory)` share the memory. A view equals each sequence with the same
    numbers.
    """

    __slots__ = ("memory",)

    def __init__(self, memory: memoryview) -> None:
        self.memory = memory.toreadonly()

    def __len__(self) -> int:
        return len(self.memory)

    @overload
    def __getitem__(self, index: int) -> Any: ...

    @overload
    def __getitem__(self, index: slice) -> NumberView: ...

    def __getitem__(self, index: int | slice) -> Any:
        if isinstance(index, slice):
            return NumberView(self.memory[index])
        return self.memory[index]

    def __iter__(self) -> Iterator[Any]:
        return iter(self.memory)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, NumberView):
            return self.memory == other.memory
        if isinstance(other, (list, tuple, array, bytes)):
            return len(self.memory) == len(other) and self.memory.tolist() == list(other)
        return NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return repr(self.memory.tolist())

    def tolist(self) -> list[Any]:
        """Returns the numbers as a new list."""
        return self.memory.tolist()

    @property
    def __array_interface__(self) -> dict[str, Any]:
        order = "<" if sys.byteorder == "little" else ">"
        letter = {"f": "f", "d": "f"}.get(self.memory.format, "u" if self.memory.format.isupper() else "i")
        kind = f"{order}{letter}{self.memory.itemsize}"
        return {
            "version": 3,
            "shape": (len(self.memory),),
            "typestr": kind,
            "data": self.memory,
            "strides": self.memory.strides,
        }
