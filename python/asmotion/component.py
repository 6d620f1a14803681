"""Components: ports, services, references and properties as attributes of a class, and the hooks of the life cycle."""

from __future__ import annotations

import asyncio
import inspect
import typing
from collections.abc import Callable, Generator, Mapping, Sequence
from typing import Any, Generic, TypeVar, overload

from asmotion import types
from asmotion.loop import CycleLoop
from asmotion.errors import CallError, DeclarationError, Fault, MismatchError, UsageError
from asmotion.types import Form, Record, form_of

T = TypeVar("T")
Q = TypeVar("Q")
R = TypeVar("R")
I = TypeVar("I", bound="Interface")  # noqa: E741
F = TypeVar("F", bound=Callable[..., Any])


class Declared:
    """A declaration in the body of a component class."""

    kind = ""

    def __init__(self, doc: str, name: str | None) -> None:
        self.doc = doc
        self.name = name or ""
        self.attribute = ""
        self.owner = ""

    def __set_name__(self, owner: type, attribute: str) -> None:
        self.attribute = attribute
        self.name = self.name or attribute
        self.owner = owner.__name__

    @property
    def place(self) -> str:
        return f"{self.kind} `{self.owner}.{self.attribute}`"

    def __set__(self, instance: Component, value: Any) -> None:
        raise UsageError(f"{self.place} cannot be assigned; {self.way_out}")

    way_out = ""


class _Port(Declared):
    def __init__(self, type: Any, doc: str, name: str | None) -> None:
        super().__init__(doc, name)
        self.type = type

    def form(self) -> Form:
        form = form_of(self.type, self.place)
        if not form.name:
            shown = getattr(self.type, "__name__", self.type)
            raise DeclarationError(
                f'{self.place}: {shown} is no message type; declare it with `@asmotion.message("package/{shown}")`'
            )
        return form


class In(_Port, Generic[T]):
    """Declares an input port. The type is a message class, or the name of a type that the engine knows.

    The samples of a `command` are discarded if they arrive before the component starts, so that no old command is carried out.
    """

    kind = "input"
    way_out = "it is read with `.read()`"

    @overload
    def __init__(self: In[Record], type: str, doc: str = "", *, command: bool = False, name: str | None = None) -> None: ...

    @overload
    def __init__(self, type: type[T], doc: str = "", *, command: bool = False, name: str | None = None) -> None: ...

    def __init__(self, type: Any, doc: str = "", *, command: bool = False, name: str | None = None) -> None:
        super().__init__(type, doc, name)
        self.command = command

    @overload
    def __get__(self, instance: None, owner: type) -> In[T]: ...

    @overload
    def __get__(self, instance: Component, owner: type) -> Input[T]: ...

    def __get__(self, instance: Component | None, owner: type) -> Any:
        return self if instance is None else instance._engine.inputs[self.name]


class Out(_Port, Generic[T]):
    """Declares an output port. The engine writes the sample `safe` after the last cycle."""

    kind = "output"
    way_out = "a sample is written with `.write(sample)`"

    @overload
    def __init__(self: Out[Record], type: str, doc: str = "", *, safe: Any = None, name: str | None = None) -> None: ...

    @overload
    def __init__(self, type: type[T], doc: str = "", *, safe: T | None = None, name: str | None = None) -> None: ...

    def __init__(self, type: Any, doc: str = "", *, safe: Any = None, name: str | None = None) -> None:
        super().__init__(type, doc, name)
        self.safe = safe

    @overload
    def __get__(self, instance: None, owner: type) -> Out[T]: ...

    @overload
    def __get__(self, instance: Component, owner: type) -> Output[T]: ...

    def __get__(self, instance: Component | None, owner: type) -> Any:
        return self if instance is None else instance._engine.outputs[self.name]


