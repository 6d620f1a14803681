"""Requests a cycle every 50 ms from a thread; with an argument, ends instead after a while."""

import os
import sys
import threading
import time

sys.path.insert(0, "../../../../examples/gripper")
import protocol

connect = protocol.connect


def remembered():
    global connection
    connection = connect()
    return connection


def wake():
    time.sleep(0.3)
    if len(sys.argv) > 1:
        print("the device is gone", flush=True)
        os._exit(3)
    while True:
        time.sleep(0.05)
        protocol.send(connection, {"type": "wake"})


def start(request):
    threading.Thread(target=wake, daemon=True).start()
    return {"type": "ok"}


def cycle(request):
    return {"type": "done", "reports": [["woken by", "a thread"]]}


protocol.connect = remembered
protocol.serve({}, {"start": start, "cycle": cycle})
