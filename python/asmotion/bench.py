"""A test bench: drives one component in virtual time, through the same requests as the engine."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from asmotion import cbor, recording
from asmotion.component import BoundOperation, Component
from asmotion.errors import CallError, Fault, MismatchError
from asmotion.program import Program
from asmotion.types import within

C = TypeVar("C", bound=Component)


class Request:
    """A request to the component under test. It ends in a cycle in which the component replies."""

    def __init__(self, id: int, load: Callable[[Any], Any]) -> None:
        self.id = id
        self._load = load
        self.is_done = False
        self.fault: Fault | None = None
        """The fault that is the reply, if it is one."""
        self._result: Any = None

    def result(self) -> Any:
        """Returns the response.

        Raises:
            Fault: the component refused the request.
            LookupError: it has not replied.
        """
        if self.fault is not None:
            raise self.fault
        if not self.is_done:
            raise LookupError("the component has not replied; run another cycle")
        return self._result


class MadeCall:
    """A call that the component under test has made. `reply` and `fail` end it in the next cycle."""

    def __init__(self, bench: Bench[Any], data: dict[str, Any], operation: BoundOperation[Any, Any]) -> None:
        self._bench = bench
        self._operation = operation
        self.id: int = data["call"]
        self.reference: str = data["reference"]
        self.operation: str = data["operation"]
        self.argument: Any = operation.request.load(data["argument"])
        self.is_one_way: bool = data.get("one_way", False)
        self.is_cancelled = False

    def reply(self, result: Any = None) -> None:
        """Ends the call with a result; without one, with all fields at their defaults.

        Raises:
            MismatchError: the result does not fit its type.
        """
        form = self._operation.response
        self._end({"result": form.dump(form.zero() if result is None else result)})

    def fail(self, kind: str, code: str = "", text: str = "") -> None:
        """Ends the call without a result: `timeout`, `unavailable`, `stopped`, `cancelled`, or `fault` with a code."""
        error = CallError(kind, code, text)
        self._end({"error": {"kind": kind, "code": error.code, "text": error.text}})

    def _end(self, end: dict[str, Any]) -> None:
        if self.is_one_way:
            raise ValueError("a one-way call has no reply")
        self._bench._ends.append({"call": self.id, **end})


class Outcome:
    """What a cycle sent."""

    def __init__(self) -> None:
        self.outputs: dict[str, list[Any]] = {}
        """The samples written, by port, in order of writing."""
        self.calls: list[MadeCall] = []
        self.reports: list[tuple[str, Any]] = []
        self.requested_cycle = False
        self.requested_at_s: float | None = None
        """Time at which the component requested its next cycle, s."""
        self.period_s: float | None = None
        self.duration_s: float | None = None
        self.error: Fault | None = None
        """The error with which the component enters the state RunTimeError."""

    def __getitem__(self, port: str) -> Any:
        """Returns the last sample written to a port in this cycle.

        Raises:
            KeyError: there is none.
        """
        return self.outputs[port][-1]

    def __contains__(self, port: str) -> bool:
        return port in self.outputs


class Bench(Generic[C]):
    """Drives a component in virtual time:

        bench = asmotion.Bench(Gripper, speed=0.5)
        outcome = bench.give("command", GripperCommand(opening=0.08)).cycle()
        assert outcome["state"].opening == 0.05

    Keywords are values of properties. The component is configured and started; `period_s` passes before each cycle. With
    the period 0 it is event-driven: `cycle` runs a cycle at the present time, and `run_for` those that the component requests
    and that what was given triggers.
    """

    def __init__(self, cls: type[C], *, period_s: float = 0.1, **properties: Any) -> None:
        self.period_s = period_s
        self.now = 0
        """Time, ns."""
        self.number = 0
        """Number of the last cycle."""
        self.woken = 0
        """How often the component requested a cycle with `wake`."""
        self.is_running = False
        self._program = Program(cls, self._wake)
        self._declaration = cls.declaration()
        self._properties: dict[str, Any] = {}
        self._inputs: dict[str, list[Any]] = {}
        self._recorded: list[tuple[int, str, Any]] = []
        self._stale: set[str] = set()
        self._lost: dict[str, int] = {}
        self._asked: list[dict[str, Any]] = []
        self._requests: dict[int, Request] = {}
        self._request_count = 0
        self._cancelled: list[int] = []
        self._calls: dict[int, MadeCall] = {}
        self._ends: list[dict[str, Any]] = []
        self._last: Outcome | None = None
        self._ask({"type": "hello", "protocol": 1, "component": cls.__name__, "clock": "virtual"})
        self.set(**properties)
        defaults = {name: item.form().dump(item.default) for name, item in self._declaration.properties.items()}
        self._ask({"type": "configure", "properties": defaults | self._take_properties(), "schemas": {}})
        self.start()

    @property
    def component(self) -> C:
        """The component under test."""
        return self._program.component  # type: ignore[return-value]

    def _wake(self) -> None:
        self.woken += 1

    def _ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """Sends a request through the encoding, as the engine does; a fault is an exception."""
        encoded = cbor.dumps(request)
        reply: dict[str, Any] = cbor.loads(cbor.dumps(self._program.handle(cbor.loads(encoded))))
        if reply["type"] == "fault":
            raise Fault(reply.get("code", "FAULT"), reply["text"])
        return reply

    def set(self, **properties: Any) -> Bench[C]:
        """Sets properties from the next cycle on.

        Raises:
            MismatchError: a value does not fit its type, range or choices.
            LookupError: there is no such property.
        """
        for name, value in properties.items():
            item = _known("property", name, self._declaration.properties)
            try:
                data = item.form().dump(value)
                item.check(value)
            except MismatchError as error:
                raise MismatchError(f"{item.place} {error}") from None
            self._properties[name] = data
        return self

    def _take_properties(self) -> dict[str, Any]:
        taken, self._properties = self._properties, {}
        return taken

    def give(self, port: str, sample: Any, *, is_stale: bool = False) -> Bench[C]:
        """Gives a sample to an input, for the next cycle.

        Raises:
            MismatchError: the sample does not fit the type of the port.
            LookupError: there is no such input.
        """
        item = _known("input", port, self._declaration.inputs)
        try:
            data = item.form().dump(sample)
        except MismatchError as error:
            raise MismatchError(f"{item.place}: {within('', error) if hasattr(error, 'path') else error}") from None
        self._inputs.setdefault(port, []).append(data)
        self._stale.discard(port)
        if is_stale:
            self._stale.add(port)
        return self

    def give_recorded(self, file: str | os.PathLike[str], **ports: str) -> Bench[C]:
        """Gives the samples of a recording (`asmotion run --record`), each in the first cycle at or after its time.

            bench.give_recorded("arm.csv", commands="Driver.commands").run_for(5.0)

        Args:
            ports: for each input, the name of the recorded port.

        Raises:
            MismatchError: the samples do not fit the type of the port.
            LookupError: there is no such input, or no such port in the recording.
            ValueError: the file is no recording.
        """
        for port, name in ports.items():
            form = _known("input", port, self._declaration.inputs).form()
            self._recorded += [(at, port, sample) for at, sample in recording.read(file, name, form)]
        self._recorded.sort(key=lambda entry: entry[0])
        return self

    def expire(self, port: str) -> Bench[C]:
        """Makes the newest sample of an input stale, until the next one is given."""
        self._stale.add(_known("input", port, self._declaration.inputs).name)
        return self

    def lose(self, port: str, count: int = 1) -> Bench[C]:
        """Counts messages as lost on the way to an input."""
        name = _known("input", port, self._declaration.inputs).name
        self._lost[name] = self._lost.get(name, 0) + count
        return self

    def request(
        self, service: str, operation: str, argument: Any = None, *, timeout_s: float = 10.0, one_way: bool = False
    ) -> Request:
        """Sends a request of an operation, which the component receives in the next cycle.

        Raises:
            MismatchError: the argument does not fit its type.
            LookupError: there is no such operation.
        """
        _known("service", service, self._declaration.services)
        names = {name: served for (owner, name), served in self._program.operations.items() if owner == service}
        served = _known("operation", operation, names)
        form = served.request
        self._request_count += 1
        asked = {
            "id": self._request_count,
            "service": service,
            "operation": operation,
            "argument": form.dump(form.zero() if argument is None else argument),
            "caller": "Bench",
        }
        request = Request(self._request_count, served.response.load)
        if not one_way:
            asked["deadline"] = self.now + round(timeout_s * 1e9)
            self._requests[request.id] = request
        self._asked.append(asked)
        return request

    def cancel(self, request: Request) -> Bench[C]:
        """Cancels a request; the component sees it in the next cycle."""
        if self._requests.pop(request.id, None) is not None:
            self._cancelled.append(request.id)
        return self

    def start(self) -> Bench[C]:
        """Starts the component; the constructor of the bench has done it."""
        self._ask({"type": "start"})
        self.is_running = True
        return self

    def cycle(self, count: int = 1) -> Outcome:
        """Runs cycles, a period apart, and returns what the last one sent.

        Raises:
            Fault: the cycle failed.
        """
        outcome = self._cycle("cycle")
        for _ in range(count - 1):
            outcome = self._cycle("cycle")
        return outcome

    def recover(self) -> Outcome:
        """Runs the cycle of the state RunTimeError.

        Raises:
            Fault: the cycle failed.
        """
        return self._cycle("recover")

    def run_for(self, seconds: float) -> list[Outcome]:
        """Runs the cycles of a time, and returns what each of them sent.

        Raises:
            Fault: a cycle failed.
        """
        end = self.now + round(seconds * 1e9)
        outcomes = []
        while (next_time := self._next_time()) is not None and next_time <= end:
            outcomes.append(self._cycle("cycle", next_time))
        if self.period_s == 0:
            self.now = end
        return outcomes

    def _next_time(self) -> int | None:
        """Time of the next cycle, ns; `None` if an event-driven component waits for input."""
        if self.period_s:
            return self.now + round(self.period_s * 1e9)
        if self.number == 0 or self._inputs or self._asked or self._ends or (self._last and self._last.requested_cycle):
            return self.now
        times = [] if not self._recorded else [self._recorded[0][0]]
        if self._last is not None and self._last.requested_at_s is not None:
            times.append(round(self._last.requested_at_s * 1e9))
        return max(min(times), self.now) if times else None

    def serve(self) -> Outcome:
        """Serves the requests of a stopped component.

        Raises:
            Fault: the component failed.
        """
        return self._cycle("serve")

    def stop(self) -> Outcome:
        """Runs the last cycle and writes the safe samples.

        Raises:
            Fault: the cycle failed.
        """
        reply = self._ask({"type": "stop", "now": self.now, "number": self.number})
        self.is_running = False
        outcome = self._outcome(reply)
        for name, item in self._declaration.outputs.items():
            if item.safe is not None:
                outcome.outputs.setdefault(name, []).append(item.safe)
        return outcome

    def freeze(self) -> bytes:
        """Returns the state of the component.

        Raises:
            Fault: it has no form as data; the text names the attribute.
        """
        reply = self._ask({"type": "freeze"})
        if reply["type"] == "unsupported":
            raise Fault("UNSUPPORTED", reply.get("text", ""))
        return bytes(reply["state"].memory)

    def thaw(self, state: bytes) -> Bench[C]:
        """Restores a state.

        Raises:
            Fault: the bytes are not a state of this component.
        """
        self._ask({"type": "thaw", "state": state})
        return self

    def inspect(self) -> dict[str, Any]:
        """Returns the description of the internal state."""
        return dict(self._ask({"type": "inspect"})["fields"])

    def _cycle(self, kind: str, now: int | None = None) -> Outcome:
        if kind != "serve":
            self.now = self.now + round(self.period_s * 1e9) if now is None else now
            self.number += 1
            due = [entry for entry in self._recorded if entry[0] <= self.now]
            self._recorded = self._recorded[len(due) :]
            for _, port, sample in due:
                self.give(port, sample)
        inputs = {name: {"samples": samples, "written_at": self.now} for name, samples in self._inputs.items()}
        parts: dict[str, Any] = {
            "inputs": {} if kind == "serve" else inputs,
            "stale": sorted(self._stale),
            "lost": self._lost,
            "properties": self._take_properties(),
            "requests": self._asked,
            "cancelled": self._cancelled,
            "replies": self._ends,
        }
        if kind != "serve":
            self._inputs = {}
        self._asked, self._cancelled, self._ends = [], [], []
        request = {"type": kind, "now": self.now, "number": self.number}
        request.update({name: part for name, part in parts.items() if part})
        self._last = outcome = self._outcome(self._ask(request))
        return outcome

    def _outcome(self, reply: dict[str, Any]) -> Outcome:
        outcome = Outcome()
        for port, sample in reply.get("outputs", ()):
            outcome.outputs.setdefault(port, []).append(self._declaration.outputs[port].form().load(sample))
        for data in reply.get("calls", ()):
            operation = self._program.engine.references[data["reference"]]._operations[data["operation"]]
            call = MadeCall(self, data, operation)
            self._calls[call.id] = call
            outcome.calls.append(call)
        for id in reply.get("cancel", ()):
            if id in self._calls and not self._calls[id].is_cancelled:
                self._calls[id].is_cancelled = True
                self._calls[id].fail("cancelled")
        for answer in reply.get("replies", ()):
            request = self._requests.pop(answer["id"], None)
            if request is not None:
                request.is_done = True
                if "fault" in answer:
                    request.fault = Fault(answer["fault"]["code"], answer["fault"]["text"])
                else:
                    request._result = request._load(answer["result"])
        outcome.reports = [(kind, value) for kind, value in reply.get("reports", ())]
        outcome.requested_cycle = reply.get("again", False)
        outcome.requested_at_s = reply["at"] * 1e-9 if "at" in reply else None
        outcome.period_s = reply["period"] * 1e-9 if "period" in reply else None
        outcome.duration_s = reply["duration"] * 1e-9 if "duration" in reply else None
        if outcome.period_s is not None:
            self.period_s = outcome.period_s
        if "error" in reply:
            outcome.error = Fault(reply["error"]["code"], reply["error"]["text"])
        return outcome


def _known(kind: str, name: str, items: dict[str, Any]) -> Any:
    if name not in items:
        known = ", ".join(f"`{item}`" for item in items) or "none"
        raise LookupError(f"there is no {kind} `{name}`; there are {known}")
    return items[name]
