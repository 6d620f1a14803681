"""The encoding: round trips, malformed bytes, and a peer."""

import random
import struct
import sys
import unittest
from array import array

from asmotion import cbor
from asmotion.numbers import NumberView

try:
    import cbor2
except ImportError:
    cbor2 = None
try:
    import numpy
except ImportError:
    numpy = None


def any_value(chance, depth=4):
    kind = chance.randrange(9 if depth else 6)
    if kind == 0:
        return chance.choice([None, True, False])
    if kind == 1:
        return chance.choice([1, -1]) * chance.getrandbits(chance.choice([3, 5, 8, 16, 32, 63]))
    if kind == 2:
        return chance.choice([0.0, -0.0, 1e300, float("inf"), chance.uniform(-5, 5)])
    if kind == 3:
        return "".join(chance.choice("aß€😀\n") for _ in range(chance.choice([0, 3, 30])))
    if kind == 4:
        return chance.randbytes(chance.choice([0, 5, 24, 2000]))
    if kind == 5:
        code = chance.choice("bBhHiIqQfd")
        count = chance.choice([0, 1, 7, 300])
        return array(code, [byte >> 1 for byte in chance.randbytes(count)])
    if kind == 6:
        return [any_value(chance, depth - 1) for _ in range(chance.randrange(5))]
    return {f"key {index}": any_value(chance, depth - 1) for index in range(chance.choice([0, 2, 26]))}


class Encoding(unittest.TestCase):
    def test_every_value_survives(self):
        chance = random.Random(1)
        for _ in range(500):
            value = any_value(chance)
            encoded = cbor.dumps(value)
            self.assertEqual(cbor.loads(encoded), value)
            self.assertEqual(cbor.dumps(cbor.loads(encoded)), encoded)

    @unittest.skipUnless(cbor2, "cbor2 is not installed")
    def test_a_peer_reads_what_it_writes_and_vice_versa(self):
        chance = random.Random(2)

        def plain(value):
            if isinstance(value, cbor2.CBORTag):
                return value.value
            if isinstance(value, array):
                return value.tobytes()
            if isinstance(value, dict):
                return {key: plain(element) for key, element in value.items()}
            return [plain(element) for element in value] if isinstance(value, (list, tuple)) else value

        for _ in range(300):
            value = any_value(chance)
            self.assertEqual(plain(cbor2.loads(cbor.dumps(value))), plain(value))
            self.assertEqual(cbor.loads(cbor2.dumps(plain(value))), plain(value))

    def test_malformed_bytes_are_errors_of_its_own(self):
        chance = random.Random(3)
        for _ in range(300):
            data = bytearray(cbor.dumps(any_value(chance)))
            for _ in range(chance.randrange(1, 4)):
                if data:
                    data[chance.randrange(len(data))] = chance.randrange(256)
            data = data[: chance.randrange(len(data) + 1)]
            try:
                cbor.loads(data)
            except cbor.CborError:
                pass

    def test_lengths_are_checked_before_memory_is_used(self):
        for head in (b"\x9b", b"\xbb", b"\x5b", b"\x7b", b"\xd8\x48\x5b"):
            with self.assertRaisesRegex(cbor.CborError, "end"):
                cbor.loads(head + b"\x00\x00\x7f\xff\xff\xff\xff\xff")
        with self.assertRaisesRegex(cbor.CborError, "deep"):
            cbor.loads(b"\x81" * 100_000)

    def test_texts_and_lists_may_come_in_pieces(self):
        self.assertEqual(cbor.loads(b"\x9f\x01\x7f\x61a\x61b\xff\xff"), [1, "ab"])
        self.assertEqual(cbor.loads(b"\xbf\x61a\x5f\x41x\xff\xff"), {"a": b"x"})
        with self.assertRaises(cbor.CborError):
            cbor.loads(b"\x81\xff")

    def test_typed_arrays_of_either_byte_order_are_read(self):
        little = b"\xd8\x55\x48" + struct.pack("<2f", 1.5, -2)
        big = b"\xd8\x51\x48" + struct.pack(">2f", 1.5, -2)
        self.assertEqual(cbor.loads(little), [1.5, -2])
        self.assertEqual(cbor.loads(big), [1.5, -2])
        with self.assertRaisesRegex(cbor.CborError, "7 bytes"):
            cbor.loads(b"\xd8\x55\x47" + bytes(7))

    def test_typed_arrays_of_half_precision_are_read(self):
        self.assertEqual(cbor.loads(b"\xd8\x54\x46" + struct.pack("<3e", 1.5, -2, float("inf"))), [1.5, -2, float("inf")])
        self.assertEqual(cbor.loads(b"\xd8\x50\x44" + struct.pack(">2e", 1.5, -2)), [1.5, -2])

    def test_tags_that_change_their_content_are_read_or_refused(self):
        self.assertEqual(cbor.loads(b"\xc2\x42\x01\xf4"), 500)
        self.assertEqual(cbor.loads(b"\xc3\x42\x01\xf4"), -501)
        self.assertEqual(cbor.loads(b"\xc0\x64date"), "date")
        for tag in (76, 83, 87):
            with self.assertRaisesRegex(cbor.CborError, f"tag {tag}"):
                cbor.loads(bytes([0xD8, tag, 0x50]) + bytes(16))
        with self.assertRaisesRegex(cbor.CborError, "tag 82"):
            cbor.loads(b"\xd8\x52\x81\x01")
        with self.assertRaisesRegex(cbor.CborError, "tag 40"):
            cbor.loads(b"\xd8\x28\x82\x82\x01\x02\x42\x01\x02")

    def test_an_integer_that_the_engine_cannot_represent_is_refused_with_its_place(self):
        for value in (1 << 63, -(1 << 63) - 1):
            with self.assertRaisesRegex(cbor.CborError, r"at \.stamp: the integer -?\d+ does not fit"):
                cbor.dumps({"stamp": value})

    def test_a_value_without_a_form_is_named_with_its_place(self):
        with self.assertRaisesRegex(cbor.CborError, r"at \.a\[1\]: a value of the type object has no form"):
            cbor.dumps({"a": [1, object()]})
        with self.assertRaisesRegex(cbor.CborError, "not a text"):
            cbor.dumps({1: 2})

    def test_large_arrays_are_not_copied(self):
        numbers = array("d", range(10_000))
        parts = cbor.encode({"data": numbers})
        address = numbers.buffer_info()[0]
        self.assertTrue(any(_address(part) == address for part in parts if isinstance(part, memoryview)))
        frame = b"".join(parts)
        self.assertIs(cbor.loads(frame)["data"].memory.obj, frame)