class Property(Declared, Generic[T]):
    """Declares a property, whose value is constant during a cycle.

    Args:
        default: value unless the composite sets one; its type is that of the property.
        unit: for example `m/s`.
        range: least and greatest value, inclusive.
        choices: all allowed values.
        type: another type than that of the default, for example `asmotion.u8`.
    """

    kind = "property"
    way_out = "the composite and its operators set it"

    def __init__(
        self,
        default: T,
        doc: str = "",
        *,
        unit: str = "",
        range: tuple[T, T] | None = None,
        choices: Sequence[T] = (),
        type: Any = None,
        name: str | None = None,
    ) -> None:
        super().__init__(doc, name)
        self.default = default
        self.unit = unit
        self.range = range
        self.choices = choices
        self.type = type

    @overload
    def __get__(self, instance: None, owner: type) -> Property[T]: ...

    @overload
    def __get__(self, instance: Component, owner: type) -> T: ...

    def __get__(self, instance: Component | None, owner: type) -> Any:
        return self if instance is None else instance._engine.properties[self.name]

    def form(self) -> Form:
        if self.type is not None:
            return form_of(self.type, self.place)
        if isinstance(self.default, (list, tuple)):
            kinds = {type(element) for element in self.default} or {float}
            kind = float if kinds == {int, float} else kinds.pop() if len(kinds) == 1 else None
            if kind is None:
                raise DeclarationError(f"{self.place}: the default has elements of several types; pass `type=list[…]`")
            return form_of(list[kind], self.place)  # type: ignore[valid-type]
        return form_of(type(self.default), self.place)

    def check(self, value: Any) -> None:
        """Raises MismatchError if the value is outside of the range or no choice."""
        unit = f" {self.unit}" if self.unit else ""
        if self.range is not None and not self.range[0] <= value <= self.range[1]:
            raise MismatchError(f"must be between {self.range[0]} and {self.range[1]}{unit}, not {value}")
        if self.choices and value not in self.choices:
            raise MismatchError(f"must be one of {', '.join(map(repr, self.choices))}, not {value!r}")


class Operation(Generic[Q, R]):
    """Declares an operation in the body of an interface, with the types of its request and its response."""

    def __init__(self, request: type[Q], response: type[R], doc: str = "", *, name: str | None = None) -> None:
        self.request = request
        self.response = response
        self.doc = doc
        self.name = name or ""

    def __set_name__(self, owner: type, attribute: str) -> None:
        self.name = self.name or attribute

    @overload
    def __get__(self, instance: None, owner: type) -> Operation[Q, R]: ...

    @overload
    def __get__(self, instance: Interface, owner: type) -> BoundOperation[Q, R]: ...

    def __get__(self, instance: Interface | None, owner: type) -> Any:
        return self if instance is None else instance._operations[self.name]


class Interface:
    """A set of operations under a name: the type of a reference or of a service.

        class Planning(asmotion.Interface, name="nav/PlanService"):
            plan = asmotion.Operation(PlanRequest, Path)
    """

    _interface_name = ""
    _operations: dict[str, BoundOperation[Any, Any]]

    def __init_subclass__(cls, *, name: str = "") -> None:
        if not name and not cls._interface_name:
            raise DeclarationError(f'interface `{cls.__name__}` has no name: `class {cls.__name__}(Interface, name="…/…")`')
        cls._interface_name = name or cls._interface_name

    @classmethod
    def declared(cls) -> dict[str, Operation[Any, Any]]:
        """Returns the operations by name, in order of declaration."""
        attributes = [value for owner in reversed(cls.__mro__) for value in vars(owner).values()]
        return {item.name: item for item in attributes if isinstance(item, Operation)}


class Reference(Declared, Generic[I]):
    """Declares a reference: operations of other components that this one calls.

    Either `Reference(Planning, "plans paths")`, or with the operations in place:
    `Reference("nav/PlanService", "plans paths", plan=Operation(PlanRequest, Path))`.
    """

    kind = "reference"
    way_out = "an operation is called with `self.reference.operation(request)`"

    @overload
    def __init__(
        self: Reference[Any],
        interface: str,
        doc: str = "",
        *,
        optional: bool = False,
        name: str | None = None,
        **operations: Operation[Any, Any],
    ) -> None: ...

    @overload
    def __init__(self, interface: type[I], doc: str = "", *, optional: bool = False, name: str | None = None) -> None: ...

    def __init__(
        self,
        interface: Any,
        doc: str = "",
        *,
        optional: bool = False,
        name: str | None = None,
        **operations: Operation[Any, Any],
    ) -> None:
        super().__init__(doc, name)
        if isinstance(interface, str):
            for key, operation in operations.items():
                operation.__set_name__(type(self), key)
            interface = type("Interface_", (Interface,), dict(operations), name=interface)
        self.interface: type[Interface] = interface
        self.optional = optional

    @overload
    def __get__(self, instance: None, owner: type) -> Reference[I]: ...

    @overload
    def __get__(self, instance: Component, owner: type) -> I: ...

    def __get__(self, instance: Component | None, owner: type) -> Any:
        return self if instance is None else instance._engine.references[self.name]


