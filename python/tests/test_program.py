"""Programs over a socket, driven as the engine drives them."""

import os
import socket
import subprocess
import sys
import tempfile
import textwrap
import unittest

import asmotion
from asmotion import cbor

PACKAGE = os.path.dirname(os.path.dirname(asmotion.__file__))

ECHO = """
    import threading, time
    import asmotion
    from typing import Annotated
    from asmotion import Numbers, f64, u8

    @asmotion.message("acme/Picture")
    class Picture:
        width: asmotion.u32 = 0
        data: Numbers[u8] = ()

    class Echo(asmotion.Component):
        seen = asmotion.In(Picture)
        shown = asmotion.Out(Picture)
        limit = asmotion.Property(3)

        def start(self):
            print("starts with", self.limit)
            threading.Thread(target=self.wake).start()

        def update(self, cycle):
            if self.seen.is_new:
                self.shown.write(self.seen.read())
            if cycle.number > self.limit:
                raise asmotion.Fault("TIRED", "that is enough")
            if cycle.number == 0:
                self.shown.write(Picture(data=bytes(70 << 20)))

    asmotion.run(Echo)
"""


class Driver:
    """The engine's end of the socket, and a program."""

    def __init__(self, program):
        self.folder = tempfile.TemporaryDirectory()
        path = os.path.join(self.folder.name, "socket")
        file = os.path.join(self.folder.name, "program.py")
        with open(file, "w") as out:
            out.write(textwrap.dedent(program))
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(path)
        self.listener.listen(1)
        self.listener.settimeout(20)
        environment = {**os.environ, "ASMOTION_SOCKET": path, "ASMOTION_COMPONENT": "Echo", "PYTHONPATH": PACKAGE}
        self.process = subprocess.Popen(
            [sys.executable, file],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def __enter__(self):
        self.socket, _ = self.listener.accept()
        self.socket.settimeout(20)
        return self

    def __exit__(self, *_):
        self.socket.close()
        self.listener.close()
        self.process.kill()
        self.process.communicate()
        self.folder.cleanup()

    def send(self, **request):
        data = cbor.dumps(request)
        self.socket.sendall(len(data).to_bytes(4, "little") + data)

    def receive(self):
        length = int.from_bytes(self.exactly(4), "little")
        return cbor.loads(self.exactly(length))

    def exactly(self, count):
        parts = bytearray()
        while len(parts) < count:
            part = self.socket.recv(count - len(parts))
            if not part:
                raise EOFError
            parts += part
        return parts

    def ask(self, **request):
        self.send(**request)
        while (reply := self.receive())["type"] == "wake":
            pass
        return reply

    def begin(self, **properties):
        declared = self.ask(type="hello", protocol=1, component="Echo", clock="virtual")
        self.ask(type="configure", properties=properties, schemas={})
        return declared


class Programs(unittest.TestCase):
    def test_a_program_passes_through_its_life_cycle(self):
        with Driver(ECHO) as driver:
            declared = driver.begin(limit=2)
            self.assertEqual((declared["type"], declared["protocol"]), ("declare", 1))
            self.assertEqual([port["name"] for port in declared["inputs"] + declared["outputs"]], ["seen", "shown"])
            driver.send(type="start")
            self.assertEqual({driver.receive()["type"] for _ in range(2)}, {"wake", "ok"})
            self.assertEqual(driver.process.stdout.readline(), "starts with 2\n")
            picture = {"width": 1000, "data": cbor.loads(cbor.dumps(memoryview(bytes(range(100)) * 10_000).cast("b")))}
            sample = {"samples": [picture], "written_at": 5}
            done = driver.ask(type="cycle", now=10, number=1, inputs={"seen": sample})
            self.assertEqual(done["type"], "done")
            ((port, shown),) = done["outputs"]
            self.assertEqual((port, shown["width"], len(shown["data"])), ("shown", 1000, 1_000_000))
            self.assertEqual(driver.ask(type="cycle", now=20, number=2), {"type": "done"})
            fault = driver.ask(type="cycle", now=30, number=3)
            self.assertEqual(fault, {"type": "fault", "code": "TIRED", "text": "that is enough"})
            self.assertEqual(driver.ask(type="exception"), {"type": "ok"})
            driver.send(type="exit")
            self.assertEqual(driver.process.wait(10), 0)

    def test_a_mistake_of_either_side_is_a_fault(self):
        with Driver(ECHO) as driver:
            driver.begin()
            driver.ask(type="start")
            self.assertIn("unknown request 'dance'", driver.ask(type="dance")["text"])
            late = driver.ask(type="cycle", now=0, number=0)
            self.assertEqual(late["type"], "fault")
            self.assertIn("73400", late["text"])
            self.assertEqual(driver.ask(type="cycle", now=1, number=1), {"type": "done"})

    def test_a_program_ends_with_the_connection(self):
        with Driver(ECHO) as driver:
            driver.begin()
            driver.socket.close()
            self.assertEqual(driver.process.wait(10), 0)

    def test_a_class_that_contradicts_itself_ends_the_program_with_a_line(self):
        driver = Driver(
            """
            import asmotion
            class Odd(asmotion.Component):
                goal = asmotion.In(int, "where to go")
            asmotion.run(Odd)
            """
        )
        _, errors = driver.process.communicate(timeout=20)
        driver.listener.close()
        driver.folder.cleanup()
        self.assertEqual(driver.process.returncode, 2)
        self.assertEqual(errors.count("\n"), 1)
        self.assertIn("program.py: input `Odd.goal`: int is no message type", errors)

    def test_a_program_started_by_hand_says_how_to_start_it(self):
        environment = {key: value for key, value in os.environ.items() if key != "ASMOTION_SOCKET"}
        environment["PYTHONPATH"] = PACKAGE
        text = "import asmotion\nclass Idle(asmotion.Component):\n  rate = asmotion.Property(1, 'of work')\nasmotion.run(Idle)"
        ended = subprocess.run([sys.executable, "-c", text], env=environment, capture_output=True, text=True)
        self.assertEqual(ended.returncode, 2)
        self.assertIn("implementation = { process = [", ended.stderr)
        self.assertIn("property rate: of work", ended.stderr)


class Wakes(unittest.TestCase):
    def test_a_thread_computes_while_the_clock_is_that_of_the_wall(self):
        program = """
            import asyncio, time
            import asmotion

            @asmotion.message("acme/Number")
            class Number:
                value: float = 0.0

            class Slow(asmotion.Component):
                out = asmotion.Out(Number)

                async def update(self, cycle):
                    self.out.write(Number(await asyncio.to_thread(self.compute)))

                def compute(self):
                    time.sleep(0.05)
                    return 7.0

            asmotion.run(Slow)
        """
        with Driver(program) as driver:
            driver.ask(type="hello", protocol=1, component="Slow", clock="wall")
            driver.ask(type="configure", properties={}, schemas={})
            driver.ask(type="start")
            self.assertEqual(driver.ask(type="cycle", now=0, number=1), {"type": "done"})
            self.assertEqual(driver.receive(), {"type": "wake"})
            self.assertEqual(driver.ask(type="cycle", now=1, number=2)["outputs"], [["out", {"value": 7.0}]])


