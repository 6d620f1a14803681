"""A peer on POSIX message queues, as an Orocos component would be one; it knows the format from its description alone.

A message here is a truth value, three numbers of 16 bits, and a list of doubles.
"""

import ctypes
import ctypes.util
import json
import os
import struct
import sys
import time

libc = ctypes.CDLL(ctypes.util.find_library("rt") or None, use_errno=True)


class Attributes(ctypes.Structure):
    _fields_ = [(name, ctypes.c_long) for name in ("flags", "maxmsg", "msgsize", "curmsgs", "a", "b", "c", "d")]


class Moment(ctypes.Structure):
    _fields_ = [("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long)]


def opened(name, flags, size=0):
    attributes = Attributes(0, 10, size)
    queue = libc.mq_open(name.encode(), flags, 0o600, ctypes.byref(attributes) if size else None)
    if queue < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return queue


def receive(queue, seconds):
    attributes = Attributes()
    libc.mq_getattr(queue, ctypes.byref(attributes))
    buffer = ctypes.create_string_buffer(attributes.msgsize)
    until = time.time() + seconds
    moment = Moment(int(until), int(until % 1 * 1e9))
    count = libc.mq_timedreceive(queue, buffer, len(buffer), None, ctypes.byref(moment))
    return buffer.raw[:count] if count >= 0 else None


def send(queue, message):
    return libc.mq_send(queue, message, len(message), 0) == 0


def pack(flag, errors, position):
    return struct.pack(f"=?3HQ{len(position)}d", flag, *errors, len(position), *position)


def unpack(message):
    flag, *errors, count = struct.unpack_from("=?3HQ", message)
    position = struct.unpack_from(f"={count}d", message, struct.calcsize("=?3HQ"))
    return {"flag": flag, "errors": errors, "position": position}


def main(role, name, *rest):
    if role == "read":
        queue = opened(name, os.O_RDONLY)
        print("initial", json.dumps(unpack(receive(queue, 0.5))), flush=True)
        for _ in range(int(rest[0])):
            print(json.dumps(unpack(receive(queue, 5))), flush=True)
    elif role == "write":
        queue = opened(name, os.O_CREAT | os.O_WRONLY | os.O_NONBLOCK, 128)
        send(queue, pack(False, [0, 0, 0], []))
        for number in range(int(rest[0])):
            time.sleep(0.05)
            send(queue, pack(True, [number, 2, 3], [number / 2] * number))
        send(queue, b"\x01\x02")
        sys.stdin.read()
        libc.mq_unlink(name.encode())
    elif role == "echo":
        there = opened(name, os.O_RDONLY)
        back = opened(rest[0], os.O_CREAT | os.O_WRONLY | os.O_NONBLOCK, 128)
        while (message := receive(there, 5)) is not None:
            send(back, message)
        libc.mq_unlink(rest[0].encode())
    elif role == "serve":
        serve(name)


def serve(name):
    """Obeys commands, one a line, and answers each with a line."""
    queue = None
    for line in sys.stdin:
        command, *words = line.split()
        answer = "done"
        try:
            if command == "make":
                queue = opened(name, os.O_CREAT | os.O_RDONLY, 128)
            elif command == "open":
                queue = opened(name, os.O_RDONLY)
            elif command == "read":
                message = receive(queue, float(words[0]))
                answer = "nothing" if message is None else str(unpack(message)["errors"][0])
            elif command == "offer":
                queue = opened(name, os.O_CREAT | os.O_WRONLY | os.O_NONBLOCK, 128)
                # as RTT: the first message shows the layout
                send(queue, pack(False, [999, 0, 0], []))
            elif command == "write":
                number = int(words[0])
                send(queue, pack(True, [number, 2, 3], [number / 2] * number))
            elif command == "unlink":
                libc.mq_unlink(name.encode())
        except OSError as error:
            answer = error.strerror
        print(answer, flush=True)


main(*sys.argv[1:])
