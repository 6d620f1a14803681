"""Copies a recording with the package `mcap`, which shares no code with asmotion, and changes the steps of a coordinator.

`edit.py FROM TO MODE`, where MODE is `value` (the value of an update is another one), `forge` (the same, and all hashes are
computed again), `remove` (a step is missing), `lose` (the same, and it is counted as lost), `middle`
(the same for the first step), `frozen` (the first step continues from a
frozen state) or `foreign` (a file of another program)."""
import hashlib, json, sys
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

source, target, mode = sys.argv[1:]
schemas, channels, names, previous, updates, steps = {}, {}, {}, {}, 0, 0


def linked(data, topic):
    """Computes the hashes of a step again."""
    text = data.decode().rsplit(',"previous":"', 1)[0]
    text += f',"previous":"{previous.get(topic, "0" * 32)}"'
    previous[topic] = hashlib.sha256(text.encode()).hexdigest()[:32]
    return f'{text},"hash":"{previous[topic]}"}}'.encode()


with open(source, "rb") as file, open(target, "wb") as out:
    writer = Writer(out, chunk_size=1 << 16, compression=CompressionType.NONE)
    writer.start(library="edit.py")
    for record in StreamReader(file).records:
        if isinstance(record, Schema):
            schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
        elif isinstance(record, Channel):
            names[record.id] = record.topic
            schema = schemas[record.schema_id]
            channels[record.id] = writer.register_channel(
                record.topic, record.message_encoding, schema, record.metadata)
        elif isinstance(record, Attachment):
            writer.add_attachment(record.create_time, record.log_time, record.name, record.media_type, record.data)
        elif isinstance(record, Metadata):
            if mode != "foreign":
                facts = dict(record.metadata)
                if mode in ("lose", "middle") and record.name == "asmotion.end":
                    facts["lost"] = "1"
                    facts.update({name: "1" for name in facts if name.endswith(".lost")})
                if mode == "forge" and record.name == "asmotion.end":
                    for topic, last in previous.items():
                        facts[topic.split("/")[1] + ".last_hash"] = last
                writer.add_metadata(record.name, facts)
        elif isinstance(record, Message):
            topic, data = names[record.channel_id], record.data
            if topic.startswith("asm/"):
                steps += 1
                if mode in ("remove", "lose") and steps == 40 or mode == "middle" and steps == 1:
                    continue
                if mode in ("value", "forge"):
                    # the second step with an update of `mode`
                    if b'"location":"mode"' in data:
                        updates += 1
                        if updates == 2:
                            before = json.loads(data)["updates"]
                            after = next(it["after"] for it in before if it["location"] == "mode")
                            data = data.replace(f'"after":"{after}"'.encode(), b'"after":"STOPPING"')
                if mode == "frozen":
                    data = data.replace(b'"kind":"initial"', b'"kind":"frozen"')
                if mode == "forge":
                    data = linked(data, topic)
            writer.add_message(
                channels[record.channel_id], record.log_time, data, record.publish_time, record.sequence)
    writer.finish()
