"""Reads a recording with the package `mcap`, which shares no code with asmotion, and prints what is in it as JSON.

A file that was cut has no index, so that all are read from front to back. The hash chain of the steps is computed again."""
import hashlib, json, sys
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader

schemas, channels, counts, texts, facts = {}, {}, {}, {}, {}
chain, broken, messages, cut = {}, [], hashlib.sha256(), None
with open(sys.argv[1], "rb") as file:
    try:
        for record in StreamReader(file).records:
            if isinstance(record, Schema):
                if record.encoding == "jsonschema":
                    json.loads(record.data)
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Attachment):
                texts[record.name] = record.data.decode()
            elif isinstance(record, Metadata):
                facts[record.name] = record.metadata
            elif isinstance(record, Message):
                channel = channels[record.channel_id]
                counts[channel.topic] = counts.get(channel.topic, 0) + 1
                messages.update(f"{channel.topic} {record.log_time} ".encode() + record.data)
                encodings = (channel.message_encoding, schemas[channel.schema_id].encoding)
                if encodings == ("cdr", "ros2msg"):
                    continue
                assert encodings == ("json", "jsonschema"), channel
                value = json.loads(record.data)
                if channel.topic.startswith("asm/"):
                    hashed = record.data.decode().rsplit(',"hash":"', 1)[0]
                    is_next = value["previous"] == chain.get(channel.topic, "0" * 32)
                    if not is_next or value["hash"] != hashlib.sha256(hashed.encode()).hexdigest()[:32]:
                        broken.append(value["number"])
                    chain[channel.topic] = value["hash"]
    except Exception as error:
        cut = type(error).__name__
print(json.dumps({"counts": counts, "texts": texts, "facts": facts, "chain": chain, "broken": broken,
    "messages": messages.hexdigest(), "cut": cut}))
