"""A program that leads out of the engine: appends each sample that it takes to the file `taken`, as one that drives a device."""

import protocol

BOOL = protocol.record("std_msgs/Bool", data="bool")
DECLARATION = {"inputs": [{"name": name, "schema": BOOL, "doc": "may move"} for name in ("drive", "arm")]}


def cycle(request):
    with open("taken", "a") as taken:
        for name, port in request.get("inputs", {}).items():
            for sample in port.get("samples", []):
                print(name, str(sample["data"]).lower(), file=taken)
    return {"type": "done"}


protocol.serve(DECLARATION, {"cycle": cycle})
