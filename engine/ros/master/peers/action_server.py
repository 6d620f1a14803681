"""An action server of move_base_msgs/MoveBase.

It works on a goal for `position.x` tenths of a second, and tells its position after each. It aborts a goal with a negative
`position.y`. With the argument `queue`, it accepts goals one after the other, so that one can wait; otherwise a new goal replaces
the one before.
"""

import sys

import actionlib
import rospy
from move_base_msgs.msg import MoveBaseAction, MoveBaseFeedback, MoveBaseResult

rospy.init_node(sys.argv[1], disable_signals=True)


def execute(goal):
    target = goal.target_pose.pose.position
    feedback = MoveBaseFeedback()
    for step in range(int(target.x)):
        if server.is_preempt_requested():
            server.set_preempted(MoveBaseResult(), "cancelled é")
            return
        feedback.base_position.pose.position.x = step + 1
        server.publish_feedback(feedback)
        rospy.sleep(0.1)
    if target.y < 0:
        server.set_aborted(MoveBaseResult(), "no path")
    else:
        server.set_succeeded(MoveBaseResult(), "arrived")


server = actionlib.SimpleActionServer("move", MoveBaseAction, execute, auto_start=False)
server.start()
print("ready", flush=True)
for line in sys.stdin:
    pass
