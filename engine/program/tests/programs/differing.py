"""Declares interfaces that other components have, too, with other types and another operation."""

import sys

sys.path.insert(0, "../../../../examples/gripper")
import protocol

CLOSE = protocol.record("test/Close", strength="f64")
CLOSED = protocol.record("test/Closed", width="f64")


def interface(port, name, operation, optional=True):
    operations = [{"name": operation, "request": CLOSE, "response": CLOSED}]
    return {"name": port, "interface": name, "operations": operations, "optional": optional}


protocol.serve({
    "references": [interface("grip", "acme/Grip", "close"), interface("planner", "nav/PlanService", "replan")],
    "services": [interface("maps", "nav/MapService", "getMap")],
}, {})
