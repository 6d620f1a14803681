"""A gripper: moves to the commanded opening, and closes on request after it has asked whether it may."""

import protocol

COMMAND = protocol.record("acme/GripperCommand", opening="f64")
STATE = protocol.record("acme/GripperState", opening="f64", is_closed="bool")
CLOSE = protocol.record("acme/Close", force="f64")
CLOSED = protocol.record("acme/Closed", width="f64")
PERMISSION = protocol.record("acme/Permission", granted="bool")

DECLARATION = {
    "implementation": "acme-gripper 1.2",
    "inputs": [{"name": "command", "schema": COMMAND, "doc": "wanted opening"}],
    "outputs": [{"name": "state", "schema": STATE, "doc": "where the fingers are", "safe": {"opening": 0.1}}],
    "services": [{"name": "grip", "interface": "acme/Grip", "doc": "closes the fingers",
                  "operations": [{"name": "close", "request": CLOSE, "response": CLOSED, "while_stopped": True}]}],
    "references": [{"name": "guard", "interface": "acme/Guard", "doc": "asked before the fingers close", "optional": True,
                    "operations": [{"name": "ask", "request": CLOSE, "response": PERMISSION}]}],
    "properties": [{"name": "speed", "doc": "of the fingers", "schema": {"shape": "f64"}, "unit": "m/s", "default": 0.1,
                    "range": [0.01, 0.5]},
                   {"name": "mode", "doc": "of the controller", "schema": {"shape": "text"}, "default": "soft",
                    "choices": ["soft", "hard"]}],
}

opening, target, speed = 0.0, 0.0, 0.1
asked = {}
calls = 0


def configure(request):
    global speed
    assert request["schemas"]["acme/GripperState"] == {**STATE, "shape": {"record": [
        {**field, "doc": "", "schema": {"name": "", "shape": field["schema"]["shape"]}} for field in STATE["shape"]["record"]]}}
    speed = request["properties"]["speed"]
    print("configured with", speed, flush=True)
    return {"type": "ok"}


def cycle(request):
    global opening, target, speed, calls
    done = {"type": "done", "outputs": [], "calls": [], "replies": []}
    speed = request.get("properties", {}).get("speed", speed)
    for sample in request.get("inputs", {}).get("command", {}).get("samples", []):
        target = sample["opening"]
    for one in request.get("requests", []):
        calls += 1
        asked[calls] = one["id"]
        done["calls"].append({"call": calls, "reference": "guard", "operation": "ask", "argument": one["argument"]})
    for reply in request.get("replies", []):
        one = asked.pop(reply["call"])
        error = reply.get("error")
        if error and error["kind"] != "unavailable":
            fault = {"code": "NO_GUARD", "text": error["kind"]}
            done["replies"].append({"id": one, "fault": fault})
        # without a guard it may
        elif error or reply["result"]["granted"]:
            target = 0.0
            done["replies"].append({"id": one, "result": {"width": opening}})
        else:
            done["replies"].append({"id": one, "fault": {"code": "REFUSED", "text": "the guard says no"}})
    step = speed * 0.1
    opening = min(max(target, opening - step), opening + step)
    # an integer where a float is declared, and fields in another order
    done["outputs"].append(["state", {"is_closed": opening == 0.0, "opening": 0 if opening == 0.0 else opening}])
    done["reports"] = [["opening", opening]]
    return done


def inspect(_):
    return {"type": "inspected", "fields": [["opening", opening], ["target", target]]}


def freeze(_):
    return {"type": "frozen", "state": protocol.encode([opening, target, speed, asked and list(asked.items()), calls])}


def thaw(request):
    global opening, target, speed, calls, asked
    opening, target, speed, pending, calls = protocol.decode(request["state"])[0]
    asked = dict(pending or [])
    return {"type": "ok"}


def serve(request):
    return {"type": "done", "replies": [{"id": one["id"], "fault": {"code": "STOPPED", "text": "start me first"}}
                                        for one in request["requests"]]}


protocol.serve(DECLARATION, {"configure": configure, "cycle": cycle, "inspect": inspect, "freeze": freeze, "thaw": thaw,
                             "serve": serve})
