"""A foreign reader of a POSIX message queue, as an Orocos component would be one: prints each truth value that it receives."""

import ctypes, ctypes.util, os, sys, time

rt = ctypes.CDLL(ctypes.util.find_library("rt") or None, use_errno=True)
while (queue := rt.mq_open(sys.argv[1].encode(), os.O_RDONLY)) < 0:
    time.sleep(0.01)
buffer = ctypes.create_string_buffer(1 << 16)
while (size := rt.mq_receive(queue, buffer, len(buffer), None)) >= 0:
    print("true" if buffer.raw[size - 1] else "false", flush=True)
