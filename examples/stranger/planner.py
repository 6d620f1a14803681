"""Plans paths over RabbitMQ in place of the built-in planner, following docs/wire.md: planner.py URL ROBOT ADDRESS"""
import heapq, itertools, json, math, sys
import cbor2, pika

READ = {"application/cbor": cbor2.loads, "application/json": json.loads}
STRIDE, NEAR = 3, range(-2, 3)  # map cells per planner cell; planner cells kept free around walls
STEPS = [step for step in itertools.product((-1, 0, 1), repeat=2) if any(step)]

def plan(request):
    grid, goal = request["map"], request["goal"]["pose"]
    info, cells = grid["info"], grid["data"]
    if isinstance(cells, cbor2.CBORTag):  # RFC 8746: signed bytes
        cells = cells.value
    wide, size, corner = info["width"], info["resolution"] * STRIDE, info["origin"]["position"]
    walls = {(i % wide // STRIDE, i // wide // STRIDE) for i, cell in enumerate(cells) if cell & 255 > 50}
    walls = {(x + near, y) for x, y in walls for near in NEAR}
    walls = {(x, y + near) for x, y in walls for near in NEAR}
    cell = lambda pose: tuple(int((pose["position"][axis] - corner[axis]) // size) for axis in "xy")
    first, last = cell(request["start"]["pose"]), cell(goal)
    came, costs, border = {first: None}, {first: 0.0}, [(0.0, first)]
    while border and (here := heapq.heappop(border)[1]) != last:
        for dx, dy in STEPS:
            there, cost = (here[0] + dx, here[1] + dy), costs[here] + math.hypot(dx, dy)
            inside = 0 <= there[0] < wide // STRIDE and 0 <= there[1] < info["height"] // STRIDE
            if inside and there not in walls and cost < costs.get(there, math.inf):
                came[there], costs[there] = here, cost
                heapq.heappush(border, (cost + math.dist(there, last), there))
    way, at = [], came[last]  # a KeyError if there is no path
    while at:
        way, at = [at, *way], came[at]
    poses = [{"position": {axis: corner[axis] + (c + 0.5) * size for axis, c in zip("xy", at)}} for at in way]
    return {"header": grid["header"], "poses": [{"header": grid["header"], "pose": p} for p in [*poses, goal]]}

answered = {}  # a request received twice is answered twice, but executed once

def asked(channel, deliver, request, body):
    key = (request.user_id, request.correlation_id)
    if request.type == "request" and key not in answered:
        try:
            answered[key] = "result", {}, "application/cbor", cbor2.dumps(plan(READ[request.content_type](body)))
        except Exception as fault:
            answered[key] = "refusal", {"code": "NO_PATH"}, "text/plain", repr(fault).encode()
    unknown = ("unavailable", {}, "application/cbor", b"") if request.type == "enquiry" else None
    if request.type in ("request", "enquiry") and (answer := answered.get(key, unknown)):
        kind, more, content_type, content = answer
        properties = pika.BasicProperties(content_type, type=kind, headers=more, correlation_id=key[1])
        channel.basic_publish("", request.reply_to, content, properties)
    channel.basic_ack(deliver.delivery_tag)
    while len(answered) > 4096:
        answered.pop(next(iter(answered)))

url, robot, address = sys.argv[1:]
channel = pika.BlockingConnection(pika.URLParameters(url)).channel()
channel.exchange_declare("robots.services", "direct", durable=True)
queue = channel.queue_declare(f"robots.services.{robot}.{address}", exclusive=True).method.queue
channel.queue_bind(queue, "robots.services", f"{robot}.{address}")
channel.basic_consume(queue, asked)
print("serves", address, flush=True)
channel.start_consuming()
