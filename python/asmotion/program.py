"""The program protocol: answers the requests of the engine, which drives one component."""

from __future__ import annotations

import array
import asyncio
import gc
import inspect
import os
import socket
import sys
import threading
from collections.abc import Coroutine
from typing import Any, NoReturn

from asmotion import cbor, frozen
from asmotion.component import Component, Cycle, Engine, Pending, ServedOperation
from asmotion.errors import CallError, DeclarationError, Fault, fault_of
from asmotion.memory import SharedMemory
from asmotion.types import Form

FRAME_LIMIT = 64 << 20
"""Largest frame, bytes."""

_UPDATE = -1  # key of the task of `update` among the tasks of requests


class Program:
    """A component class, driven by requests. `run` connects it to an engine, `Bench` to a test."""

    def __init__(self, cls: type[Component], wake: Any = None) -> None:
        self.cls = cls
        self.component: Component | None = None
        self.engine = Engine(cls, wake or (lambda: None))
        self.operations = {
            (service.name, served.name): served
            for service in cls.declaration().services.values()
            for served in service.served
        }
        self.is_clean = True

    def handle(self, request: dict[str, Any]) -> dict[str, Any]:
        """Answers a request of the engine."""
        kind = request.get("type")
        handler = getattr(self, f"_{kind}", None) if isinstance(kind, str) and kind in _REQUESTS else None
        if handler is None:
            return {"type": "fault", "code": "PROTOCOL", "text": f"unknown request {kind!r}"}
        try:
            reply: dict[str, Any] = handler(request)
            return reply
        except Exception as error:
            return {"type": "fault", **fault_of(error)}

    def _hello(self, request: dict[str, Any]) -> dict[str, Any]:
        if request.get("protocol") != 1:
            raise Fault("PROTOCOL", f"this package has version 1 of the protocol, not {request.get('protocol')}")
        self.engine.loop.is_virtual = request.get("clock") != "wall"
        return self.cls.declaration().data()

    def _configure(self, request: dict[str, Any]) -> dict[str, Any]:
        self._set_properties(request)
        if self.component is None or self.is_clean:
            self._build()
        self._hook("configure")
        self.is_clean = False
        return {"type": "ok"}

    def _build(self) -> None:
        Engine.building = self.engine
        try:
            self.component = self.cls()
        finally:
            Engine.building = None

    def _set_properties(self, request: dict[str, Any]) -> None:
        for name, value in request.get("properties", {}).items():
            self.engine.properties[name] = self.engine.forms[name].load(value)

    def _start(self, request: dict[str, Any]) -> dict[str, Any]:
        self._hook("start")
        return {"type": "ok"}

    def _hook(self, name: str, *arguments: Any) -> Any:
        result = getattr(self.component, name)(*arguments)
        if inspect.iscoroutine(result):
            result.close()
            raise TypeError(f"`{name}` is a coroutine; only `update` and operations can be")
        return result

    def _cycle(self, request: dict[str, Any]) -> dict[str, Any]:
        return self._run(request, "update")

    def _recover(self, request: dict[str, Any]) -> dict[str, Any]:
        return self._run(request, "recover")

    def _serve(self, request: dict[str, Any]) -> dict[str, Any]:
        return self._run(request, None, is_running=False)

    def _stop(self, request: dict[str, Any]) -> dict[str, Any]:
        engine = self._begin(request, True)
        try:
            for task in list(engine.tasks.values()):
                task.cancel()
            engine.loop.run(engine.cycle.seconds)
            engine.tasks.clear()
            self._hook("stop", engine.cycle)
        finally:
            engine.in_cycle = False
        return engine.cycle._effects.data()

    def _begin(self, request: dict[str, Any], is_running: bool) -> Engine:
        engine = self.engine
        engine.cycle = Cycle(request["now"], request["number"], is_running)
        engine.in_cycle = True
        return engine

    def _run(self, request: dict[str, Any], hook: str | None, is_running: bool = True) -> dict[str, Any]:
        """Runs a cycle: inputs, replies and requests, then the tasks, then the hook."""
        engine = self._begin(request, is_running)
        try:
            if is_running:
                self._freeze_inputs(request)
            self._set_properties(request)
            self._end_calls(request)
            self._cancel(request)
            for asked in request.get("requests", ()):
                self._request(asked)
            engine.loop.run(engine.cycle.seconds)
            if hook is not None and _UPDATE not in engine.tasks:
                result = getattr(self.component, hook)(engine.cycle)
                if inspect.iscoroutine(result):
                    engine.tasks[_UPDATE] = self._task(result)
                    engine.loop.run(engine.cycle.seconds)
            self._collect()
        finally:
            engine.in_cycle = False
        wait_until = engine.loop.next_time()
        if is_running and wait_until is not None:
            engine.cycle.request_cycle_at(wait_until)
        return engine.cycle._effects.data()

    def _task(self, coroutine: Coroutine[Any, Any, Any]) -> asyncio.Task[Any]:
        return self.engine.loop.create_task(coroutine)

    def _freeze_inputs(self, request: dict[str, Any]) -> None:
        arrived = request.get("inputs", {})
        stale = request.get("stale", ())
        lost = request.get("lost", {})
        for name, port in self.engine.inputs.items():
            news = arrived.get(name)
            port._all = [] if news is None else [port.form.load(sample) for sample in news["samples"]]
            port.is_stale = name in stale
            port.lost = lost.get(name, port.lost)
            if news is not None and port._all:
                port._newest = port._all[-1]
                port.written_at = news.get("written_at")
                waiting, port._waiting = port._waiting, []
                for future in waiting:
                    if not future.done():
                        future.set_result(port._newest)

    def _end_calls(self, request: dict[str, Any]) -> None:
        for ended in request.get("replies", ()):
            call = self.engine.calls.pop(ended["call"], None)
            if call is None:
                continue
            error = ended.get("error")
            if error is None:
                call.finish(call._operation.response.load(ended.get("result")), None)
            else:
                failure = CallError(error["kind"], error.get("code", ""), error.get("text", ""))
                call.finish(None, failure)

    def _cancel(self, request: dict[str, Any]) -> None:
        for id in request.get("cancelled", ()):
            pending = self.engine.pending.pop(id, None)
            if pending is not None:
                pending.is_cancelled = True
            task = self.engine.tasks.get(id)
            if task is not None:
                task.cancel()

    def _request(self, asked: dict[str, Any]) -> None:
        served = self.operations[asked["service"], asked["operation"]]
        pending: Pending[Any] = Pending()
        pending.id, pending.caller, pending.deadline = asked["id"], asked.get("caller", ""), asked.get("deadline")
        arguments = [served.request.load(asked.get("argument"))] if served.has_argument else []
        try:
            result = getattr(self.component, served.method.__name__)(*arguments)
        except Fault as fault:
            self._reply(served, pending, None, fault)
            return
        if inspect.iscoroutine(result):
            task = self._task(result)
            self.engine.tasks[pending.id] = task
            task.add_done_callback(lambda ended: self._end_of_task(served, pending, ended))
        elif isinstance(result, Pending):
            self._keep(served, pending, result)
        else:
            self._reply(served, pending, result, None)

    def _keep(self, served: ServedOperation, asked: Pending[Any], kept: Pending[Any]) -> None:
        kept._engine, kept._served = self.engine, served
        kept.id, kept.caller, kept.deadline = asked.id, asked.caller, asked.deadline
        if kept._early is None:
            self.engine.pending[kept.id] = kept
        else:
            kept._end(*kept._early)

    def _reply(self, served: ServedOperation, asked: Pending[Any], response: Any, fault: Fault | None) -> None:
        if asked.deadline is not None:
            self.engine.reply(served, asked.id, response, fault)

    def _end_of_task(self, served: ServedOperation, asked: Pending[Any], task: asyncio.Task[Any]) -> None:
        """Replies when the coroutine of an operation ends; keeps it for `_collect` if it failed."""
        if task.cancelled():
            self.engine.tasks.pop(asked.id, None)
            return
        error = task.exception()
        if error is not None and not isinstance(error, Fault):
            return
        self.engine.tasks.pop(asked.id, None)
        try:
            self._reply(served, asked, None if error else task.result(), error)
        except Exception as mistake:
            self.engine.tasks[asked.id] = self._task(_raise(mistake))

    def _collect(self) -> None:
        """Raises the exception of a task that failed, and forgets those that have ended."""
        self.engine.loop.run(self.engine.cycle.seconds)
        for id, task in list(self.engine.tasks.items()):
            if task.done():
                del self.engine.tasks[id]
                if not task.cancelled():
                    task.result()

    def _cleanup(self, request: dict[str, Any]) -> dict[str, Any]:
        self._forget()
        self._hook("cleanup")
        self.is_clean = True
        return {"type": "ok"}

    def _exception(self, request: dict[str, Any]) -> dict[str, Any]:
        self._forget()
        if self.component is not None:
            self._hook("exception")
        self.is_clean = True
        return {"type": "ok"}

    def _forget(self) -> None:
        """Ends everything that is under way."""
        engine = self.engine
        for task in list(engine.tasks.values()):
            task.cancel()
        engine.loop.run(engine.loop.now)
        engine.tasks.clear()
        engine.loop.clear()
        engine.calls.clear()
        engine.pending.clear()

    def _inspect(self, request: dict[str, Any]) -> dict[str, Any]:
        described = {} if self.component is None else self._hook("inspect")
        return {"type": "inspected", "fields": [[name, Form().dump(value)] for name, value in described.items()]}

    def _freeze(self, request: dict[str, Any]) -> dict[str, Any]:
        if self.component is None:
            return {"type": "frozen", "state": b""}
        try:
            return {"type": "frozen", "state": frozen.freeze(self.component, self.engine)}
        except frozen.CannotFreeze as error:
            return {"type": "unsupported", "text": str(error)}

    def _thaw(self, request: dict[str, Any]) -> dict[str, Any]:
        state = bytes(request["state"].memory)
        if self.component is None:
            self._build()
        if state and self.component is not None:
            frozen.thaw(self.component, self.engine, state)
        return {"type": "ok"}