class ServedOperation:
    """A method that serves an operation."""

    def __init__(self, method: Callable[..., Any], name: str, while_stopped: bool) -> None:
        self.method = method
        self.name = name
        self.while_stopped = while_stopped
        self.request: Form
        self.response: Form
        self.has_argument = True


class Service(Declared):
    """Declares a service, whose operations are methods:

        grip = asmotion.Service("acme/Grip", "moves the fingers")

        @grip.operation
        def close(self, request: Close) -> Closed: ...

    The interface is a name, or an `Interface` class, with which the methods must agree. A method returns the response in
    the same cycle, returns a `Pending` reply, or is a coroutine.
    """

    kind = "service"
    way_out = "its operations are methods with the decorator `.operation`"

    def __init__(self, interface: str | type[Interface], doc: str = "", *, name: str | None = None) -> None:
        super().__init__(doc, name)
        self.interface = interface
        self.served: list[ServedOperation] = []

    def __get__(self, instance: Component | None, owner: type) -> Service:
        return self

    @overload
    def operation(self, method: F) -> F: ...

    @overload
    def operation(self, *, name: str | None = None, while_stopped: bool = False) -> Callable[[F], F]: ...

    def operation(self, method: Any = None, *, name: str | None = None, while_stopped: bool = False) -> Any:
        """Serves an operation by the decorated method. Its name is that of the method, unless `name` is given.

        With `while_stopped` it is also served while the component is stopped.
        """

        def decorate(method: F) -> F:
            self.served.append(ServedOperation(method, name or method.__name__, while_stopped))
            return method

        return decorate if method is None else decorate(method)

    @property
    def interface_name(self) -> str:
        return self.interface if isinstance(self.interface, str) else self.interface._interface_name

    def complete(self) -> None:
        """Determines the types of the operations.

        Raises:
            DeclarationError: a type is missing or differs from the interface.
        """
        if not self.served:
            raise DeclarationError(f"{self.place} has no operation; decorate a method with `@{self.attribute}.operation`")
        for served in self.served:
            self.complete_one(served)
        if not isinstance(self.interface, str):
            missing = self.interface.declared().keys() - {served.name for served in self.served}
            if missing:
                raise DeclarationError(f"{self.place} does not serve `{sorted(missing)[0]}` of `{self.interface_name}`")

    def complete_one(self, served: ServedOperation) -> None:
        place = f"operation `{self.owner}.{served.method.__name__}`"
        hints = types.hints_of(served.method, f"{self.owner}.{served.method.__name__}")
        parameters = list(inspect.signature(served.method).parameters)[1:]
        response = hints.get("return", inspect.Signature.empty)
        if len(parameters) > 1 or response is inspect.Signature.empty:
            raise DeclarationError(f"{place} must have the form `def name(self, request: Request) -> Response`")
        if parameters and parameters[0] not in hints:
            raise DeclarationError(f"{place}: the parameter `{parameters[0]}` has no type; write `{parameters[0]}: Request`")
        if typing.get_origin(response) is Pending:
            response = typing.get_args(response)[0]
        served.has_argument = bool(parameters)
        served.request = form_of(hints[parameters[0]] if parameters else None, place)
        served.response = form_of(response, place)
        if isinstance(self.interface, str):
            return
        known = self.interface.declared()
        if served.name not in known:
            names = ", ".join(known)
            raise DeclarationError(f"{place} is none of `{self.interface_name}`, which has {names}")
        operation = known[served.name]
        for what, form, expected in (
            ("request", served.request, operation.request),
            ("response", served.response, operation.response),
        ):
            if form.schema != form_of(expected, place).schema:
                raise DeclarationError(f"{place}: its {what} is {form}, and {form_of(expected)} in `{self.interface_name}`")


