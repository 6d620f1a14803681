"""A stranger of docs/wire.md that gives or takes commands, and comes back when its link or the broker does.

    peer.py give URL ROUTING_KEY FIRST_NUMBER full|plain   one command each 20 ms; the same one again until it is confirmed or too old
    peer.py take URL ROUTING_KEY                           obeys commands that are not too old; prints each with the time of its arrival
    peer.py watch URL ROUTING_KEY                          prints each message it receives

`give` sends builtin_interfaces/Time: the number of a command, and the time at which it was given, in ms of Unix time modulo
2^32."""
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

class Ages:
    """Age of each message by its headers, as docs/wire.md describes it."""

    def __init__(self):
        self.fastest, self.last, self.backlog, self.away = {}, time.monotonic_ns(), 0, 0

    def begin(self, backlog):
        self.backlog, self.away, self.last = backlog, time.monotonic_ns() - self.last, time.monotonic_ns()

    def of(self, properties):
        now, headers = time.monotonic_ns(), properties.headers
        self.last, was_queued, self.backlog = now, self.backlog > 0, max(0, self.backlog - 1)
        stream, transit = properties.message_id.rsplit("-", 1)[0], now - headers["sent"]
        if stream not in self.fastest and was_queued:
            return headers["age"] + self.away
        self.fastest[stream] = min(transit, self.fastest.get(stream, transit))
        return headers["age"] + transit - self.fastest[stream]

def take(url, key):
    ages, seen, queue, is_new = Ages(), set(), "robots.taker", True
    say = lambda *words: print(json.dumps(words), flush=True)
    while True:
        try:
            channel = connected(url)
            channel.exchange_declare("robots", "topic", durable=True)
            declared = channel.queue_declare(queue, durable=True)
            channel.queue_bind(queue, "robots", key)
            if is_new:  # what was sent before it started is not for it
                say("purged", channel.queue_purge(queue).method.message_count)
            ages.begin(0 if is_new else declared.method.message_count)
            is_new = False
            for deliver, properties, body in channel.consume(queue):
                age, clock_now, headers = ages.of(properties), clock(), properties.headers
                if properties.message_id not in seen:
                    seen.add(properties.message_id)
                    word = "took" if age <= LIMIT * 1e9 else "discarded"
                    say(word, headers["incarnation"], headers["sequence"], json.loads(body)["data"], clock_now)
                channel.basic_ack(deliver.delivery_tag)
        except Exception:
            time.sleep(0.1)

def watch(url, key):
    channel = connected(url)
    channel.exchange_declare("robots", "topic", durable=True)
    queue = channel.queue_declare("", exclusive=True).method.queue
    channel.queue_bind(queue, "robots", key)
    print("watches", flush=True)
    for _, _, body in channel.consume(queue, auto_ack=True):
        print(json.dumps(json.loads(body)), flush=True)

{"give": give, "take": take, "watch": watch}[sys.argv[1]](*sys.argv[2:])
