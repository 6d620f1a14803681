"""A stranger of docs/wire.md that gives or takes commands, and comes back when its link or the broker does.

    peer.py give URL ROUTING_KEY FIRST_NUMBER full|plain   one command each 20 ms; the same one again until it is confirmed or too old
    peer.py take URL ROUTING_KEY                           prints each command it receives: number, age

A command is a builtin_interfaces/Time: its number, and the time at which it was given, in ms of Unix time modulo 2^32."""
import itertools, json, sys, time
import pika

LIMIT = 0.5  # age in s after which a command is not sent any more

def connected(url):
    while True:
        try:
            return pika.BlockingConnection(pika.URLParameters(url)).channel()
        except Exception:
            time.sleep(0.1)

def clock():
    return int(time.time() * 1000) % 2**32

def give(url, key, first, form):
    channel, begun = None, time.monotonic_ns()
    for number in itertools.count(int(first)):
        given, stamp, last = time.monotonic_ns(), time.time_ns(), None
        body = json.dumps({"sec": number, "nanosec": clock()})
        while (age := time.monotonic_ns() - given) < LIMIT * 1e9:
            try:
                if channel is None:
                    channel = connected(url)
                    channel.exchange_declare("robots", "topic", durable=True)
                    channel.confirm_delivery()
                    continue
                properties = pika.BasicProperties("application/json", delivery_mode=2, type="builtin_interfaces/Time")
                if form == "full":
                    properties.message_id = f"peer{begun}-{number - int(first) + 1}"
                    properties.headers = {"source": "peer", "incarnation": begun, "sequence": number - int(first) + 1,
                        "stamp": stamp, "age": age, "sent": time.monotonic_ns() - begun}
                channel.basic_publish("robots", key, body, properties)
                break
            except Exception:
                channel = None
        print(number, flush=True)
        time.sleep(max(0.0, 0.02 - (time.monotonic_ns() - given) / 1e9))

def take(url, key):
    while True:
        try:
            channel = connected(url)
            channel.exchange_declare("robots", "topic", durable=True)
            channel.queue_declare("robots.taker", durable=True)
            channel.queue_bind("robots.taker", "robots", key)
            print("takes", flush=True)
            for deliver, properties, body in channel.consume("robots.taker"):
                print(properties.headers["sequence"], clock(), properties.message_id, flush=True)
                channel.basic_ack(deliver.delivery_tag)
        except Exception:
            time.sleep(0.1)

{"give": give, "take": take}[sys.argv[1]](*sys.argv[2:])
