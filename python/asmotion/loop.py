"""An event loop of asyncio that runs inside the cycles of a component, on the time of the engine."""

from __future__ import annotations

import asyncio
import heapq
import sys
import threading
from asyncio import events
from collections import deque
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from contextvars import Context
from typing import Any

from asmotion.errors import Fault, fault_of

STEPS = 100_000
"""Steps of tasks in one cycle, after which the cycle fails."""

_TOLERANCE = 5e-7  # s; floats have this precision at the time of day


class CycleLoop(asyncio.AbstractEventLoop):
    """Runs tasks within cycles: `run` continues all of them until each waits for something.

    `asyncio.sleep`, `wait_for`, `timeout`, `gather` and `to_thread` work. A sleep ends in the first cycle at or after its
    time; an event-driven component has a cycle at that time (`next_time`). In virtual time `to_thread` computes its result at
    once; otherwise its end requests a cycle.
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        self.now = 0.0
        self.is_virtual = True
        self._wake = wake
        self._ready: deque[asyncio.Handle] = deque()
        self._timers: list[tuple[float, int, asyncio.TimerHandle]] = []
        self._timer_count = 0
        self._lock = threading.Lock()
        self._from_threads: list[asyncio.Handle] = []
        self._pool: ThreadPoolExecutor | None = None
        self._is_running = False

    def run(self, now: float) -> None:
        """Continues all tasks that can continue at this time (s).

        Raises:
            Fault: tasks do not come to rest.
        """
        self.now = now
        with self._lock:
            self._ready.extend(self._from_threads)
            self._from_threads.clear()
        outer = events._get_running_loop()
        events._set_running_loop(self)
        self._is_running = True
        try:
            for _ in range(STEPS):
                while self._timers and self._timers[0][0] <= now + _TOLERANCE:
                    self._ready.append(heapq.heappop(self._timers)[2])
                if not self._ready:
                    return
                handle = self._ready.popleft()
                if not handle.cancelled():
                    handle._run()
        finally:
            self._is_running = False
            events._set_running_loop(outer)
        raise Fault("ENDLESS", f"the tasks of a cycle do not come to rest in {STEPS} steps; let them wait for a time or a call")

    def next_time(self) -> float | None:
        """Returns the time of the next timer, s; `None` without one."""
        while self._timers and self._timers[0][2].cancelled():
            heapq.heappop(self._timers)
        return self._timers[0][0] if self._timers else None

    def clear(self) -> None:
        """Forgets all tasks and timers."""
        self._ready.clear()
        self._timers.clear()

    def time(self) -> float:
        return self.now

    def call_soon(self, callback: Any, *args: Any, context: Context | None = None) -> asyncio.Handle:  # type: ignore[override]
        handle = asyncio.Handle(callback, args, self, context)
        self._ready.append(handle)
        return handle

    def call_soon_threadsafe(self, callback: Any, *args: Any, context: Context | None = None) -> asyncio.Handle:  # type: ignore[override]
        handle = asyncio.Handle(callback, args, self, context)
        with self._lock:
            self._from_threads.append(handle)
        self._wake()
        return handle

    def call_later(self, delay: float, callback: Any, *args: Any, context: Context | None = None) -> asyncio.TimerHandle:  # type: ignore[override]
        return self.call_at(self.now + delay, callback, *args, context=context)

    def call_at(self, when: float, callback: Any, *args: Any, context: Context | None = None) -> asyncio.TimerHandle:  # type: ignore[override]
        timer = asyncio.TimerHandle(when, callback, args, self, context)
        self._timer_count += 1
        heapq.heappush(self._timers, (when, self._timer_count, timer))
        return timer

    def create_future(self) -> asyncio.Future[Any]:
        return asyncio.Future(loop=self)

    def create_task(self, coro: Coroutine[Any, Any, Any], **options: Any) -> asyncio.Task[Any]:  # type: ignore[override]
        return asyncio.Task(coro, loop=self, **options)

    def run_in_executor(self, executor: Any, func: Any, *args: Any) -> Any:  # type: ignore[override]
        if self.is_virtual:
            future = self.create_future()
            try:
                future.set_result(func(*args))
            except Exception as error:
                future.set_exception(error)
            return future
        if executor is None:
            self._pool = executor = self._pool or ThreadPoolExecutor()
        return asyncio.wrap_future(executor.submit(func, *args), loop=self)

    def call_exception_handler(self, context: dict[str, Any]) -> None:
        error = context.get("exception")
        if error is not None:  # otherwise a task has ended with its component
            print(f"a task failed unnoticed: {fault_of(error)['text']}", file=sys.stderr)

    default_exception_handler = call_exception_handler

    def get_debug(self) -> bool:
        return False

    def is_running(self) -> bool:
        return self._is_running

    def is_closed(self) -> bool:
        return False

    def _timer_handle_cancelled(self, handle: asyncio.TimerHandle) -> None:
        """Called by a cancelled timer, which is skipped when its time comes."""
