"""Reads messages of ROS 1 with genpy, and writes them again.

Standard input has a line for each message type, in JSON: its name, its definition with those of all messages in it, its MD5
sum, and messages in hexadecimal digits. For each message, a line with its bytes as genpy writes them goes to standard output.
"""

import io
import json
import sys

from genpy.dynamic import generate_dynamic

for line in sys.stdin:
    entry = json.loads(line)
    classes = generate_dynamic(entry["name"], entry["text"])
    message_class = classes[entry["name"]]
    if message_class._md5sum != entry["md5"]:
        sys.exit(f"{entry['name']}: {message_class._md5sum} is not {entry['md5']}")
    for message in entry["messages"]:
        value = message_class()
        value.deserialize(bytes.fromhex(message))
        written = io.BytesIO()
        value.serialize(written)
        print(written.getvalue().hex())
