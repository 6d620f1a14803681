"""One end of a measurement: how long messages of rospy are on their way, and how many pass.

Arguments: `send` or `receive`, name of the node, topic, kind of message (Twist, LaserScan, OccupancyGrid), and for the sender the number of
messages and their rate (0: as fast as possible). The sender begins when its input has a line. The receiver answers each line of its
input with the times of transit in µs, and the messages per second between the first and the last.
"""

import json
import sys
import time
import warnings

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan

# a publisher without a queue sends in the thread that publishes
warnings.filterwarnings("ignore", category=SyntaxWarning)
role, name, topic, kind, *numbers = sys.argv[1:]


def message_of(kind):
    if kind == "Twist":
        return Twist()
    if kind == "LaserScan":
        return LaserScan(ranges=[index / 100 for index in range(720)])
    grid = OccupancyGrid(data=[index % 101 for index in range(160_000)])
    grid.info.width = grid.info.height = 400
    return grid


def stamp(message):
    now = time.monotonic_ns()
    if kind == "Twist":
        message.linear.x = now / 1e9
    else:
        message.header.stamp = rospy.Time(now // 1_000_000_000, now % 1_000_000_000)


def age(message):
    now = time.monotonic_ns()
    if kind == "Twist":
        return now / 1e3 - message.linear.x * 1e6
    return (now - message.header.stamp.to_nsec()) / 1e3


rospy.init_node(name, disable_signals=True)
if role == "send":
    count, rate = int(numbers[0]), float(numbers[1])
    publisher = rospy.Publisher(topic, type(message_of(kind)), queue_size=None, tcp_nodelay=True)
    while publisher.get_num_connections() == 0:
        time.sleep(0.01)
    print("ready", flush=True)
    sys.stdin.readline()
    message = message_of(kind)
    begun = time.monotonic()
    for number in range(count):
        if rate:
            time.sleep(max(0, begun + number / rate - time.monotonic()))
        stamp(message)
        publisher.publish(message)
    print("sent", flush=True)
    sys.stdin.readline()
else:
    ages, times = [], []

    def receive(message):
        ages.append(age(message))
        times.append(time.monotonic())

    rospy.Subscriber(topic, type(message_of(kind)), receive, tcp_nodelay=True)
    print("ready", flush=True)
    for _ in sys.stdin:
        while not times or time.monotonic() - times[-1] < 0.5:
            time.sleep(0.05)
        pace = (len(times) - 1) / (times[-1] - times[0]) if len(times) > 1 else 0
        print(json.dumps({"ages": ages, "pace": pace}), flush=True)
        ages, times = [], []
