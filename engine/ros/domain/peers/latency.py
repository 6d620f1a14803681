"""One end of a measurement: how long messages of Cyclone DDS in Python are on their way, and how many pass.

Argument: `send` or `receive`. The first line of the input has settings in JSON: domain, topic, type, schema, message (hexadecimal digits), for the sender count and rate
(0: as fast as possible). The sender begins when its input has a line. The receiver answers each line of its input with the times of
transit in µs, and the messages per second between the first and the last.
"""

import json
import sys
import threading
import time

from cyclonedds.core import Listener, Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from dds_types import of_schema

role, settings = sys.argv[1], json.loads(sys.stdin.readline())
kind = of_schema(settings["schema"], settings["type"])
qos = Qos(Policy.Reliability.Reliable(duration(seconds=10)), Policy.History.KeepAll)
participant = DomainParticipant(settings["domain"])
topic = Topic(participant, settings["topic"], kind)


def stamp(message):
    now = time.monotonic_ns()
    if hasattr(message, "linear"):
        message.linear.x = now / 1e9
    else:
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(now, 1_000_000_000)


def age(message):
    now = time.monotonic_ns()
    if hasattr(message, "linear"):
        return now / 1e3 - message.linear.x * 1e6
    return (now - message.header.stamp.sec * 1_000_000_000 - message.header.stamp.nanosec) / 1e3


if role == "send":
    writer = DataWriter(participant, topic, qos=qos)
    while writer.get_publication_matched_status().current_count == 0:
        time.sleep(0.01)
    time.sleep(0.5)
    print("ready", flush=True)
    sys.stdin.readline()
    message = kind.deserialize(bytes.fromhex(settings["message"]))
    begun = time.monotonic()
    for number in range(settings["count"]):
        if settings["rate"]:
            time.sleep(max(0, begun + number / settings["rate"] - time.monotonic()))
        stamp(message)
        writer.write(message)
    print("sent", flush=True)
    sys.stdin.readline()
else:
    ages, times = [], []
    lock = threading.Lock()

    class Receiver(Listener):
        def on_data_available(self, reader):
            for sample in reader.take(64):
                with lock:
                    ages.append(age(sample))
                    times.append(time.monotonic())

    reader = DataReader(participant, topic, qos=qos, listener=Receiver())
    print("ready", flush=True)
    for _ in sys.stdin:
        while not times or time.monotonic() - times[-1] < 0.5:
            time.sleep(0.05)
        pace = (len(times) - 1) / (times[-1] - times[0]) if len(times) > 1 else 0
        print(json.dumps({"ages": ages, "pace": pace}), flush=True)
        with lock:
            ages, times = [], []
