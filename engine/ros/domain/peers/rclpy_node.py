"""A node of ROS 2 itself (rclpy on Fast DDS) that does what its standard input says, and prints what it receives, as lines of JSON.

Arguments: name of the node. Commands, each a list:
    ["publish", topic, type, message, is_latched]  publishes a message
    ["subscribe", topic, type, is_latched]         prints ["message", topic, message]
    ["matches", topic, number]                     waits until a topic of this node has so many matches
    ["provide", service, type, response]           prints ["request", service, request], and answers with the response
    ["call", service, type, request]               prints ["response", service, response]
    ["act", action, type, steps]                   an action server; prints ["goal", action, goal], gives as many steps of feedback, and
                                                   ends with the goal's order as the only element of the result
    ["send", action, type, goal]                   prints ["feedback", action, feedback] and ["end", action, status, result], or
                                                   ["rejected", action]
    ["cancel", action]                             cancels the goal; prints ["cancelling", action, number of goals]
    ["nodes"]                                      prints ["nodes", names]
Types are like those of files, such as `std_srvs/srv/SetBool`. Each command is answered with ["done", command].
"""

import importlib
import json
import sys
import threading
import time

import rclpy
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile

print_lock = threading.Lock()
entities, clients, handles = {}, {}, {}


def say(*what):
    with print_lock:
        print(json.dumps(what), flush=True)


def kind(name):
    package, folder, short = name.split("/")
    return getattr(importlib.import_module(f"{package}.{folder}"), short)


def plain(value):
    """A message as JSON has it."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, (str, bool, int, float)):
        return value
    return [plain(item) for item in value]


def fill(message, value):
    """Sets the fields of a message."""
    for name, content in value.items():
        inner = getattr(message, name)
        if hasattr(inner, "get_fields_and_field_types"):
            fill(inner, content)
        else:
            setattr(message, name, content)
    return message


def quality(is_latched):
    durability = DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE
    return QoSProfile(depth=100, durability=durability)


def publish(topic, of, value, is_latched=False):
    if topic not in entities:
        entities[topic] = node.create_publisher(kind(of), topic, quality(is_latched))
    if value is not None:
        entities[topic].publish(fill(kind(of)(), value))


def subscribe(topic, of, is_latched=False):
    def receive(message):
        say("message", topic, plain(message))

    entities[topic] = node.create_subscription(kind(of), topic, receive, quality(is_latched))


def matches(topic, number):
    count = node.count_subscribers if hasattr(entities[topic], "publish") else node.count_publishers
    wait_for(lambda: count(topic) >= number)


def wait_for(what):
    end = time.monotonic() + 60
    while not what():
        if time.monotonic() > end:
            sys.exit("a peer was not found")
        time.sleep(0.005)


def provide(service, of, response):
    def answer(request, reply):
        say("request", service, plain(request))
        return fill(reply, response)

    entities[service] = node.create_service(kind(of), service, answer, callback_group=group)


def call(service, of, request):
    if service not in clients:
        clients[service] = node.create_client(kind(of), service, callback_group=group)
    client = clients[service]
    wait_for(client.service_is_ready)
    future = client.call_async(fill(kind(of).Request(), request))
    future.add_done_callback(lambda done: say("response", service, plain(done.result())))


def act(action, of, steps):
    kinds = kind(of)

    def execute(goal):
        say("goal", action, plain(goal.request))
        for step in range(steps):
            if goal.is_cancel_requested:
                goal.canceled()
                return kinds.Result()
            goal.publish_feedback(kinds.Feedback(sequence=[step]))
            time.sleep(0.05)
        goal.succeed()
        return kinds.Result(sequence=[goal.request.order])

    entities[action] = ActionServer(
        node,
        kinds,
        action,
        execute,
        cancel_callback=lambda _: CancelResponse.ACCEPT,
        callback_group=group,
    )


def send(action, of, goal):
    kinds = kind(of)
    if action not in clients:
        clients[action] = ActionClient(node, kinds, action, callback_group=group)
    client = clients[action]
    wait_for(client.server_is_ready)

    def ended(done):
        say("end", action, done.result().status, plain(done.result().result))

    def accepted(done):
        if not done.result().accepted:
            return say("rejected", action)
        handles[action] = done.result()
        say("accepted", action)
        handles[action].get_result_async().add_done_callback(ended)

    told = lambda message: say("feedback", action, plain(message.feedback))
    client.send_goal_async(fill(kinds.Goal(), goal), feedback_callback=told).add_done_callback(accepted)


def cancel(action):
    future = handles[action].cancel_goal_async()
    future.add_done_callback(lambda done: say("cancelling", action, len(done.result().goals_canceling)))


commands = {
    "publish": publish,
    "subscribe": subscribe,
    "matches": matches,
    "provide": provide,
    "call": call,
    "act": act,
    "send": send,
    "cancel": cancel,
    "nodes": lambda: say("nodes", sorted(node.get_node_names())),
}

rclpy.init()
node = rclpy.create_node(sys.argv[1])
group = ReentrantCallbackGroup()
executor = MultiThreadedExecutor(4)
executor.add_node(node)


def spin():
    try:
        executor.spin()
    except ExternalShutdownException:
        pass


threading.Thread(target=spin, daemon=True).start()
say("ready")
for line in sys.stdin:
    command = json.loads(line)
    commands[command[0]](*command[1:])
    say("done", command[0])
rclpy.try_shutdown()
