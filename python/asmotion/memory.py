"""Memory that the engine shares with a program, for large arrays."""

from __future__ import annotations

import mmap
import os
from collections.abc import Sequence

FROM = 4096
"""Size in bytes from which a buffer is passed in shared memory."""

_ALIGNMENT = 64


class SharedMemory:
    """The memory of requests, which the engine writes, and that of replies, which the program writes."""

    def __init__(self, files: Sequence[int], size: int) -> None:
        """Maps the two files and closes them.

        Raises:
            OSError: the files cannot be mapped.
            ValueError: they are shorter than `size`.
        """
        try:
            self._requests = mmap.mmap(files[0], size, prot=mmap.PROT_READ)
            self._replies = mmap.mmap(files[1], size)
        finally:
            for file in files:
                os.close(file)
        self._used = 0

    def begin(self) -> None:
        """Begins a reply."""
        self._used = 0

    def store(self, content: bytes | bytearray | memoryview) -> int | None:
        """Copies a buffer into the reply and returns its offset; `None` if it is small, or if there is no space."""
        offset = -(-self._used // _ALIGNMENT) * _ALIGNMENT
        end = offset + len(content)
        if len(content) < FROM or end > len(self._replies):
            return None
        self._replies[offset:end] = content
        self._used = end
        return offset

    def fetch(self, offset: int, length: int) -> memoryview:
        """Copies a byte string of the request, which is valid only until the reply.

        Raises:
            ValueError: it is not inside the memory.
        """
        if offset < 0 or length < 0 or offset + length > len(self._requests):
            raise ValueError(f"{length} bytes at {offset} are outside of the shared memory")
        return memoryview(self._requests[offset : offset + length])
