"""Subscribes to a topic and prints what it receives.

Arguments: name of the node, topic, package and name of the type, and for how long a message takes, in seconds.
"""

import importlib
import sys
import time

import rospy

name, topic, package, type_name, duration = sys.argv[1:6]
message_class = getattr(importlib.import_module(package + ".msg"), type_name)
rospy.init_node(name.lstrip("/"), disable_signals=True)


def receive(message):
    print(" ".join(str(message).split()), flush=True)
    time.sleep(float(duration))


subscriber = rospy.Subscriber(topic, message_class, receive, tcp_nodelay=True)


def is_connected():
    # rospy counts a connection before it opens it, and gives it up for ever if the master is killed before it has
    return any(getattr(connection, "header", None) for connection in subscriber.impl.connections)


while type_name != "Bool" and not is_connected():
    rospy.sleep(0.01)
print("connected", flush=True)
for line in sys.stdin:
    pass
