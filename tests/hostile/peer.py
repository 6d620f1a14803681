"""A stranger with credentials that sends what it likes, and prints what it hears.

    peer.py URL [ROUTING_KEY...]

Each line of standard input is a message to send, as JSON: key, body (a text, sent as it is), and optionally id, user and
headers. Each message heard is a line of output: key, content, id."""
import json, os, select, sys
import cbor2, pika

url, *keys = sys.argv[1:]
connection = pika.BlockingConnection(pika.URLParameters(url))
channel = connection.channel()
channel.exchange_declare("robots", "topic", durable=True)

def heard(_channel, method, properties, body):
    content = (cbor2 if "cbor" in properties.content_type else json).loads(body)
    message = {"key": method.routing_key, "content": content, "id": properties.message_id}
    print(json.dumps(message, default=str), flush=True)

def send(message):
    properties = pika.BasicProperties("application/json", message_id=message.get("id"), user_id=message.get("user"),
        headers=message.get("headers"))
    channel.basic_publish("robots", message["key"], message["body"].encode(), properties)

if keys:
    queue = channel.queue_declare("", exclusive=True).method.queue
    for key in keys:
        channel.queue_bind(queue, "robots", key)
    channel.basic_consume(queue, heard, auto_ack=True)
print(json.dumps({"key": ""}), flush=True)
rest = b""
while True:
    connection.process_data_events(time_limit=0.01)
    if select.select([0], [], [], 0)[0]:
        read = os.read(0, 1 << 20)
        if not read:
            break
        *lines, rest = (rest + read).split(b"\n")
        for line in lines:
            send(json.loads(line))
connection.close()