def _address(view):
    import ctypes

    return ctypes.addressof(ctypes.c_char.from_buffer(view))


@unittest.skipUnless(numpy, "numpy is not installed")
class Numpy(unittest.TestCase):
    def test_every_kind_survives_without_a_copy(self):
        for kind in ("int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "float32", "float64"):
            numbers = numpy.arange(2500).astype(kind)
            parts = cbor.encode(numbers)
            self.assertTrue(any(numpy.shares_memory(numpy.frombuffer(part, "u1"), numbers) for part in parts), kind)
            frame = b"".join(parts)
            read = numpy.asarray(cbor.loads(frame))
            self.assertEqual((read.dtype, read.tolist()), (numbers.dtype, numbers.tolist()))
            self.assertTrue(numpy.shares_memory(read, numpy.frombuffer(frame, "u1")))
            self.assertFalse(read.flags.writeable)

    def test_strides_scalars_and_booleans(self):
        self.assertEqual(cbor.loads(cbor.dumps(numpy.arange(10)[::2])), [0, 2, 4, 6, 8])
        self.assertEqual(cbor.loads(cbor.dumps([numpy.float32(1.5), numpy.int8(-3), numpy.bool_(True)])), [1.5, -3, True])
        self.assertEqual(cbor.loads(cbor.dumps(numpy.array([True, False]))), [True, False])
        with self.assertRaisesRegex(cbor.CborError, "ravel"):
            cbor.dumps(numpy.zeros((2, 2)))


class Views(unittest.TestCase):
    def test_a_view_is_a_sequence_that_equals_its_numbers(self):
        view = NumberView(memoryview(array("h", [1, 2, 3])))
        self.assertEqual((list(view), view[1], view[1:], len(view)), ([1, 2, 3], 2, [2, 3], 3))
        self.assertEqual(view, (1, 2, 3))
        self.assertNotEqual(view, [1, 2])
        self.assertEqual(repr(view), "[1, 2, 3]")
        with self.assertRaises(TypeError):
            view.memory[0] = 9


if __name__ == "__main__":
    sys.exit(unittest.main())
