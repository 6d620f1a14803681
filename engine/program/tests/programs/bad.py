"""Programs that go wrong: the first argument says how, the second when (`declare` or `cycle`)."""

import os
import struct
import sys
import time

sys.path.insert(0, "../../../../examples/gripper")
import protocol

how = sys.argv[1]
ECHO = {"inputs": [{"name": "in", "schema": protocol.record("acme/Number", n="i64")}],
        "outputs": [{"name": "out", "schema": protocol.record("acme/Number", n="i64")}]}
cycles = 0

if how == "exits":
    sys.exit("no gripper at /dev/ttyUSB0")
if how == "never-connects":
    print("waiting for the hardware", flush=True)
    time.sleep(60)
if how == "never-speaks":
    connection = protocol.connect()
    time.sleep(60)
if how == "garbage":
    # and closes the connection
    protocol.connect().sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")
    time.sleep(60)
if how == "not-cbor":
    connection = protocol.connect()
    connection.sendall(struct.pack("<I", 3) + b"\xff\xff\xff")
    time.sleep(60)
if how == "version":
    ECHO["protocol"] = 7
if how == "shape":
    ECHO["outputs"][0]["schema"]["shape"]["record"][0]["schema"]["shape"] = "float"
if how == "duplicate":
    ECHO["inputs"].append(ECHO["inputs"][0])
if how == "array":
    ECHO["outputs"][0]["schema"]["shape"]["record"][0]["schema"]["shape"] = {"array": [{"shape": "f64"}, 1 << 40]}
if how == "default":
    ECHO["properties"] = [{"name": "speed", "schema": {"shape": "f64"}, "default": "fast"}]


def cycle(request):
    global cycles
    cycles += 1
    samples = request.get("inputs", {}).get("in", {}).get("samples", [])
    done = {"type": "done", "outputs": [["out", {"n": sample["n"]}] for sample in samples]}
    if cycles != 3:
        return done
    if how == "dies":
        print("about to fail", flush=True)
        sys.exit("ValueError: the third cycle is too much")
    if how == "killed":
        os.kill(os.getpid(), 9)
    if how == "late":
        time.sleep(2.5)
    if how == "hangs":
        time.sleep(60)
    if how == "huge":
        connection.sendall(struct.pack("<I", 1 << 30))
        time.sleep(60)
    if how == "type":
        done["outputs"] = [["out", {"n": "three"}]]
    if how == "port":
        done["outputs"] = [["elsewhere", {"n": 3}]]
    if how == "field":
        done["outputs"] = [["out", {"m": 3}]]
    if how == "reply":
        return {"type": "ok"}
    if how == "faults":
        return {"type": "fault", "code": "JAMMED", "text": "the fingers are stuck"}
    if how == "prints":
        for line in range(100_000):
            print("line", line)
        sys.stdout.flush()
    return done


hello = protocol.connect


def remembered():
    global connection
    connection = hello()
    return connection


protocol.connect = remembered
protocol.serve(ECHO, {"cycle": cycle})
if how == "stays":
    time.sleep(60)
