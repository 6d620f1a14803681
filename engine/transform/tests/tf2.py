"""Look-ups of tf2: reads a list of objects with `transforms` and `lookups`, and prints a line for each look-up."""

import json
import sys

import rospy
import tf2_geometry_msgs
import tf2_py
from geometry_msgs.msg import PointStamped, PoseStamped, TransformStamped, Vector3Stamped


def time(nanoseconds):
    return rospy.Time(nanoseconds // 10**9, nanoseconds % 10**9)


def list_of(of, names="xyz"):
    return [getattr(of, name) for name in names]


def pose_list(pose):
    return list_of(pose.position) + list_of(pose.orientation, "xyzw")


def moved(found):
    """A pose, a point and a direction, in the target."""
    pose, point, vector = PoseStamped(), PointStamped(), Vector3Stamped()
    pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = 1.0, -2.0, 0.5
    pose.pose.orientation.x, pose.pose.orientation.w = 0.6, 0.8
    point.point.x, point.point.y, point.point.z = 1.0, -2.0, 0.5
    vector.vector.x, vector.vector.y, vector.vector.z = 1.0, -2.0, 0.5
    return (
        pose_list(tf2_geometry_msgs.do_transform_pose(pose, found).pose)
        + list_of(tf2_geometry_msgs.do_transform_point(point, found).point)
        + list_of(tf2_geometry_msgs.do_transform_vector3(vector, found).vector)
    )


for case in json.load(sys.stdin):
    buffer = tf2_py.BufferCore(rospy.Duration(10))
    for parent, child, stamp, numbers, is_static in case["transforms"]:
        transform = TransformStamped()
        transform.header.frame_id, transform.child_frame_id, transform.header.stamp = parent, child, time(stamp)
        offset, rotation = transform.transform.translation, transform.transform.rotation
        offset.x, offset.y, offset.z, rotation.x, rotation.y, rotation.z, rotation.w = numbers
        (buffer.set_transform_static if is_static else buffer.set_transform)(transform, "test")
    for target, source, stamp in case["lookups"]:
        try:
            found = buffer.lookup_transform_core(target, source, time(stamp))
            stamp = found.header.stamp
            print(json.dumps({"stamp": stamp.secs * 10**9 + stamp.nsecs, "numbers": moved(found)}))
        except tf2_py.TransformException as error:
            print(json.dumps({"error": type(error).__name__}))
