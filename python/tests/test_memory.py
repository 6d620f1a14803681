"""Large data in shared memory: the encoding, and a program that the engine offers it to."""

import array
import os
import socket
import unittest

from asmotion import cbor
from asmotion.memory import SharedMemory

from .test_program import ECHO, Driver

SIZE = 1 << 20


def files():
    """Two files in memory."""
    both = [os.memfd_create("test"), os.memfd_create("test")]
    for file in both:
        os.ftruncate(file, SIZE)
    return both


@unittest.skipUnless(hasattr(os, "memfd_create"), "this system has no files in memory")
class Memory(unittest.TestCase):
    def setUp(self):
        ours = files()
        theirs = [os.dup(file) for file in reversed(ours)]
        self.ours, self.theirs = SharedMemory(ours, SIZE), SharedMemory(theirs, SIZE)

    def passed(self, value):
        self.ours.begin()
        data = b"".join(cbor.encode(value, self.ours))
        return len(data), cbor.loads(data, self.theirs)

    def test_large_buffers_are_in_shared_memory_while_there_is_space(self):
        floats = array.array("f", range(5000))
        size, (first, second, small) = self.passed([floats, bytes(100_000), b"small"])
        self.assertLess(size, 60)
        self.assertEqual((first, len(second), small), (list(floats), 100_000, b"small"))
        size, (first, second) = self.passed([bytes(SIZE // 2 + 1), bytes([7]) * (SIZE // 2)])
        self.assertGreater(size, SIZE // 2)
        self.assertEqual((sum(first), sum(second)), (0, 7 * (SIZE // 2)))

    def test_data_stay_when_the_memory_changes(self):
        _, first = self.passed(bytes([1]) * 5000)
        _, second = self.passed(bytes([2]) * 5000)
        self.assertEqual((first[0], second[0]), (1, 2))

    def test_wrong_references_are_refused(self):
        head = bytes.fromhex("da0061736d")
        for reference in ([SIZE - 5, 10], [2**63, 2**63], [-1, 5], [1], ["a", 1], 3):
            with self.assertRaises(cbor.CborError):
                cbor.loads(head + cbor.dumps(reference), self.theirs)

    def test_a_program_uses_the_memory_that_it_is_offered(self):
        with Driver(ECHO) as driver:
            requests, replies = files()
            hello = cbor.dumps({"type": "hello", "protocol": 1, "clock": "virtual", "shared_memory": SIZE})
            frame = len(hello).to_bytes(4, "little") + hello
            socket.send_fds(driver.socket, [frame], [requests, replies])
            memory = SharedMemory([replies, requests], SIZE)
            self.assertIs(driver.receive()["shared_memory"], True)
            driver.ask(type="configure", properties={}, schemas={})
            picture = {"width": 5, "data": bytes(range(250)) * 1000}
            request = {"type": "cycle", "now": 1, "number": 1, "inputs": {"seen": {"samples": [picture]}}}
            data = b"".join(cbor.encode(request, memory))
            self.assertLess(len(data), 200)
            driver.socket.sendall(len(data).to_bytes(4, "little") + data)
            length = int.from_bytes(driver.exactly(4), "little")
            self.assertLess(length, 200)
            reply = cbor.loads(driver.exactly(length), memory)
            ((_, shown),) = reply["outputs"]
            self.assertEqual(shown["data"], picture["data"])


if __name__ == "__main__":
    unittest.main()
