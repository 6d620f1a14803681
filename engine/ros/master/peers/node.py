"""A node of ROS 1 that does what its standard input says, and prints what it receives, both as lines of JSON.

Argument: name of the node. Commands, each a list:
    ["publish", topic, type, message, is_latched]    publishes a message; the first time, waits for nothing
    ["subscribe", topic, type]                       prints ["message", topic, message, name of the publisher]
    ["connections", topic, number]                   waits until a topic of this node has so many connections
    ["flood", topic, type, message, number, rate]    publishes a message so many times; a field `data` counts
    ["stream", topic, type, message, field, first, rate]
                                                     publishes a message for ever, and counts in a field such as `linear.x`
    ["provide", service, type, behaviour]            prints ["request", service, request]; behaviour: a response `reply`, an
                                                     `error`, a `delay` in seconds, or `die`; again to change it
    ["call", service, type, request]                 prints ["response", service, response] or ["error", service, text]
    ["act", action, type, behaviour]                 an action server that replaces goals; prints ["goal", action, goal] and
                                                     ["preempted", action]; behaviour: `steps` of 0.05 s, `feedback`, `end`
                                                     (succeeded, aborted), `text`, `result`; again to change it
    ["reject", action, type]                         an action server that rejects all goals; prints ["goal", action, goal]
    ["send", action, type, goal]                     prints ["feedback", action, feedback] and ["end", action, status, text, result]
    ["cancel", action]                               cancels the goal
    ["define", type, text]                           makes the classes of a message from its definition, as in a connection header
    ["set", parameter, value], ["get", parameter]    the latter prints ["value", parameter, value]
Each command is answered with ["done", command].
"""

import importlib
import json
import os
import sys
import threading
import time
import types

import genpy
import genpy.dynamic
import roslib.message
import rospy

print_lock = threading.Lock()
publishers, subscribers, providers, servers, clients, goals, behaviours = {}, {}, {}, {}, {}, {}, {}


def say(what):
    with print_lock:
        print(json.dumps(what), flush=True)


def plain(value):
    """A message as JSON has it."""
    if isinstance(value, genpy.Message):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, (genpy.Time, genpy.Duration)):
        return {"secs": value.secs, "nsecs": value.nsecs}
    if isinstance(value, bytes):
        return list(value)
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value


def publisher(topic, type_name, latched=False):
    if topic not in publishers:
        message_class = roslib.message.get_message_class(type_name)
        publishers[topic] = rospy.Publisher(topic, message_class, queue_size=10000, latch=latched, tcp_nodelay=True)
    return publishers[topic]


def fill(message, value):
    genpy.message.fill_message_args(message, [value])
    return message


def filled(of, value):
    return fill(of.data_class(), value)


def define(type_name, text):
    for name, message_class in genpy.dynamic.generate_dynamic(type_name, text).items():
        package, short = name.split("/")
        if package not in sys.modules:
            sys.modules[package] = types.ModuleType(package)
            sys.modules[package].msg = sys.modules[package + ".msg"] = types.ModuleType(package + ".msg")
        if package != "std_msgs":
            setattr(sys.modules[package + ".msg"], short, message_class)


def subscribe(topic, type_name):
    message_class = roslib.message.get_message_class(type_name)

    def receive(message):
        say(["message", topic, plain(message), message._connection_header.get("callerid")])

    subscribers[topic] = rospy.Subscriber(topic, message_class, receive, tcp_nodelay=True)


def provide(service, type_name, behaviour):
    behaviours[service] = behaviour
    if service in providers:
        return
    service_class = roslib.message.get_service_class(type_name)

    def answer(request):
        now = behaviours[service]
        say(["request", service, plain(request)])
        if now.get("die"):
            os._exit(1)
        rospy.sleep(now.get("delay", 0))
        if "error" in now:
            raise rospy.ServiceException(now["error"])
        return fill(service_class._response_class(), now.get("reply", {}))

    providers[service] = rospy.Service(service, service_class, answer)


def call(service, type_name, request):
    service_class = roslib.message.get_service_class(type_name)

    def run():
        try:
            rospy.wait_for_service(service, 20)
            response = rospy.ServiceProxy(service, service_class)(fill(service_class._request_class(), request))
            say(["response", service, plain(response)])
        except Exception as error:
            say(["error", service, str(error)])

    threading.Thread(target=run, daemon=True).start()


