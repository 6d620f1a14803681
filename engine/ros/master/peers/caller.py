"""Calls a service of std_srvs/SetBool: once for each line of standard input, which is `true` or `false`.

Arguments: name of the node, service, `persistent` or `once`.
"""

import sys

import rospy
from std_srvs.srv import SetBool

name, service, kind = sys.argv[1:4]
rospy.init_node(name, disable_signals=True)
rospy.wait_for_service(service, 20)
call = rospy.ServiceProxy(service, SetBool, persistent=kind == "persistent")
print("ready", flush=True)
for line in sys.stdin:
    try:
        response = call(line.strip() == "true")
        print(response.success, response.message, flush=True)
    except rospy.ServiceException as error:
        print("error:", error, flush=True)