class Input(Generic[T]):
    """An input port in a cycle."""

    def __init__(self, declared: In[T], engine: Engine) -> None:
        self._engine = engine
        self.name = declared.name
        self.form = declared.form()
        self._newest: T | None = None
        self._all: list[T] = []
        self.written_at: int | None = None
        """Time of the writer's cycle in which the newest sample was written, ns."""
        self.is_stale = False
        """Whether the newest sample is older than the connection allows."""
        self.lost = 0
        """Number of messages lost on the way, since the start."""
        self._waiting: list[asyncio.Future[T]] = []

    def read(self) -> T | None:
        """Returns the newest sample; `None` before the first."""
        return self._newest

    def all(self) -> list[T]:
        """Returns the samples that have arrived since the last cycle, in order of arrival."""
        return list(self._all)

    @property
    def is_new(self) -> bool:
        """Whether a sample has arrived since the last cycle."""
        return bool(self._all)

    async def next(self) -> T:
        """Waits for the next sample."""
        future: asyncio.Future[T] = self._engine.loop.create_future()
        self._waiting.append(future)
        return await future


class Output(Generic[T]):
    """An output port in a cycle."""

    def __init__(self, declared: Out[T], engine: Engine) -> None:
        self._engine = engine
        self.name = declared.name
        self.place = declared.place
        self.form = declared.form()

    def write(self, sample: T) -> None:
        """Writes a sample, which is sent if the cycle succeeds.

        Raises:
            MismatchError: the sample does not fit the type of the port.
            UsageError: no cycle is under way, or the component is stopped.
        """
        effects = self._engine.effects(f"{self.place} is written")
        if not self._engine.cycle.is_running:
            raise UsageError(f"{self.place} is written while the component is stopped, when it commands nothing")
        try:
            effects.outputs.append((self.name, self.form.dump(sample)))
        except MismatchError as error:
            raise MismatchError(f"{self.place}: the sample's {error}" if _has_path(error) else f"{self.place}: the sample {error}") from None


def _has_path(error: MismatchError) -> bool:
    return hasattr(error, "path")


class Call(Generic[R]):
    """A call that has been made. `await` it in a coroutine, or look at `is_done` in later cycles."""

    def __init__(self, engine: Engine, id: int, operation: BoundOperation[Any, R]) -> None:
        self._engine = engine
        self.id = id
        self._operation = operation
        self._future: asyncio.Future[R] | None = None
        self.is_done = False
        self._result: R | None = None
        self.error: CallError | None = None
        """The reason that it ended without a result; `None` if it is under way or has a result."""

    def result(self) -> R:
        """Returns the result.

        Raises:
            CallError: it ended without a result.
            UsageError: it is under way.
        """
        if not self.is_done:
            raise UsageError(f"the call of {self._operation.place} is under way; its reply arrives in a later cycle (`is_done`)")
        if self.error is not None:
            raise self.error
        return self._result  # type: ignore[return-value]

    def cancel(self) -> None:
        """Cancels the call, which then ends with the error `cancelled`."""
        if not self.is_done:
            self._engine.effects(f"a call of {self._operation.place} is cancelled").cancel.append(self.id)

    def finish(self, result: R | None, error: CallError | None) -> None:
        """Ends the call. For drivers of components."""
        self.is_done, self._result, self.error = True, result, error
        if self._future is not None and not self._future.done():
            if error is None:
                self._future.set_result(result)  # type: ignore[arg-type]
            else:
                self._future.set_exception(error)

    def __await__(self) -> Generator[Any, None, R]:
        if self.is_done:
            return self.result()
        if self._future is None:
            self._future = self._engine.loop.create_future()
        try:
            return (yield from self._future.__await__())
        except asyncio.CancelledError:
            if self._engine.in_cycle:
                self.cancel()
            raise


