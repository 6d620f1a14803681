"""A node in simulated time: prints the time it has after each line of standard input.

Argument: name of the node.
"""

import sys

import rospy

rospy.set_param("/use_sim_time", True)
rospy.init_node(sys.argv[1], disable_signals=True)
print("ready", flush=True)
for line in sys.stdin:
    print(rospy.get_rostime().to_nsec(), flush=True)
