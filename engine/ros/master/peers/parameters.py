"""Sets and reads parameters: `set NAME JSON`, `get NAME` (null if it is not set), `delete NAME`, `list` on standard input.

Argument: name of the node.
"""

import json
import sys

import rospy

rospy.init_node(sys.argv[1], disable_signals=True)
print("ready", flush=True)
for line in sys.stdin:
    command, name, *rest = (line.rstrip("\n") + " ").split(" ", 2)
    if command == "set":
        rospy.set_param(name, json.loads(rest[0]))
        print("set", flush=True)
    elif command == "delete":
        rospy.delete_param(name)
        print("deleted", flush=True)
    elif command == "list":
        print(json.dumps(sorted(rospy.get_param_names())), flush=True)
    else:
        print(json.dumps(rospy.get_param(name, None), sort_keys=True), flush=True)
