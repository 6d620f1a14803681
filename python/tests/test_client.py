"""The client, against a small gateway."""

import json
import threading
import unittest
from http.server import BaseHTTPRequestHandler, HTTPServer

import asmotion
from asmotion import CallError
from tests.test_component import Doubling, Number


class Gateway(BaseHTTPRequestHandler):
    seen: list = []

    def do_GET(self):
        if self.path == "/services":
            self.reply(200, {"services": [{"name": "maths"}]})
        elif self.path == "/components/Arm":
            self.reply(200, {"name": "Arm", "state": "running"})
        elif self.path == "/health":
            self.reply(503, {"state": "DOWN", "reason": "no bus"})
        elif self.path == "/components":
            self.reply(200, [{"name": "Arm"}])
        else:
            self.problem(404, "NO_COMPONENT", "there is no such component", "did you mean `Arm`?")

    def do_POST(self):
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.seen.append((self.path, body, self.headers.get("Authorization")))
        operation = self.path.partition("?")[0].rpartition("/")[2]
        if operation == "double":
            self.reply(200, {"value": "NaN" if body.get("value") == "Infinity" else body.get("value", 0) * 2})
        elif operation == "jam":
            self.problem(422, "JAMMED", "it is stuck")
        elif operation == "slow":
            self.problem(504, "TIMEOUT", "no reply within the deadline")
        elif operation == "stopped":
            self.problem(503, "STOPPED", "the component does not run")
        else:
            self.reply(202, None)

    def problem(self, status, code, detail, help=None):
        body = {"status": status, "title": "t", "code": code, "detail": detail}
        self.reply(status, body | ({"help": help} if help else {}))

    def reply(self, status, body):
        content = b"" if body is None else json.dumps(body).encode()
        self.send_response(status)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_):
        pass


class Client(unittest.TestCase):
    def setUp(self):
        Gateway.seen.clear()
        self.server = HTTPServer(("127.0.0.1", 0), Gateway)
        thread = threading.Thread(target=self.server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        self.addCleanup(self.server.server_close)
        self.addCleanup(thread.join)
        self.addCleanup(self.server.shutdown)
        self.robot = asmotion.connect(f"http://127.0.0.1:{self.server.server_port}/", token="secret")

    def test_it_calls_operations(self):
        self.assertEqual(self.robot.call("maths.double", {"value": 2.0}, timeout_s=0.5), {"value": 4.0})
        self.assertEqual(self.robot.call("maths.double", Number(3.0), returns=Number), Number(6.0))
        self.assertEqual(self.robot.maths.double(value=1.5).value, 3.0)
        self.assertEqual(self.robot.service("maths", Doubling).double(Number(1.0)), Number(2.0))
        infinite = self.robot.call("maths.double", Number(float("inf")), returns=Number)
        self.assertNotEqual(infinite.value, infinite.value)
        self.robot.call_one_way("maths.note")
        paths = [path for path, _, token in Gateway.seen if token == "Bearer secret"]
        self.assertEqual(paths[0], "/services/maths/double?timeout_ms=500")
        self.assertEqual(paths[-1], "/services/maths/note?timeout_ms=10000&oneway=true")

    def test_a_problem_is_an_error_with_its_code(self):
        for operation, kind, code in (
            ("jam", "fault", "JAMMED"),
            ("slow", "timeout", "TIMEOUT"),
            ("stopped", "stopped", "STOPPED"),
        ):
            with self.assertRaises(CallError) as caught:
                self.robot.call(f"maths.{operation}")
            self.assertEqual((caught.exception.kind, caught.exception.code), (kind, code))
        with self.assertRaisesRegex(CallError, r"no such component \(did you mean `Arm`\?\)"):
            self.robot.component("Amr")

    def test_it_observes_components(self):
        self.assertEqual(self.robot.services()[0].name, "maths")
        self.assertEqual(self.robot.component("Arm").state, "running")
        self.assertEqual(self.robot.components()[0].name, "Arm")
        self.assertEqual(self.robot.health().state, "DOWN")

    def test_mistakes_say_the_way_out(self):
        with self.assertRaisesRegex(ValueError, "service.operation"):
            self.robot.call("double")
        with self.assertRaisesRegex(AttributeError, "no operation `treble`; it has double, note"):
            self.robot.service("maths", Doubling).treble
        with self.assertRaisesRegex(ValueError, "http://127.0.0.1:8080"):
            asmotion.connect("robot")
        with self.assertRaisesRegex(ValueError, "HTTP gateway") as raised:
            asmotion.connect("amqp://operator:secret@127.0.0.1")
        self.assertNotIn("secret", str(raised.exception))
        with self.assertRaisesRegex(CallError, "does not answer"):
            asmotion.connect("http://127.0.0.1:1")
