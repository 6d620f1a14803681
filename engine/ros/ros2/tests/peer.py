"""A peer of the tests: Cyclone DDS, with types that are made from schemas.

The first argument is the role, the second a JSON object with its settings. Each line of output is an event for the test. The peer
ends when its standard input is closed.
"""

import json
import sys
import threading
import time
from dataclasses import fields

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

PRIMITIVES = {
    "bool": bool,
    "text": str,
    "i8": types.int8,
    "i16": types.int16,
    "i32": types.int32,
    "i64": types.int64,
    "u8": types.uint8,
    "u16": types.uint16,
    "u32": types.uint32,
    "u64": types.uint64,
    "f32": types.float32,
    "f64": types.float64,
}
made = {}


def of_schema(schema, type_name=None):
    """The Python type of a schema; `type_name` is that of a whole message in DDS."""
    shape = schema["shape"]
    if isinstance(shape, str):
        return PRIMITIVES[shape]
    ((kind, content),) = shape.items()
    if kind == "list":
        return types.sequence[of_schema(content)]
    if kind == "array":
        element, count = content
        return types.array[of_schema(element), count]
    name = type_name or schema["name"].replace("/", "::msg::dds_::") + "_"
    if name not in made:
        members = {field["name"]: of_schema(field["schema"]) for field in content}
        members = members or {"structure_needs_at_least_one_member": types.uint8}
        made[name] = make_idl_struct(name.split("::")[-1], name, members)
    return made[name]


def with_header(kind, type_name):
    """The type of a request or reply in the mapping of rmw_cyclonedds."""
    members = {"guid": types.uint64, "seq": types.int64}
    members |= {field.name: kind.__annotations__[field.name] for field in fields(kind)}
    return make_idl_struct(type_name.split("::")[-1], type_name, members)


def qos_of(settings):
    reliable = settings.get("reliable", True)
    transient = settings.get("transient", False)
    depth = settings.get("depth", 10)
    return Qos(
        Policy.Reliability.Reliable(duration(seconds=1)) if reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if transient else Policy.Durability.Volatile,
        Policy.History.KeepLast(depth),
        # as rmw_cyclonedds sets it: the messages for late readers are as many as the depth
        Policy.DurabilityService(0, Policy.History.KeepLast(depth), -1, -1, -1),
    )


def say(*words):
    print(*words, flush=True)


def wait_for(what, seconds=20):
    end = time.monotonic() + seconds
    while not what():
        if time.monotonic() > end:
            sys.exit("a peer was not found")
        time.sleep(0.005)


def take(reader):
    """New messages, as long as standard input is open."""
    while not closed.is_set():
        for sample in reader.take(64):
            if hasattr(sample, "sample_info") and sample.sample_info.valid_data:
                yield sample
        time.sleep(0.001)


closed = threading.Event()


def watch_input():
    sys.stdin.read()
    closed.set()


role, settings = sys.argv[1], json.loads(sys.argv[2])

if role == "bytes":
    # reads and writes the messages of standard input
    for line in sys.stdin:
        entry = json.loads(line)
        kind = of_schema(entry["schema"], entry["type"])
        for message in entry["messages"]:
            print(kind.deserialize(bytes.fromhex(message)).serialize().hex())
    sys.exit()

threading.Thread(target=watch_input, daemon=True).start()
participant = DomainParticipant(settings["domain"])


def topic(name, kind):
    return Topic(participant, name, kind)


if role == "publish":
    kind = of_schema(settings["schema"], settings["type"])
    writer = DataWriter(participant, topic(settings["topic"], kind), qos=qos_of(settings))
    if not settings.get("early"):
        wait_for(lambda: writer.get_publication_matched_status().current_count > 0)
    for message in settings["messages"]:
        writer.write(kind.deserialize(bytes.fromhex(message)))
        time.sleep(settings.get("pause", 0))
    say("sent")
    closed.wait()

elif role == "subscribe":
    kind = of_schema(settings["schema"], settings["type"])
    reader = DataReader(participant, topic(settings["topic"], kind), qos=qos_of(settings))
    say("ready")
    for message in take(reader):
        say(message.serialize().hex())

elif role == "graph":
    kind = of_schema(settings["schema"], settings["type"])
    reader = DataReader(participant, topic("ros_discovery_info", kind), qos=qos_of(settings))
    writer = DataWriter(participant, topic("ros_discovery_info", kind), qos=qos_of(settings))
    gid_kind = type_of_gid = made["rmw_dds_common::msg::dds_::Gid_"]
    node_kind = made["rmw_dds_common::msg::dds_::NodeEntitiesInfo_"]
    own = gid_kind(data=list(participant.guid.bytes))
    node = node_kind(node_namespace="/py", node_name="peer", reader_gid_seq=[own], writer_gid_seq=[])
    writer.write(kind(gid=own, node_entities_info_seq=[node]))
    for message in take(reader):
        for node in message.node_entities_info_seq:
            if node.node_name != "peer":
                readers, writers = len(node.reader_gid_seq), len(node.writer_gid_seq)
                say(node.node_namespace, node.node_name, readers, writers)

