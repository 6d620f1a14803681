"""A viewer in the protocol of Foxglove, from packages that know nothing of asmotion.

Usage: viewer.py ADDRESS SECONDS. Subscribes to every channel, decodes every message by the schema of its channel, and prints for
each channel its schema, the number of messages, and the last one, as JSON.
"""

import json
import sys
import time

import jsonschema
from mcap_ros2._dynamic import generate_dynamic
from websockets.sync.client import connect

PROTOCOLS = ["foxglove.sdk.v1", "foxglove.websocket.v1"]


def plain(value):
    """A decoded message of ROS as JSON."""
    slots = getattr(value, "__slots__", None)
    if slots:
        return {name: plain(getattr(value, name)) for name in slots}
    if hasattr(value, "__dict__"):
        return {name: plain(item) for name, item in vars(value).items()}
    if isinstance(value, (list, tuple)) or hasattr(value, "tolist"):
        return [plain(item) for item in value][:8]
    return value


def decoder(channel):
    """The function that decodes the messages of a channel, and checks them against its schema."""
    combination = channel["encoding"], channel["schemaEncoding"]
    if combination == ("cdr", "ros2msg"):
        decode = generate_dynamic(channel["schemaName"], channel["schema"])[channel["schemaName"]]
        return lambda data: plain(decode(data))
    assert combination == ("json", "jsonschema"), combination
    schema = json.loads(channel["schema"])
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)

    def checked(data):
        message = json.loads(data)
        validator.validate(message)
        return message

    return checked


def main(address, seconds):
    channels, decoders, seen, times, said = {}, {}, {}, [], []
    with connect(f"ws://{address}/foxglove", subprotocols=PROTOCOLS, max_size=None) as socket:
        assert socket.subprotocol == PROTOCOLS[0], socket.subprotocol
        info = json.loads(socket.recv())
        assert info["op"] == "serverInfo", info
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            message = socket.recv()
            if isinstance(message, str):
                message = json.loads(message)
                if message["op"] == "status":
                    said.append(message["message"])
                new = message.get("channels", [])
                for channel in new:
                    channels[channel["id"]] = channel
                    decoders[channel["id"]] = decoder(channel)
                    seen[channel["topic"]] = {"schema": channel["schemaName"], "count": 0, "last": None}
                if new:
                    wanted = [{"id": it["id"] + 1000, "channelId": it["id"]} for it in new]
                    socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
            elif message[0] == 2:
                times.append(int.from_bytes(message[1:9], "little"))
            else:
                assert message[0] == 1, message[0]
                channel = channels[int.from_bytes(message[1:5], "little") - 1000]
                entry = seen[channel["topic"]]
                entry["count"] += 1
                entry["last"] = decoders[channel["id"]](bytes(message[13:]))
                entry["at"] = int.from_bytes(message[5:13], "little")
                entry.setdefault("first_at", entry["at"])
    assert times == sorted(times), "the time goes back"
    print(json.dumps({"info": info, "channels": seen, "times": len(times), "said": said}))


main(sys.argv[1], float(sys.argv[2]))
