"""Runs a command on a terminal of its own.

    terminal.py SECONDS COMMAND…

Each line of standard input is a text: the program reads what the command shows until the text has appeared, and prints `shown` with how
often. At the end of standard input it closes the terminal, and prints the exit code of the command, or `alive` if it does not
end within the seconds.
"""

import fcntl
import os
import pty
import select
import struct
import sys
import termios
import time

seconds, command = float(sys.argv[1]), sys.argv[2:]
child, terminal = pty.fork()
if child == 0:
    fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
    os.execv(command[0], command)

seen = b""


def read(until):
    """Reads what is shown, until a time."""
    global seen
    wait = max(0.0, until - time.monotonic())
    if not select.select([terminal], [], [], wait)[0]:
        return
    try:
        seen += os.read(terminal, 65536)
    except OSError:
        sys.exit(f"the command has ended after {seen!r}")


for line in sys.stdin:
    text, times = line.rstrip("\n").rsplit(" ", 1)
    until = time.monotonic() + seconds
    while seen.count(text.encode()) < int(times) and time.monotonic() < until:
        read(until)
    print("shown", seen.count(text.encode()), flush=True)
os.close(terminal)
until = time.monotonic() + seconds
while time.monotonic() < until:
    ended, status = os.waitpid(child, os.WNOHANG)
    if ended:
        print("ended", os.waitstatus_to_exitcode(status))
        sys.exit()
    time.sleep(0.05)
os.kill(child, 9)
os.waitpid(child, 0)
print("alive")