class BoundOperation(Generic[Q, R]):
    """An operation of a reference, as a function."""

    def __init__(self, engine: Engine, reference: Reference[Any], operation: Operation[Q, R]) -> None:
        self._engine = engine
        self.reference = reference.name
        self.name = operation.name
        self.place = f"`{reference.owner}.{reference.attribute}.{operation.name}`"
        self.request = form_of(operation.request, self.place)
        self.response = form_of(operation.response, self.place)

    def __call__(self, request: Q | None = None) -> Call[R]:
        """Calls the operation; without a request, with all fields at their defaults. Sent if the cycle succeeds.

        Raises:
            MismatchError: the request does not fit its type.
            UsageError: no cycle is under way.
        """
        call: Call[R] = Call(self._engine, self._engine.next_call(), self)
        self._make(call.id, request, False)
        self._engine.calls[call.id] = call
        return call

    def one_way(self, request: Q | None = None) -> None:
        """Calls the operation without a reply.

        Raises:
            MismatchError: the request does not fit its type.
            UsageError: no cycle is under way.
        """
        self._make(self._engine.next_call(), request, True)

    def _make(self, id: int, request: Q | None, one_way: bool) -> None:
        effects = self._engine.effects(f"{self.place} is called")
        if not self._engine.cycle.is_running:
            raise UsageError(f"{self.place} is called while the component is stopped, when it calls nothing")
        try:
            argument = self.request.dump(self.request.zero() if request is None else request)
        except MismatchError as error:
            raise MismatchError(f"{self.place}: the request {error}") from None
        call = {"call": id, "reference": self.reference, "operation": self.name, "argument": argument}
        if one_way:
            call["one_way"] = True
        effects.calls.append(call)


class Pending(Generic[R]):
    """A reply that is given in a later cycle: an operation returns it, and keeps it to call `reply` or `refuse`."""

    def __init__(self) -> None:
        self._engine: Engine | None = None
        self._served: ServedOperation | None = None
        self.id = -1
        self.caller = ""
        """Name of the calling component."""
        self.deadline: int | None = None
        """Time at which the caller stops waiting, ns; `None` for a one-way request."""
        self.is_cancelled = False
        """Whether the caller no longer waits."""
        self.is_done = False
        self._early: tuple[Any, Fault | None] | None = None

    def reply(self, response: R) -> None:
        """Replies with a response. Does nothing if the caller no longer waits."""
        self._end(response, None)

    def refuse(self, code: str, text: str = "") -> None:
        """Replies with a fault. Does nothing if the caller no longer waits."""
        self._end(None, Fault(code, text))

    def _end(self, response: Any, fault: Fault | None) -> None:
        if self.is_done:
            raise UsageError("the reply has already been given")
        if self._engine is None or self._served is None:
            self._early = (response, fault)
            return
        self.is_done = True
        self._engine.pending.pop(self.id, None)
        if not self.is_cancelled and self.deadline is not None:
            self._engine.reply(self._served, self.id, response, fault)


class Cycle:
    """One cycle: its time and number, and what the component asks of the engine."""

    def __init__(self, now: int, number: int, is_running: bool = True) -> None:
        self.now = now
        """Time, ns of the engine's clock; constant during the cycle."""
        self.number = number
        """Number of the cycle since the start of the program, from 1."""
        self.is_running = is_running
        """`False` while a stopped component serves requests."""
        self._effects = Effects()

    @property
    def seconds(self) -> float:
        """Time, s."""
        return self.now * 1e-9

    def set_period(self, seconds: float) -> None:
        """Changes the period of the component from the next cycle on; 0 makes it event-driven."""
        self._effects.options["period"] = round(seconds * 1e9)

    def set_duration(self, seconds: float) -> None:
        """Sets the duration of this cycle in simulated time."""
        self._effects.options["duration"] = round(seconds * 1e9)

    def request_cycle(self) -> None:
        """Requests another cycle at once, for event-driven components."""
        self._effects.options["again"] = True

    def request_cycle_at(self, seconds: float) -> None:
        """Requests a cycle at a time (s, as `seconds`), for event-driven components; at once if it has passed.

        The earliest of several requests counts. A request ends with the next cycle, whatever triggers it, so a component that
        still waits requests a cycle again.
        """
        at = round(min(max(seconds, 0.0), 9e9) * 1e9)  # times have 63 bits
        self._effects.options["at"] = min(at, self._effects.options.get("at", at))

    def report(self, kind: str, value: Any) -> None:
        """Reports data to observers. The kind `notice` with a text is for people."""
        self._effects.reports.append((kind, Form().dump(value)))

    def error(self, code: str, text: str = "") -> None:
        """Moves the component to the state RunTimeError after this cycle, in which `recover` takes the place of `update`."""
        self._effects.options["error"] = {"code": code, "text": text}