async def _raise(error: Exception) -> NoReturn:
    raise error


_REQUESTS = frozenset(
    ["hello", "configure", "start", "cycle", "recover", "serve", "stop", "cleanup", "exception", "inspect", "freeze", "thaw"]
)


class Connection:
    """Frames over the socket of the engine."""

    def __init__(self, path: str) -> None:
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.connect(path)
        self.lock = threading.Lock()
        self.files = array.array("i")
        self.memory: SharedMemory | None = None

    def agree(self, hello: dict[str, Any], declared: dict[str, Any]) -> None:
        """Declares the use of the shared memory that `hello` offers."""
        files, self.files = list(self.files), array.array("i")
        size = hello.get("shared_memory")
        if len(files) != 2 or type(size) is not int:
            for file in files:
                os.close(file)
            return
        try:
            self.memory = SharedMemory(files, size)
        except (OSError, ValueError):  # all data go through the socket
            return
        declared["shared_memory"] = True

    def send(self, message: dict[str, Any]) -> None:
        """Sends a reply; large arrays are in shared memory, or leave without a copy.

        Raises:
            ValueError: the message is longer than a frame may be.
            OSError: the engine has closed the connection.
        """
        if self.memory is not None:
            self.memory.begin()
        self._send(cbor.encode(message, self.memory))

    def _send(self, message: list[cbor.Buffer]) -> None:
        parts = [memoryview(part).cast("B") for part in message]
        length = sum(map(len, parts))
        if length > FRAME_LIMIT:
            raise ValueError(f"the outputs of a cycle have {length} bytes, and at most {FRAME_LIMIT} can be sent")
        with self.lock:
            waiting = [memoryview(length.to_bytes(4, "little")), *parts]
            while waiting:
                sent = self.socket.sendmsg(waiting[:64])
                while waiting and sent >= len(waiting[0]):
                    sent -= len(waiting.pop(0))
                if sent:
                    waiting[0] = waiting[0][sent:]

    def receive(self) -> dict[str, Any] | None:
        """Waits for a message; `None` if the engine has closed the connection.

        Raises:
            ValueError: what arrived is no message.
        """
        head = self._exactly(4)
        if head is None:
            return None
        length = int.from_bytes(head, "little")
        if length > FRAME_LIMIT:
            raise ValueError(f"a frame of {length} bytes")
        frame = self._exactly(length)
        if frame is None:
            return None
        message = cbor.loads(frame, self.memory)
        if not isinstance(message, dict):
            raise ValueError("a frame that is not a map")
        return message

    def _exactly(self, count: int) -> bytearray | None:
        buffer = bytearray(count)
        view = memoryview(buffer)
        while view:
            received, ancillary, _, _ = self.socket.recvmsg_into([view], socket.CMSG_SPACE(8))
            for level, kind, data in ancillary:
                if (level, kind) == (socket.SOL_SOCKET, socket.SCM_RIGHTS):
                    self.files.frombytes(data)
            if received == 0:
                return None
            view = view[received:]
        return buffer

    def wake(self) -> None:
        """Requests a cycle. Does nothing if the engine has closed the connection."""
        try:
            self._send(cbor.encode({"type": "wake"}))
        except OSError:
            pass


