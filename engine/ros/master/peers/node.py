"""A node of ROS 1 that does what its standard input says, and prints what it receives, both as lines of JSON.

Argument: name of the node. Commands, each a list:
    ["publish", topic, type, message, is_latched]    publishes a message; the first time, waits for nothing
    ["subscribe", topic, type]                       prints ["message", topic, message, name of the publisher]
    ["connections", topic, number]                   waits until a topic of this node has so many connections
    ["flood", topic, type, message, number, rate]    publishes a message so many times; a field `data` counts
Each command is answered with ["done", command].
"""

import json
import sys
import threading

import genpy
import roslib.message
import rospy

print_lock = threading.Lock()
publishers, subscribers = {}, {}


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


def filled(of, value):
    message = of.data_class()
    genpy.message.fill_message_args(message, [value])
    return message


def subscribe(topic, type_name):
    message_class = roslib.message.get_message_class(type_name)

    def receive(message):
        say(["message", topic, plain(message), message._connection_header.get("callerid")])

    subscribers[topic] = rospy.Subscriber(topic, message_class, receive, tcp_nodelay=True)


def obey(command, *arguments):
    if command == "publish":
        topic, type_name, value, latched = arguments
        of = publisher(topic, type_name, latched)
        of.publish(filled(of, value))
    elif command == "advertise":
        publisher(*arguments)
    elif command == "subscribe":
        subscribe(*arguments)
    elif command == "connections":
        topic, number = arguments
        of = publishers.get(topic) or subscribers[topic]
        while of.get_num_connections() < number:
            rospy.sleep(0.01)
    elif command == "flood":
        topic, type_name, value, number, rate = arguments
        of = publisher(topic, type_name)
        pace = rospy.Rate(rate)
        for count in range(number):
            message = filled(of, value)
            if hasattr(message, "data"):
                message.data = type(message.data)(count)
            of.publish(message)
            pace.sleep()
    else:
        raise ValueError(command)


rospy.init_node(sys.argv[1].lstrip("/"), disable_signals=True)
say(["ready"])
for line in sys.stdin:
    command = json.loads(line)
    obey(*command)
    say(["done", command[0]])
rospy.signal_shutdown("end")
