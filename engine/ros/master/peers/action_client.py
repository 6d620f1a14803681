"""A client of an action server of move_base_msgs/MoveBase.

Argument: name of the node. Commands on standard input: `goal X`, `cancel`, `wait`. Prints positions of feedback, and the end.
"""

import sys

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal

rospy.init_node(sys.argv[1], disable_signals=True)
client = actionlib.SimpleActionClient("move", MoveBaseAction)
if not client.wait_for_server(rospy.Duration(20)):
    sys.exit("no server")
print("ready", flush=True)


def feedback(message):
    print("feedback", message.base_position.pose.position.x, flush=True)


for line in sys.stdin:
    command, _, argument = line.strip().partition(" ")
    if command == "goal":
        goal = MoveBaseGoal()
        goal.target_pose.pose.position.x = float(argument)
        client.send_goal(goal, feedback_cb=feedback, active_cb=lambda: print("active", flush=True))
    elif command == "cancel":
        client.cancel_goal()
    else:
        client.wait_for_result(rospy.Duration(20))
        print(GoalStatus.to_string(client.get_state()), client.get_goal_status_text(), flush=True)