def messages_of_action(type_name):
    package, name = type_name.split("/")
    module = importlib.import_module(package + ".msg")
    return [getattr(module, name + suffix) for suffix in ("Action", "Goal", "Result", "Feedback")]


def act(action, type_name, behaviour):
    import actionlib

    behaviours[action] = behaviour
    if action in servers:
        return
    action_class, _, result_class, feedback_class = messages_of_action(type_name)

    def execute(goal):
        now = behaviours[action]
        say(["goal", action, plain(goal)])
        result, text = fill(result_class(), now.get("result", {})), now.get("text", "")
        for _ in range(now.get("steps", 0)):
            if server.is_preempt_requested():
                say(["preempted", action])
                server.set_preempted(result, "preempted")
                return
            if "feedback" in now:
                server.publish_feedback(fill(feedback_class(), now["feedback"]))
            rospy.sleep(0.05)
        getattr(server, "set_" + now.get("end", "succeeded"))(result, text)

    server = actionlib.SimpleActionServer(action, action_class, execute, auto_start=False)
    servers[action] = server
    server.start()


def reject_goals(action, type_name):
    """An action server that rejects every goal."""
    import actionlib

    action_class, _, result_class, _ = messages_of_action(type_name)

    def refuse(handle):
        say(["goal", action, plain(handle.get_goal())])
        handle.set_rejected(result_class(), "not today")

    server = actionlib.ActionServer(action, action_class, refuse, auto_start=False)
    servers[action] = server
    server.start()


def send(action, type_name, goal):
    import actionlib
    from actionlib_msgs.msg import GoalStatus

    action_class, goal_class, _, _ = messages_of_action(type_name)
    if action not in clients:
        # SimpleActionClient misses the transitions of a goal that begins before it has its handle
        clients[action] = actionlib.ActionClient(action, action_class)
    client = clients[action]

    def changed(handle):
        if handle.get_comm_state() == actionlib.CommState.DONE:
            status = GoalStatus.to_string(handle.get_terminal_state())
            say(["end", action, status, handle.get_goal_status_text(), plain(handle.get_result())])

    def run():
        if not client.wait_for_server(rospy.Duration(60)):
            return say(["error", action, "no server"])
        told = lambda _, feedback: say(["feedback", action, plain(feedback)])
        goals[action] = client.send_goal(fill(goal_class(), goal), changed, told)
        say(["sent", action])

    threading.Thread(target=run, daemon=True).start()


def flood(topic, type_name, value, number, rate):
    of = publisher(topic, type_name)
    pace = rospy.Rate(rate)
    for count in range(number):
        message = filled(of, value)
        if hasattr(message, "data"):
            message.data = type(message.data)(count)
        of.publish(message)
        pace.sleep()


def stream(topic, type_name, value, path, first, rate):
    of = publisher(topic, type_name)
    message = filled(of, value)
    *records, last = path.split(".")
    record = message
    for field in records:
        record = getattr(record, field)

    def run():
        begun, sent = time.monotonic(), 0
        while not rospy.is_shutdown():
            setattr(record, last, first + sent)
            of.publish(message)
            sent += 1
            time.sleep(max(0, begun + sent / rate - time.monotonic()))

    threading.Thread(target=run, daemon=True).start()


def await_connections(topic, number):
    # rospy counts connections of a subscriber before it opens them
    of = publishers.get(topic)
    subscribed = lambda: sum(connection.header is not None for connection in subscribers[topic].impl.connections)
    while (of.get_num_connections() if of else subscribed()) < number:
        rospy.sleep(0.01)


def publish(topic, type_name, value, latched):
    of = publisher(topic, type_name, latched)
    of.publish(filled(of, value))


commands = {
    "publish": publish,
    "advertise": publisher,
    "subscribe": subscribe,
    "connections": await_connections,
    "flood": flood,
    "stream": stream,
    "provide": provide,
    "call": call,
    "act": act,
    "reject": reject_goals,
    "send": send,
    "cancel": lambda action: goals[action].cancel(),
    "define": define,
    "set": rospy.set_param,
    "get": lambda name: say(["value", name, rospy.get_param(name, None)]),
}

rospy.init_node(sys.argv[1].lstrip("/"), disable_signals=True)
say(["ready"])
for line in sys.stdin:
    command = json.loads(line)
    commands[command[0]](*command[1:])
    say(["done", command[0]])
rospy.signal_shutdown("end")