elif role == "serve":
    # a server as rmw_cyclonedds has it
    request = with_header(of_schema(settings["request"], "request"), settings["request_type"])
    reply = with_header(of_schema(settings["response"], "response"), settings["response_type"])
    reader = DataReader(participant, topic(settings["requests"], request), qos=qos_of(settings))
    writer = DataWriter(participant, topic(settings["replies"], reply), qos=qos_of(settings))
    say("ready")
    for message in take(reader):
        say("request", message.a, message.b)
        if message.a == -1:
            continue  # never answers
        writer.write(reply(guid=message.guid, seq=message.seq, sum=message.a + message.b))

elif role == "call":
    # a client as rmw_cyclonedds has it
    request = with_header(of_schema(settings["request"], "request"), settings["request_type"])
    reply = with_header(of_schema(settings["response"], "response"), settings["response_type"])
    writer = DataWriter(participant, topic(settings["requests"], request), qos=qos_of(settings))
    reader = DataReader(participant, topic(settings["replies"], reply), qos=qos_of(settings))
    wait_for(lambda: writer.get_publication_matched_status().current_count > 0)
    wait_for(lambda: reader.get_subscription_matched_status().current_count > 0)
    time.sleep(0.2)
    for number in range(settings["calls"]):
        writer.write(request(guid=4711, seq=number, a=number, b=1000))
    for message in take(reader):
        say("reply", message.guid, message.seq, message.sum)

elif role == "action":
    # a server of the action Fibonacci as rclpy and rmw_cyclonedds have it
    kinds = settings["kinds"]
    plain = {name: of_schema(it["schema"], it["type"]) for name, it in kinds.items()}
    headed = {
        name: with_header(plain[name], it["type"])
        for name, it in kinds.items()
        if name not in ("feedback", "status")
    }
    base = settings["action"] + "/_action/"
    qos = qos_of({})

    def half(role_of, name, of):
        if role_of == "reader":
            return DataReader(participant, topic(f"rq{base}{name}Request", headed[of]), qos=qos)
        return DataWriter(participant, topic(f"rr{base}{name}Reply", headed[of]), qos=qos)

    goals, accepted = half("reader", "send_goal", "goal"), half("writer", "send_goal", "accepted")
    ask, results = half("reader", "get_result", "ask"), half("writer", "get_result", "result")
    cancels, cancelled = half("reader", "cancel_goal", "cancel"), half("writer", "cancel_goal", "cancelled")
    feedback = DataWriter(participant, topic(f"rt{base}feedback", plain["feedback"]), qos=qos)
    latched = qos_of({"transient": True, "depth": 1})
    status = DataWriter(participant, topic(f"rt{base}status", plain["status"]), qos=latched)
    time_kind = made["builtin_interfaces::msg::dds_::Time_"]
    info_kind = made["action_msgs::msg::dds_::GoalInfo_"]
    state_kind = made["action_msgs::msg::dds_::GoalStatus_"]
    goal_result = plain["result"].__annotations__["result"]
    feedback_kind = plain["feedback"].__annotations__["feedback"]
    zero = time_kind(sec=0, nanosec=0)
    running = {}
    say("ready")

    def publish(entry, number):
        entry["status"] = number
        state = state_kind(goal_info=info_kind(goal_id=entry["id"], stamp=zero), status=number)
        status.write(plain["status"](status_list=[state]))

    while not closed.is_set():
        for message in goals.take(16):
            fits = message.goal.order >= 0
            accepted.write(headed["accepted"](guid=message.guid, seq=message.seq, accepted=fits, stamp=zero))
            if fits:
                entry = {"id": message.goal_id, "order": message.goal.order, "sequence": [0, 1], "asked": None}
                running[bytes(message.goal_id.uuid)] = entry
                publish(entry, 2)
        for message in ask.take(16):
            running[bytes(message.goal_id.uuid)]["asked"] = (message.guid, message.seq)
        for message in cancels.take(16):
            entry = running[bytes(message.goal_info.goal_id.uuid)]
            publish(entry, 5)
            answer = headed["cancelled"](
                guid=message.guid, seq=message.seq, return_code=0, goals_canceling=[message.goal_info]
            )
            cancelled.write(answer)
        for key, entry in list(running.items()):
            if entry["status"] == 2 and len(entry["sequence"]) <= entry["order"]:
                entry["sequence"].append(entry["sequence"][-1] + entry["sequence"][-2])
                step = feedback_kind(sequence=entry["sequence"])
                feedback.write(plain["feedback"](goal_id=entry["id"], feedback=step))
            elif entry["status"] == 2:
                publish(entry, 4)
            if entry["status"] in (4, 5) and entry["asked"]:
                guid, seq = entry["asked"]
                final = goal_result(sequence=entry["sequence"])
                results.write(headed["result"](guid=guid, seq=seq, status=entry["status"], result=final))
                del running[key]
        time.sleep(0.02)
