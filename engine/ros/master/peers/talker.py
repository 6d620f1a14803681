"""Publishes std_msgs/String on a topic: each line of standard input, until it ends.

Arguments: name of the node, topic, `latch` or `once`.
"""

import sys

import rospy
from std_msgs.msg import String

name, topic, latch = sys.argv[1:4]
rospy.init_node(name.lstrip("/"), disable_signals=True)
publisher = rospy.Publisher(topic, String, queue_size=1000, latch=latch == "latch")
print("ready", flush=True)
for line in sys.stdin:
    command, _, text = line.rstrip("\n").partition(" ")
    if command == "await":
        while publisher.get_num_connections() < int(text):
            rospy.sleep(0.01)
        print("connected", flush=True)
    elif command == "count":
        for number in range(int(text)):
            publisher.publish(String(str(number)))
    else:
        publisher.publish(String(text))
rospy.signal_shutdown("end")
