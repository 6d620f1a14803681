"""The lower half of Figure 1 of the TCA paper, as nodes of ROS: `drivers`, `follower` or `adapter` is the argument.

The drivers move a robot by /cmd_vel and tell where it is on /odom. The follower drives along /adapted while /permit is true, and
says `reached` or `halted` on /event. The adapter passes /plan on, except once: when the robot has done a third of its first path,
a person stands in the way, and it says `blocked`. The drivers print where the robot is when it has stood still for a second.
"""

import math
import sys
import threading

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry, Path
from std_msgs.msg import Bool, String

lock = threading.Lock()
latest = {}


def say(*words):
    print(*words, flush=True)


def keep(name):
    def receive(message):
        with lock:
            latest[name] = message

    return receive


def yaw_of(pose):
    return 2 * math.atan2(pose.orientation.z, pose.orientation.w)


def distance(pose, other):
    return math.hypot(pose.position.x - other.position.x, pose.position.y - other.position.y)


def drivers():
    odom = rospy.Publisher("/odom", Odometry, queue_size=1)
    rospy.Subscriber("/cmd_vel", Twist, keep("twist"))
    x, y, yaw, step, still, moved = 1.4, 4.7, 0.0, 0.02, 0, False
    rate = rospy.Rate(1 / step)
    while not rospy.is_shutdown():
        twist = latest.get("twist", Twist())
        yaw += twist.angular.z * step
        x += twist.linear.x * math.cos(yaw) * step
        y += twist.linear.x * math.sin(yaw) * step
        message = Odometry()
        message.header.frame_id, message.header.stamp = "map", rospy.Time.now()
        pose = message.pose.pose
        pose.position.x, pose.position.y = x, y
        pose.orientation.z, pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        message.twist.twist = twist
        odom.publish(message)
        still = 0 if twist.linear.x else still + 1
        moved = moved or twist.linear.x > 0
        if moved and still == 50:
            say("stands", round(x, 2), round(y, 2))
        rate.sleep()


def follower():
    twist, event = rospy.Publisher("/cmd_vel", Twist, queue_size=1), rospy.Publisher("/event", String, queue_size=8)
    for name, kind in [("adapted", Path), ("odom", Odometry), ("permit", Bool)]:
        rospy.Subscriber("/" + name, kind, keep(name))
    told = None
    rate = rospy.Rate(20)
    while not rospy.is_shutdown():
        rate.sleep()
        with lock:
            path, odom, permit = latest.get("adapted"), latest.get("odom"), latest.get("permit")
        if path is None or odom is None or permit is None:
            continue
        command, robot = Twist(), odom.pose.pose
        if not path.poses:
            if told is not path:
                event.publish("halted")
            told = path
        elif distance(robot, path.poses[-1].pose) < 0.1:
            if told is not path:
                event.publish("reached")
            told = path
        elif permit.data:
            nearest = min(range(len(path.poses)), key=lambda at: distance(robot, path.poses[at].pose))
            ahead = (pose.pose for pose in path.poses[nearest:] if distance(robot, pose.pose) > 0.4)
            target = next(ahead, path.poses[-1].pose)
            to = math.atan2(target.position.y - robot.position.y, target.position.x - robot.position.x) - yaw_of(robot)
            to = math.atan2(math.sin(to), math.cos(to))
            command.linear.x = 1.0 if abs(to) < 0.8 else 0.1
            command.angular.z = 2.5 * to
        twist.publish(command)


def adapter():
    adapted, event = rospy.Publisher("/adapted", Path, queue_size=4, latch=True), rospy.Publisher("/event", String, queue_size=8)
    plans = []

    def plan(message):
        say("plan", len(message.poses))
        with lock:
            plans.append(message)
        adapted.publish(message)

    def odom(message):
        with lock:
            if len(plans) != 1 or not plans[0].poses or "blocked" in latest:
                return
            path = plans[0].poses
            done, whole = distance(path[0].pose, message.pose.pose), distance(path[0].pose, path[-1].pose)
            if done < whole / 3:
                return
            latest["blocked"] = True
        adapted.publish(Path())
        say("blocked")
        event.publish("blocked")

    rospy.Subscriber("/plan", Path, plan)
    rospy.Subscriber("/odom", Odometry, odom)
    rospy.spin()


what = sys.argv[1]
rospy.init_node(what, disable_signals=True)
say("ready")
{"drivers": drivers, "follower": follower, "adapter": adapter}[what]()
