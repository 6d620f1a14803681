"""Types of messages: from Python annotations to schemas, and values to data and back.

| annotation | schema |
|---|---|
| `bool`, `int`, `float`, `str` | `bool`, `i64`, `f64`, `text` |
| `i8` … `i64`, `u8` … `u64`, `f32`, `f64` | the same; integers and floats of Python with these limits |
| a class with `@message("acme/State")` | a record of this name |
| another dataclass | a record without a name |
| `list[T]`, `tuple[T, ...]` | a list; read as a list or tuple |
| `Numbers[f32]` | a list of numbers; read as a `NumberView`, without a copy |
| `numpy.typing.NDArray[numpy.float32]` | a list of numbers; read as an array, without a copy |
| `Annotated[T, Length(36)]` for such a list | an array of fixed length |
| `bytes` | a list of `u8` |
| `T \\| None` | an optional value |
| an `enum.Enum` of texts | `text` |
| `Any` | any data; records are read as `Record` |

A text in an annotation is a field's description: `opening: Annotated[f64, "between the fingers, m"] = 0.0`.
"""

from __future__ import annotations

import collections.abc
import dataclasses
import enum
import keyword
import operator
import types
import typing
from array import array
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar, Union

from asmotion import cbor
from asmotion.errors import DeclarationError, MismatchError
from asmotion.numbers import Numbers, NumberView

if typing.TYPE_CHECKING:
    from typing_extensions import dataclass_transform
else:

    def dataclass_transform(**_: Any) -> Any:
        return lambda decorator: decorator


T = TypeVar("T")


@dataclass(frozen=True)
class Scalar:
    """Kind and size of a number."""

    word: str


@dataclass(frozen=True)
class Length:
    """Fixed number of elements of a list."""

    count: int


i8 = Annotated[int, Scalar("i8")]
i16 = Annotated[int, Scalar("i16")]
i32 = Annotated[int, Scalar("i32")]
i64 = Annotated[int, Scalar("i64")]
u8 = Annotated[int, Scalar("u8")]
u16 = Annotated[int, Scalar("u16")]
u32 = Annotated[int, Scalar("u32")]
u64 = Annotated[int, Scalar("u64")]
f32 = Annotated[float, Scalar("f32")]
f64 = Annotated[float, Scalar("f64")]

# typecode of `array.array` for each kind of number
_CODES = {
    "i8": "b", "i16": "h", "i32": "i", "i64": "q", "u8": "B", "u16": "H", "u32": "I", "u64": "Q", "f32": "f", "f64": "d",
}  # fmt: skip
_NUMPY = {
    "int8": "i8", "int16": "i16", "int32": "i32", "int64": "i64", "uint8": "u8", "uint16": "u16", "uint32": "u32",
    "uint64": "u64", "float32": "f32", "float64": "f64",
}  # fmt: skip
_NOT_IN_JSON = {"NaN": float("nan"), "Infinity": float("inf"), "-Infinity": float("-inf")}


