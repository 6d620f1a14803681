"""Provides services of std_srvs/SetBool: `~set` succeeds with `true` and raises with `false`, `~slow` takes a second, and
the process ends in `~end`.

Argument: name of the node. Prints each request.
"""

import os
import sys
import time

import rospy
from std_srvs.srv import SetBool, SetBoolResponse

rospy.init_node(sys.argv[1], disable_signals=True)


def set_flag(request):
    print(request.data, flush=True)
    if not request.data:
        raise ValueError("no é")
    return SetBoolResponse(True, "done é")


def slow(request):
    time.sleep(1)
    return SetBoolResponse(request.data, "slow")


services = [
    rospy.Service("~set", SetBool, set_flag),
    rospy.Service("~slow", SetBool, slow),
    rospy.Service("~end", SetBool, lambda request: os._exit(1)),
]
print("ready", flush=True)
for line in sys.stdin:
    pass