class Effects:
    """What a cycle sends if it succeeds."""

    def __init__(self) -> None:
        self.outputs: list[tuple[str, Any]] = []
        self.calls: list[dict[str, Any]] = []
        self.cancel: list[int] = []
        self.replies: list[dict[str, Any]] = []
        self.reports: list[tuple[str, Any]] = []
        self.options: dict[str, Any] = {}

    def data(self) -> dict[str, Any]:
        lists = {
            "outputs": self.outputs,
            "calls": self.calls,
            "cancel": self.cancel,
            "replies": self.replies,
            "reports": self.reports,
        }
        return {"type": "done", **{key: value for key, value in lists.items() if value}, **self.options}


class Component:
    """Base of components. The hooks are those of Orocos RTT; all may be left out.

    An object is created when the component is configured, with the values of its properties at hand, so `__init__` may
    read them; it ends when the component is cleaned up.
    """

    _engine: Engine
    _declaration: Declaration | None = None

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls._declaration = None

    def __new__(cls, *arguments: Any, **options: Any) -> Any:
        instance = super().__new__(cls)
        instance._engine = Engine.building or Engine(cls)
        return instance

    @property
    def cycle(self) -> Cycle:
        """The cycle under way, for operations and tasks.

        Raises:
            UsageError: no cycle is under way.
        """
        self._engine.effects("`cycle` is used")
        return self._engine.cycle

    @classmethod
    def declaration(cls) -> Declaration:
        """Returns ports, services, references and properties.

        Raises:
            DeclarationError: they contradict each other, or have a type that messages cannot have.
        """
        if cls._declaration is None:
            cls._declaration = Declaration(cls)
        return cls._declaration

    def configure(self) -> Any:
        """Prepares the component. It stays unconfigured if this raises an exception."""

    def start(self) -> Any:
        """Called before the first cycle. The component stays stopped if this raises an exception."""

    def update(self, cycle: Cycle) -> Any:
        """Runs one cycle. Nothing is sent if this raises an exception.

        As a coroutine it may extend over several cycles; the next one begins in the cycle after its end.
        """

    def stop(self, cycle: Cycle) -> Any:
        """Runs the last cycle: the place for the last samples, and for replies to waiting requests."""

    def cleanup(self) -> Any:
        """Releases what `configure` acquired."""

    def exception(self) -> Any:
        """Called after a fault, when the component has been stopped and cleaned up."""

    def recover(self, cycle: Cycle) -> Any:
        """Runs the cycle in the state RunTimeError, in place of `update`. Returning means that it has recovered."""

    def inspect(self) -> Mapping[str, Any]:
        """Describes the internal state to observers, by name."""
        return {}

    def wake(self) -> None:
        """Requests a cycle, from any thread. In virtual time it has no effect."""
        self._engine.wake()


class Declaration:
    """Ports, services, references and properties of a component class."""

    def __init__(self, cls: type[Component]) -> None:
        items: dict[str, Declared] = {}
        for owner in reversed(cls.__mro__):
            for attribute, value in vars(owner).items():
                items.pop(attribute, None)
                if isinstance(value, Declared):
                    items[attribute] = value
        self.inputs = {item.name: item for item in items.values() if isinstance(item, In)}
        self.outputs = {item.name: item for item in items.values() if isinstance(item, Out)}
        self.services = {item.name: item for item in items.values() if isinstance(item, Service)}
        self.references = {item.name: item for item in items.values() if isinstance(item, Reference)}
        self.properties = {item.name: item for item in items.values() if isinstance(item, Property)}
        found = len(self.inputs) + len(self.outputs) + len(self.services) + len(self.references) + len(self.properties)
        if found < len(items):
            names = [(item.kind, item.name) for item in items.values()]
            twice = next(name for name in names if names.count(name) > 1)
            raise DeclarationError(f"`{cls.__name__}` declares the {twice[0]} `{twice[1]}` twice")
        for service in self.services.values():
            service.complete()
        self.doc = inspect.cleandoc(cls.__doc__ or "")
        self.implementation = f"{cls.__module__}.{cls.__qualname__}".removeprefix("__main__.")

    def data(self) -> dict[str, Any]:
        """Returns the declaration as the message `declare`."""
        return {
            "type": "declare",
            "protocol": 1,
            "implementation": self.implementation,
            "inputs": [_port(item) | _command(item) for item in self.inputs.values()],
            "outputs": [_port(item) | _safe(item) for item in self.outputs.values()],
            "services": [_service(item) for item in self.services.values()],
            "references": [_reference(item) for item in self.references.values()],
            "properties": [_property(item) for item in self.properties.values()],
        }


