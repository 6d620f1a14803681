"""A foreign writer of a POSIX message queue, as an Orocos component would be one: a number each 100 ms, while there is room."""

import ctypes
import ctypes.util
import os
import struct
import sys
import time


class Attributes(ctypes.Structure):
    _fields_ = [(name, ctypes.c_long) for name in ("flags", "maxmsg", "msgsize", "curmsgs", "a", "b", "c", "d")]


rt = ctypes.CDLL(ctypes.util.find_library("rt") or None, use_errno=True)
flags = os.O_CREAT | os.O_WRONLY | os.O_NONBLOCK
queue = rt.mq_open(sys.argv[1].encode(), flags, 0o600, ctypes.byref(Attributes(0, 10, 8)))


def send(number):
    message = struct.pack("=iI", number, 0)
    return rt.mq_send(queue, message, len(message), 0) == 0


# the first message shows the layout
send(0)
time.sleep(1)
number = 1
while True:
    if send(number):
        number += 1
    time.sleep(0.1)
