"""Annotations, schemas and conversions."""

import enum
import math
import unittest
from array import array
from dataclasses import dataclass, field
from typing import Annotated, Any, Optional, Union

import asmotion
from asmotion import Length, MismatchError, Numbers, Record, f32, f64, i8, u8, u16, u64
from asmotion.errors import DeclarationError
from asmotion.types import form_of

try:
    import numpy
    import numpy.typing
except ImportError:
    numpy = None


class Mode(enum.Enum):
    IDLE = "idle"
    BUSY = "busy"


@dataclass
class Part:
    x: float = 0.0


@asmotion.message("acme/State")
class State:
    """Everything that a message can have."""

    opening: Annotated[f64, "between the fingers, m"] = 0.0
    w: f64 = 1.0
    flags: u8 = 0
    mode: Mode = Mode.IDLE
    name: str = ""
    part: Part = field(default_factory=Part)
    near: Optional[Part] = None
    joints: "list[f64]" = field(default_factory=list)
    ranges: Annotated[Numbers[f32], "m"] = ()
    covariance: Annotated[Numbers[f64], Length(3)] = (0.0, 0.0, 0.0)
    parts: tuple[Part, ...] = ()
    picture: bytes = b""
    from_: str = ""
    more: Any = None


FORM = form_of(State)


class Schemas(unittest.TestCase):
    def test_an_annotation_determines_the_schema(self):
        fields = {item["name"]: item for item in FORM.shape["record"]}
        shapes = {name: item["schema"]["shape"] for name, item in fields.items()}
        self.assertEqual(FORM.name, "acme/State")
        self.assertEqual(fields["opening"]["doc"], "between the fingers, m")
        self.assertEqual(fields["w"]["initial"], 1.0)
        self.assertNotIn("initial", fields["opening"])
        self.assertEqual([shapes[name] for name in ("opening", "flags", "mode", "name")], ["f64", "u8", "text", "text"])
        self.assertEqual(shapes["near"], {"option": fields["part"]["schema"]})
        self.assertEqual(shapes["ranges"], {"list": {"name": "", "shape": "f32"}})
        self.assertEqual(shapes["covariance"], {"array": [{"name": "", "shape": "f64"}, 3]})
        self.assertEqual(shapes["picture"], {"list": {"name": "", "shape": "u8"}})
        self.assertEqual((shapes["more"], "from" in shapes), ("any", True))

    def test_a_type_without_a_form_is_named_with_its_place(self):
        class Odd:
            pass

        for annotation in (Odd, Union[int, str], dict[int, str], Numbers[str]):
            with self.assertRaisesRegex(DeclarationError, "field `x`.*no form in a message"):
                form_of(annotation, "field `x`")
        with self.assertRaisesRegex(DeclarationError, "no message name"):
            asmotion.message("State")(Odd)

        @asmotion.message("acme/Bad")
        class Bad:
            count: u8 = 300

        with self.assertRaisesRegex(DeclarationError, "default of field `count` of `Bad` must be u8.*300"):
            form_of(Bad)


class Values(unittest.TestCase):
    def test_a_message_survives(self):
        state = State(0.5, mode=Mode.BUSY, near=Part(2.0), joints=[1, 2], parts=(Part(1.0),), picture=b"ab", from_="x")
        back = FORM.load(FORM.dump(state))
        self.assertEqual(back, state)
        self.assertIsInstance(back.joints, list)
        self.assertIsInstance(back.picture, bytes)
        self.assertEqual(FORM.load({}), State())

    def test_lists_of_numbers_are_packed(self):
        dumped = FORM.dump(State(joints=[1.0, 2.0], ranges=array("f", [1.5])))
        self.assertEqual((dumped["joints"].memory.format, dumped["ranges"].memory.format), ("d", "f"))
        self.assertEqual(FORM.dump(State(ranges=array("d", [1.5])))["ranges"].memory.format, "f")
        self.assertEqual(form_of(list[u64]).dump([1, 2]), [1, 2])
        self.assertEqual(form_of(list[int]).dump((i for i in ())) if False else [], [])

    def test_a_mismatch_has_its_place(self):
        for value, text in (
            ({"opening": "wide"}, r"field `opening` must be f64, not 'wide' \(str\)"),
            ({"part": {"x": None}}, r"field `part.x` must be f64, not None"),
            ({"flags": 256}, "field `flags` must be u8, from 0 to 255, not 256"),
            ({"flags": 1.5}, "field `flags` must be u8"),
            ({"flags": True}, "field `flags` must be u8"),
            ({"joints": [1.0, "x"]}, r"field `joints\[1\]` must be f64"),
            ({"joints": "12"}, "field `joints` must be"),
            ({"parts": [Part(), 5]}, r"field `parts\[1\]` must be Part"),
            ({"covariance": [1.0]}, "field `covariance` must have 3 elements, not 1"),
            ({"mode": "lazy"}, "field `mode` must be one of 'idle', 'busy'"),
            ({"part": {"y": 1.0}}, "field `part` has no field `y`; the fields of Part are x"),
            ({"opning": 1.0}, "has no field `opning`"),
        ):
            with self.assertRaisesRegex(MismatchError, text):
                FORM.dump(value)
        with self.assertRaisesRegex(MismatchError, "field `opening` must be f64"):
            FORM.dump(State(opening="wide"))
        with self.assertRaisesRegex(MismatchError, r"\[1\]. must be i8"):
            form_of(list[i8]).dump([1, 200])
        with self.assertRaises(MismatchError):
            form_of(Numbers[u16]).dump(array("d", [1.5]))

    def test_floats_that_json_lacks_are_texts(self):
        self.assertTrue(math.isnan(form_of(f32).load("NaN")))
        self.assertEqual(form_of(list[f64]).load([1, "-Infinity"]), [1, -math.inf])

    def test_data_of_an_unknown_type_are_records(self):
        read = form_of("acme/Unknown").load({"a": {"b": [1]}})
        self.assertEqual((read.a.b, read["a"]), ([1], {"b": [1]}))
        with self.assertRaisesRegex(AttributeError, "there are a"):
            read.c
        self.assertEqual(form_of(Any).dump({"s": Part(1.0), "m": Mode.BUSY}), {"s": {"x": 1.0}, "m": "busy"})
        self.assertIsInstance(read, Record)

    @unittest.skipUnless(numpy, "numpy is not installed")
    def test_arrays_of_numpy_share_memory(self):
        form = form_of(numpy.typing.NDArray[numpy.float32])
        numbers = numpy.arange(5, dtype="float32")
        dumped = form.dump(numbers)
        self.assertTrue(numpy.shares_memory(numpy.asarray(dumped), numbers))
        loaded = form.load(dumped)
        self.assertIsInstance(loaded, numpy.ndarray)
        self.assertTrue(numpy.shares_memory(loaded, numbers))
        self.assertEqual(form.dump(numpy.arange(3)), [0, 1, 2])
        self.assertEqual(form_of(f32).dump(numpy.float32(0.5)), 0.5)
        self.assertEqual(FORM.dump(State(joints=numbers))["joints"].memory.format, "d")
        with self.assertRaisesRegex(MismatchError, "ravel"):
            form.dump(numpy.zeros((2, 2), "float32"))