def _port(item: _Port) -> dict[str, Any]:
    return {"name": item.name, "schema": item.form().schema, "doc": item.doc}


def _command(item: In[Any]) -> dict[str, Any]:
    return {"command": True} if item.command else {}


def _safe(item: Out[Any]) -> dict[str, Any]:
    if item.safe is None:
        return {}
    try:
        return {"safe": item.form().dump(item.safe)}
    except MismatchError as error:
        raise DeclarationError(f"{item.place}: the safe sample {error}") from None


def _service(item: Service) -> dict[str, Any]:
    operations = []
    for served in item.served:
        operation: dict[str, Any] = {"name": served.name, "request": served.request.schema, "response": served.response.schema}
        if served.while_stopped:
            operation["while_stopped"] = True
        operations.append(operation)
    return {"name": item.name, "interface": item.interface_name, "doc": item.doc, "operations": operations}


def _reference(item: Reference[Any]) -> dict[str, Any]:
    operations = [
        {
            "name": operation.name,
            "request": form_of(operation.request, item.place).schema,
            "response": form_of(operation.response, item.place).schema,
        }
        for operation in item.interface.declared().values()
    ]
    if not operations:
        raise DeclarationError(f"{item.place} has no operation; pass `name=asmotion.Operation(Request, Response)`")
    data = {"name": item.name, "interface": item.interface._interface_name, "doc": item.doc, "operations": operations}
    return data | {"optional": True} if item.optional else data


def _property(item: Property[Any]) -> dict[str, Any]:
    form = item.form()
    try:
        item.check(item.default)
        data = {"name": item.name, "doc": item.doc, "schema": form.schema, "default": form.dump(item.default)}
        if item.range is not None:
            data["range"] = [form.dump(limit) for limit in item.range]
        if item.choices:
            data["choices"] = [form.dump(choice) for choice in item.choices]
    except MismatchError as error:
        raise DeclarationError(f"{item.place}: the default, range and choices: {error}") from None
    if item.unit:
        data["unit"] = item.unit
    return data


class Engine:
    """The engine's side of one component in this program: inputs, outputs, calls, replies and properties."""

    building: Engine | None = None

    def __init__(self, cls: type[Component], wake: Callable[[], None] = lambda: None) -> None:
        declaration = cls.declaration()
        self.wake = wake
        self.loop = CycleLoop(wake)  # type: ignore[abstract]
        self.cycle = Cycle(0, 0)
        self.in_cycle = False
        self.forms = {name: item.form() for name, item in declaration.properties.items()}
        self.properties = {name: item.default for name, item in declaration.properties.items()}
        self.inputs: dict[str, Input[Any]] = {name: Input(item, self) for name, item in declaration.inputs.items()}
        self.outputs: dict[str, Output[Any]] = {name: Output(item, self) for name, item in declaration.outputs.items()}
        self.references = {name: self._bound(item) for name, item in declaration.references.items()}
        self.calls: dict[int, Call[Any]] = {}
        self.call_count = 0
        self.pending: dict[int, Pending[Any]] = {}
        self.tasks: dict[int, asyncio.Task[Any]] = {}

    def _bound(self, item: Reference[Any]) -> Interface:
        bound = item.interface()
        bound._operations = {
            name: BoundOperation(self, item, operation) for name, operation in item.interface.declared().items()
        }
        return bound

    def effects(self, action: str) -> Effects:
        """Returns the effects of the cycle under way.

        Raises:
            UsageError: no cycle is under way.
        """
        if not self.in_cycle:
            raise UsageError(f"{action} outside of a cycle; do it in `update`, in an operation or in `stop`")
        return self.cycle._effects

    def next_call(self) -> int:
        self.call_count += 1
        return self.call_count

    def reply(self, served: ServedOperation, id: int, response: Any, fault: Fault | None) -> None:
        """Replies to a request in the cycle under way."""
        replies = self.effects(f"the operation `{served.name}` is answered").replies
        if fault is not None:
            replies.append({"id": id, "fault": {"code": fault.code, "text": fault.text}})
            return
        try:
            replies.append({"id": id, "result": served.response.dump(response)})
        except MismatchError as error:
            raise MismatchError(f"operation `{served.method.__qualname__}`: the response {error}") from None



