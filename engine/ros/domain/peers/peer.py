"""A peer of the tests: Cyclone DDS, with types that are made from schemas.

The first argument is the role, the second a JSON object with its settings. Each line of output is an event for the test. The peer
ends when its standard input is closed.
"""

import json
import random
import sys
import threading
import time
from dataclasses import fields

from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from dds_action import ActionClient
from dds_types import made, of_schema, qos_of, value_of, with_header


def say(*words):
    print(*words, flush=True)


def wait_for(what, seconds=60):
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
    if role != "obey":
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

if role == "generate":
    # writes messages that it makes up, of the types of standard input, equal in each run
    chance = random.Random(7)
    for line in sys.stdin:
        entry = json.loads(line)
        kind = of_schema(entry["schema"], entry["type"])
        for _ in range(entry["count"]):
            print(value_of(entry["schema"], chance, kind).serialize().hex())
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

elif role == "obey":
    # a node that does what its input says: each line is a command
    readers, writers, held, clients, actors = {}, {}, set(), {}, {}
    gid_kind = make_idl_struct("Gid_", "rmw_dds_common::msg::dds_::Gid_", {"data": types.array[types.uint8, 16]})
    node_kind = make_idl_struct(
        "NodeEntitiesInfo_",
        "rmw_dds_common::msg::dds_::NodeEntitiesInfo_",
        {
            "node_namespace": str,
            "node_name": str,
            "reader_gid_seq": types.sequence[gid_kind],
            "writer_gid_seq": types.sequence[gid_kind],
        },
    )
    graph_kind = make_idl_struct(
        "ParticipantEntitiesInfo_",
        "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
        {"gid": gid_kind, "node_entities_info_seq": types.sequence[node_kind]},
    )
    latched = qos_of({"transient": True, "depth": 1})
    graph = DataWriter(participant, topic("ros_discovery_info", graph_kind), qos=latched)
    output = threading.Lock()

    def told(*words):
        with output:
            say(*words)

    def gid(entity):
        return gid_kind(data=list(entity.guid.bytes))

    def publish_graph():
        node = node_kind(
            node_namespace="/",
            node_name=settings["name"],
            reader_gid_seq=[gid(it) for it, _ in readers.values()],
            writer_gid_seq=[gid(it) for it, _ in writers.values()],
        )
        graph.write(graph_kind(gid=gid(participant), node_entities_info_seq=[node]))

    def read_all():
        while not closed.is_set():
            for name, (reader, _) in list(readers.items()):
                if name in held:
                    continue
                for sample in reader.take(64):
                    if hasattr(sample, "sample_info") and sample.sample_info.valid_data:
                        with output:
                            say(name, sample.serialize().hex())
            time.sleep(0.001)

    def stream(name, digits, path, first, rate):
        """Publishes a message for ever, and counts in one of its fields."""
        writer, kind = writers[name]
        message = kind.deserialize(bytes.fromhex(digits))
        *records, last = path.split(".")
        record = message
        for field in records:
            record = getattr(record, field)
        begun, sent = time.monotonic(), 0
        while not closed.is_set():
            setattr(record, last, first + sent)
            writer.write(message)
            sent += 1
            time.sleep(max(0, begun + sent / rate - time.monotonic()))

    threading.Thread(target=read_all, daemon=True).start()
    say("ready")
    for line in sys.stdin:
        verb, name, *rest = json.loads(line)
        if verb in ("subscribe", "advertise"):
            kind = of_schema(rest[1], rest[0])
            half, known = (DataReader, readers) if verb == "subscribe" else (DataWriter, writers)
            known[name] = (half(participant, topic("rt" + name, kind), qos=qos_of(rest[2])), kind)
            publish_graph()
        elif verb == "publish":
            writer, kind = writers[name]
            writer.write(kind.deserialize(bytes.fromhex(rest[0])))
        elif verb == "stream":
            threading.Thread(target=stream, args=(name, *rest), daemon=True).start()
        elif verb == "burst":
            # many messages at once
            writer, kind = writers[name]
            for message in [kind.deserialize(bytes.fromhex(digits)) for digits in rest[0]]:
                writer.write(message)
        elif verb == "client":
            # a client as rmw_cyclonedds has it
            of, reply_of = rest
            plain, reply_plain = of_schema(of["schema"], of["type"]), of_schema(reply_of["schema"], reply_of["type"])
            request, response = with_header(plain, of["type"]), with_header(reply_plain, reply_of["type"])
            asks = DataWriter(participant, topic("rq" + name + "Request", request), qos=qos_of({}))
            answers = DataReader(participant, topic("rr" + name + "Reply", response), qos=qos_of({}))
            wait_for(lambda: asks.get_publication_matched_status().current_count > 0)
            wait_for(lambda: answers.get_subscription_matched_status().current_count > 0)
            time.sleep(0.2)
            clients[name] = (asks, answers, plain, request, reply_plain)
        elif verb == "call":
            asks, answers, plain, request, reply_plain = clients[name]
            number = time.monotonic_ns()
            message = plain.deserialize(bytes.fromhex(rest[0]))
            asks.write(request(guid=4711, seq=number, **{it.name: getattr(message, it.name) for it in fields(plain)}))
            found = []

            def answered():
                for sample in answers.take(16):
                    if hasattr(sample, "sample_info") and sample.sample_info.valid_data and sample.seq == number:
                        found.append(reply_plain(**{it.name: getattr(sample, it.name) for it in fields(reply_plain)}))
                return bool(found)

            wait_for(answered)
            with output:
                say("answer", found[0].serialize().hex())
        elif verb == "actor":
            # a client of an action
            actors[name] = ActionClient(participant, name, rest[0], told)
            wait_for(actors[name].is_ready)
            time.sleep(0.2)
        elif verb == "goal":
            actors[name].send(rest[0])
        elif verb == "cancel":
            actors[name].cancel()
        elif verb == "hold":
            held.add(name)
        elif verb == "release":
            held.remove(name)
        elif verb == "subscribers":
            writer, _ = writers[name]
            wait_for(lambda: writer.get_publication_matched_status().current_count >= rest[0])
            # the other side may match later, on a busy machine much later
            time.sleep(1)
        elif verb == "publishers":
            reader, _ = readers[name]
            wait_for(lambda: reader.get_subscription_matched_status().current_count >= rest[0])
            time.sleep(1)
        with output:
            say("done")
    closed.set()

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
