"""Requests its next cycle at a time: one of `TIMES`."""

import sys

sys.path.insert(0, "../../../../examples/gripper")
import protocol

TIMES = {
    "ticks": lambda now: now + 70_000_000,
    "far": lambda now: (1 << 63) - 1,
    "before": lambda now: -1,
    "beyond": lambda now: (1 << 64) - 1,
    "text": lambda now: "soon",
    "fraction": lambda now: now + 0.5,
}


def cycle(request):
    done = {"type": "done", "reports": [["now", request["now"]]]}
    at = TIMES[sys.argv[1]](request["now"])
    return {**done, "at": at}


protocol.serve({}, {"cycle": cycle})