def run(cls: type[Component]) -> NoReturn:
    """Runs a component as the program that asmotion has started. Ends with the program."""
    try:
        cls.declaration().data()
    except DeclarationError as error:
        print(f"{os.path.basename(sys.argv[0])}: {error}", file=sys.stderr)
        sys.exit(2)
    path = os.environ.get("ASMOTION_SOCKET")
    if path is None:
        print(_alone(cls), file=sys.stderr)
        sys.exit(2)
    sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    connection = Connection(path)
    program = Program(cls, connection.wake)
    # what has been imported stays: the garbage collector need not pause cycles to visit it
    gc.freeze()
    while (request := connection.receive()) is not None and request.get("type") != "exit":
        reply = program.handle(request)
        if reply.get("type") == "declare":
            connection.agree(request, reply)
        try:
            connection.send(reply)
        except ValueError as error:  # the reply has no form as data, or is too long
            connection.send({"type": "fault", **fault_of(error)})
    sys.exit(0)


def _alone(cls: type[Component]) -> str:
    """Explains how the program is started, and what it declares."""
    declaration = cls.declaration()
    file = os.path.basename(sys.argv[0])
    lines = [
        f"{file} is a component, which asmotion starts. In a composite:",
        "",
        f"  [components.{cls.__name__}]",
        f'  implementation = {{ process = ["python3", "{file}"] }}',
        "",
        f"{cls.__name__} declares:",
    ]
    for items in (
        declaration.inputs,
        declaration.outputs,
        declaration.services,
        declaration.references,
        declaration.properties,
    ):
        lines += [f"  {item.kind} {item.name}: {item.doc}".rstrip(": ") for item in items.values()]
    return "\n".join(lines)
