"""Requests and replies of 56 bytes over ZeroMQ: `server ADDRESS`, or `client ADDRESS`, which measures on request."""

import sys
import time

import zmq

SIZE = 56

role, address = sys.argv[1:]
context = zmq.Context()
if role == "server":
    socket = context.socket(zmq.REP)
    socket.bind(address)
    while True:
        socket.send(socket.recv())
socket = context.socket(zmq.REQ)
socket.connect(address)
for line in sys.stdin:
    times = []
    for _ in range(int(line)):
        begin = time.perf_counter_ns()
        socket.send(bytes(SIZE))
        socket.recv()
        times.append(time.perf_counter_ns() - begin)
    print(*times, sep="\n", flush=True)
context.destroy(linger=0)