class Record(dict[str, Any]):
    """Data of a type that is known only at run time: fields as attributes (`scan.ranges`) and by name."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            known = ", ".join(self) or "no fields"
            raise AttributeError(f"there is no field `{name}`; there are {known}") from None

    def __setattr__(self, name: str, value: Any) -> None:
        self[name] = value


@dataclass_transform(field_specifiers=(dataclasses.field,))
def message(name: str) -> Callable[[type[T]], type[T]]:
    """Makes a class a dataclass and the message type of this name, for example `acme/GripperState`."""

    def decorate(cls: type[T]) -> type[T]:
        if "/" not in name or name.strip() != name:
            raise DeclarationError(f'`{cls.__name__}`: "{name}" is no message name; write it as "acme/{cls.__name__}"')
        if "__dataclass_fields__" not in cls.__dict__:
            cls = dataclass(cls)
        setattr(cls, "__message__", name)
        return cls

    return decorate


class Form:
    """A type: its schema, and the conversion between values and data."""

    name = ""
    shape: Any = "any"

    @property
    def schema(self) -> dict[str, Any]:
        return {"name": self.name, "shape": self.shape}

    def __str__(self) -> str:
        return self.name or str(self.shape)

    def zero(self) -> Any:
        """Returns the value of an omitted field."""
        return None

    def dump(self, value: Any) -> Any:
        """Returns a value as data.

        Raises:
            MismatchError: the value does not fit, with its place.
        """
        return _plain(value)

    def load(self, data: Any) -> Any:
        """Returns data as a value.

        Raises:
            MismatchError: the data do not fit, with their place.
        """
        return _record(data)

    def mismatch(self, value: Any) -> MismatchError:
        shown = repr(value)
        shown = shown if len(shown) <= 60 else f"{shown[:57]}…"
        return MismatchError(f"must be {self}, not {shown} ({type(value).__name__})")


class Named(Form):
    """A type of which only the name is known."""

    def __init__(self, name: str) -> None:
        self.name = name


class Boolean(Form):
    shape = "bool"

    def zero(self) -> bool:
        return False

    def dump(self, value: Any) -> bool:
        if isinstance(value, bool) or type(value).__name__ in ("bool_", "bool"):
            return bool(value)
        raise self.mismatch(value)

    def load(self, data: Any) -> bool:
        return self.dump(data)


class Text(Form):
    shape = "text"

    def zero(self) -> str:
        return ""

    def dump(self, value: Any) -> str:
        if isinstance(value, str):
            return str(value)
        raise self.mismatch(value)

    def load(self, data: Any) -> str:
        return self.dump(data)


class Choice(Form):
    """An enum whose values are texts."""

    shape = "text"

    def __init__(self, cls: type[enum.Enum]) -> None:
        self.cls = cls
        if not all(isinstance(member.value, str) for member in cls):
            raise DeclarationError(f"`{cls.__name__}`: the values of an enum in a message are texts")

    def __str__(self) -> str:
        return "one of " + ", ".join(repr(member.value) for member in self.cls)

    def zero(self) -> Any:
        return next(iter(self.cls))

    def dump(self, value: Any) -> str:
        return str(self.load(value).value)

    def load(self, data: Any) -> enum.Enum:
        try:
            return self.cls(data)
        except ValueError:
            raise self.mismatch(data) from None


class Whole(Form):
    def __init__(self, word: str) -> None:
        self.shape = word
        bits = int(word[1:])
        signed = word[0] == "i"
        # data has integers of 64 bits with a sign
        self.least = -(1 << bits - 1) if signed else 0
        self.greatest = (1 << min(bits - signed, 63)) - 1

    def zero(self) -> int:
        return 0

    def dump(self, value: Any) -> int:
        if isinstance(value, bool):
            raise self.mismatch(value)
        try:
            number = operator.index(value)
        except TypeError:
            raise self.mismatch(value) from None
        if not self.least <= number <= self.greatest:
            raise MismatchError(f"must be {self}, from {self.least} to {self.greatest}, not {number}")
        return number

    def load(self, data: Any) -> int:
        return self.dump(data)


class Real(Form):
    def __init__(self, word: str) -> None:
        self.shape = word

    def zero(self) -> float:
        return 0.0

    def dump(self, value: Any) -> float:
        if type(value) is float:
            return value
        if isinstance(value, (str, bool)) or not hasattr(value, "__float__") and not hasattr(value, "__index__"):
            raise self.mismatch(value)
        try:
            return float(value)
        except (TypeError, ValueError, OverflowError):
            raise self.mismatch(value) from None

    def load(self, data: Any) -> float:
        if isinstance(data, str) and data in _NOT_IN_JSON:
            return _NOT_IN_JSON[data]
        return self.dump(data)


class Optional(Form):
    def __init__(self, some: Form) -> None:
        self.some = some
        self.shape = {"option": some.schema}

    def __str__(self) -> str:
        return f"{self.some} or None"

    def dump(self, value: Any) -> Any:
        return None if value is None else self.some.dump(value)

    def load(self, data: Any) -> Any:
        return None if data is None else self.some.load(data)


class Elements(Form):
    """A list of any elements, of any or a fixed length."""

    def __init__(self, element: Form, count: int | None, make: Callable[[Any], Any] = list) -> None:
        self.element = element
        self.count = count
        self.make = make
        self.shape = {"list": element.schema} if count is None else {"array": [element.schema, count]}

    def __str__(self) -> str:
        length = "" if self.count is None else str(self.count)
        return f"{self.element}[{length}]"

    def zero(self) -> Any:
        return self.make(self.element.zero() for _ in range(self.count or 0))

    def dump(self, value: Any) -> Any:
        return self.each(value, self.element.dump)

    def load(self, data: Any) -> Any:
        return self.make(self.each(data, self.element.load))

    def each(self, values: Any, convert: Callable[[Any], Any]) -> list[Any]:
        if isinstance(values, (str, collections.abc.Mapping)) or not hasattr(values, "__iter__"):
            raise self.mismatch(values)
        self.check(values)
        converted = []
        for index, value in enumerate(values):
            try:
                converted.append(convert(value))
            except MismatchError as error:
                raise within(f"[{index}]", error) from None
        return converted

    def check(self, values: Any) -> None:
        if self.count is not None and len(values) != self.count:
            raise MismatchError(f"must have {self.count} elements, not {len(values)}")


class NumberList(Elements):
    """A list of numbers, converted without a step for each element where their kinds agree."""

    def __init__(self, element: Form, count: int | None, make: Callable[[NumberView], Any]) -> None:
        super().__init__(element, count, make)
        self.code = _CODES[element.shape]

    def zero(self) -> Any:
        return self.make(self.packed([0] * (self.count or 0)))

    def dump(self, value: Any) -> Any:
        if isinstance(value, (str, collections.abc.Mapping)) or not hasattr(value, "__len__"):
            raise self.mismatch(value)
        self.check(value)
        if self.element.shape == "u64":  # data has no packed numbers of this kind
            return self.each(value, self.element.dump)
        try:
            return self.packed(value)
        except MismatchError:
            raise
        except (TypeError, ValueError, OverflowError):
            return NumberView(memoryview(array(self.code, self.each(value, self.element.dump))))

    def load(self, data: Any) -> Any:
        if isinstance(data, (str, collections.abc.Mapping)) or not hasattr(data, "__len__"):
            raise self.mismatch(data)
        self.check(data)
        try:
            return self.make(self.packed(data))
        except MismatchError:
            raise
        except (TypeError, ValueError, OverflowError):
            return self.make(NumberView(memoryview(array(self.code, self.each(data, self.element.load)))))

    def packed(self, numbers: Any) -> NumberView:
        if isinstance(numbers, NumberView):
            memory = numbers.memory
        elif isinstance(numbers, (bytes, bytearray)) and self.code in "bB":
            memory = memoryview(numbers)
        elif isinstance(numbers, (list, tuple)):
            return NumberView(memoryview(array(self.code, numbers)))
        else:
            memory = memoryview(numbers)
        if memory.ndim != 1:
            raise MismatchError(f"must have one dimension, not {memory.ndim}; use `.ravel()`")
        if self.agrees(memory):
            return NumberView(memory)
        if self.code in "fd" or memory.format not in ("f", "d"):
            return NumberView(memoryview(array(self.code, memory.tolist())))
        raise self.mismatch(numbers)

    def agrees(self, memory: memoryview) -> bool:
        """Returns whether these are numbers of this kind and size, one after the other."""
        kind = ("f" if c in "fd" else "i" if c in "bhilq" else "u" for c in (memory.format, self.code) if len(c) == 1)
        same = len(set(kind)) == 1 and len(memory.format) == 1 and memory.format in "bhilqBHILQfd"
        return same and memory.itemsize == array(self.code).itemsize and memory.contiguous


@dataclass
class Field:
    """A field of a record."""

    name: str
    attribute: str
    doc: str
    form: Form
    default: Callable[[], Any]


class RecordForm(Form):
    """A dataclass."""

    def __init__(self, cls: type[Any]) -> None:
        self.cls = cls
        self.name = cls.__dict__.get("__message__", "")
        self.fields: list[Field] = []

    def __str__(self) -> str:
        return self.name or self.cls.__name__

    def complete(self) -> None:
        """Adds the fields, which may refer to this type."""
        hints = hints_of(self.cls, self.cls.__name__)
        for field in dataclasses.fields(self.cls):
            place = f"field `{field.name}` of `{self.cls.__name__}`"
            form = form_of(hints[field.name], place)
            name = field.name[:-1] if keyword.iskeyword(field.name[:-1]) else field.name
            default: Callable[[], Any] = form.zero
            if field.default is not dataclasses.MISSING:
                default = (lambda value: lambda: value)(field.default)
            elif field.default_factory is not dataclasses.MISSING:
                default = field.default_factory
            self.fields.append(Field(name, field.name, doc_of(hints[field.name]), form, default))
        self.by_name = {field.name: field for field in self.fields}
        self.shape = {"record": [self.outline(field) for field in self.fields]}

    def outline(self, field: Field) -> dict[str, Any]:
        outline = {"name": field.name, "doc": field.doc, "schema": field.form.schema}
        place = f"the default of field `{field.name}` of `{self.cls.__name__}`"
        try:
            initial, zero = field.form.dump(field.default()), field.form.dump(field.form.zero())
        except MismatchError as error:
            raise DeclarationError(f"{place} {error}") from None
        if cbor.dumps(initial) != cbor.dumps(zero):
            outline["initial"] = initial
        return outline

    def zero(self) -> Any:
        return self.load({})

    def dump(self, value: Any) -> dict[str, Any]:
        if isinstance(value, self.cls):
            return {field.name: _in_field(field, field.form.dump, getattr(value, field.attribute)) for field in self.fields}
        if isinstance(value, collections.abc.Mapping):
            return self.dump(self.load(value))
        raise self.mismatch(value)

    def load(self, data: Any) -> Any:
        if isinstance(data, self.cls):
            return data
        if not isinstance(data, collections.abc.Mapping):
            raise self.mismatch(data)
        values = {}
        for field in self.fields:
            if field.name in data:
                values[field.attribute] = _in_field(field, field.form.load, data[field.name])
            else:
                values[field.attribute] = field.default()
        if len(data) > len(values) or not self.by_name.keys() >= data.keys():
            unknown = next(name for name in data if name not in self.by_name)
            known = ", ".join(self.by_name) or "none"
            raise MismatchError(f"has no field `{unknown}`; the fields of {self} are {known}")
        return self.cls(**values)


def _in_field(field: Field, convert: Callable[[Any], Any], value: Any) -> Any:
    try:
        return convert(value)
    except MismatchError as error:
        raise within(f".{field.name}", error) from None


def within(place: str, error: MismatchError) -> MismatchError:
    """Returns the error with the place of the value in front of its own."""
    path, text = getattr(error, "path", ""), getattr(error, "reason", str(error))
    path = place + path
    outer = MismatchError(f"field `{path.lstrip('.')}` {text}")
    setattr(outer, "path", path)
    setattr(outer, "reason", text)
    return outer


class Nothing(Form):
    """The message without fields, which is `None` in Python."""

    name = "std_msgs/Empty"
    shape: Any = {"record": []}

    def dump(self, value: Any) -> dict[str, Any]:
        if value is None:
            return {}
        raise self.mismatch(value)

    def load(self, data: Any) -> None:
        return None


_records: dict[type[Any], RecordForm] = {}


def form_of(annotation: Any, place: str = "the type") -> Form:
    """Returns the form of an annotation.

    Raises:
        DeclarationError: there is no such type in messages; with the place.
    """
    metadata: tuple[Any, ...] = ()
    if typing.get_origin(annotation) is Annotated:
        annotation, *rest = typing.get_args(annotation)
        metadata = tuple(rest)
    count = next((item.count for item in metadata if isinstance(item, Length)), None)
    for item in metadata:
        if isinstance(item, Scalar):
            return Whole(item.word) if item.word[0] in "iu" else Real(item.word)
    if isinstance(annotation, str):
        return Named(annotation)
    origin, arguments = typing.get_origin(annotation), typing.get_args(annotation)
    alias = getattr(origin or annotation, "__value__", None)
    if alias is not None and not isinstance(annotation, type):  # `type Alias = …`, which NDArray is in new versions of numpy
        return form_of(alias[arguments] if arguments else alias, place)
    if origin in (Union, types.UnionType):
        some = [argument for argument in arguments if argument is not type(None)]
        if len(some) == 1 and len(arguments) == 2:
            return Optional(form_of(some[0], place))
    elif origin is tuple and len(arguments) == 2 and arguments[1] is ...:
        return _list_of(form_of(arguments[0], place), count, tuple)
    elif origin is tuple and len(set(arguments)) == 1:
        return _list_of(form_of(arguments[0], place), len(arguments), tuple)
    elif origin in (list, collections.abc.Sequence):
        return _list_of(form_of(arguments[0], place), count, list)
    elif origin is Numbers:
        element = form_of(arguments[0], place)
        if isinstance(element, (Whole, Real)):
            return NumberList(element, count, lambda view: view)
    elif getattr(origin, "__name__", "") == "ndarray":
        word = _NUMPY.get(getattr(typing.get_args(arguments[1])[0], "__name__", ""))
        if word is not None:
            element = Whole(word) if word[0] in "iu" else Real(word)
            return NumberList(element, count, _as_array)
    elif (form := _class_form(annotation, count)) is not None:
        return form
    raise DeclarationError(f"{place}: {_shown(annotation)} has no form in a message; `asmotion.types` lists those that have")


def _class_form(cls: Any, count: int | None) -> Form | None:
    if cls is None or cls is type(None):
        return Nothing()
    if cls is Any or cls is object or cls is Record:
        return Form()
    if cls is bytes:
        return NumberList(Whole("u8"), count, lambda view: bytes(view.memory))
    plain: dict[Any, Form] = {bool: Boolean(), int: Whole("i64"), float: Real("f64"), str: Text()}
    if cls in plain:
        return plain[cls]
    if isinstance(cls, type) and issubclass(cls, enum.Enum):
        return Choice(cls)
    if isinstance(cls, type) and dataclasses.is_dataclass(cls):
        if cls not in _records:
            _records[cls] = RecordForm(cls)
            try:
                _records[cls].complete()
            except BaseException:
                del _records[cls]
                raise
        return _records[cls]
    return None


def _list_of(element: Form, count: int | None, make: Callable[[Any], Any]) -> Form:
    if isinstance(element, (Whole, Real)):
        return NumberList(element, count, (lambda view: view.tolist()) if make is list else make)
    return Elements(element, count, make)


def _as_array(view: NumberView) -> Any:
    import numpy

    return numpy.frombuffer(view.memory, dtype=view.memory.format)


def _shown(annotation: Any) -> str:
    return f"`{annotation.__name__}`" if isinstance(annotation, type) else f"`{annotation}`"


def doc_of(annotation: Any) -> str:
    """Returns the description in an annotation."""
    texts = (item for item in getattr(annotation, "__metadata__", ()) if isinstance(item, str))
    return next(texts, "")


def hints_of(owner: Any, name: str) -> dict[str, Any]:
    """Returns the annotations of a class or function with their metadata.

    Raises:
        DeclarationError: an annotation names a type that does not exist.
    """
    try:
        return typing.get_type_hints(owner, include_extras=True)
    except NameError as error:
        raise DeclarationError(f"`{name}`: {error}; its annotations must name types of the module") from None


def _plain(value: Any) -> Any:
    """Returns any value as data."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return form_of(type(value)).dump(value)
    if isinstance(value, enum.Enum):
        return value.value
    if isinstance(value, collections.abc.Mapping):
        return {key: _plain(element) for key, element in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(element) for element in value]
    return value


def _record(data: Any) -> Any:
    if isinstance(data, dict):
        return Record({key: _record(element) for key, element in data.items()})
    if isinstance(data, list):
        return [_record(element) for element in data]
    return data
