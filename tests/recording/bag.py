"""Reads a recording with the package `rosbags`, which shares no code with asmotion, and prints what is in it as JSON."""
import json, math, sys
from pathlib import Path
from rosbags.highlevel import AnyReader

counts, last = {}, {}
with AnyReader([Path(sys.argv[1])]) as reader:
    for connection, time, data in reader.messages():
        message = reader.deserialize(data, connection.msgtype)
        name = f"{connection.topic} {connection.msgtype}"
        counts[name] = counts.get(name, 0) + 1
        last[connection.topic] = (time, message)
time, odometry = last["/odom"]
position = odometry.pose.pose.position
stamp = odometry.header.stamp
scan = last["/scan" if "/scan" in last else "/port/LaserDriver/scan"][1]
step = json.loads(last["/asm/ASMCoordinator/step"][1].data)
print(json.dumps({"counts": counts, "position": [position.x, position.y], "frame": odometry.header.frame_id,
    "age_s": (time - stamp.sec * 10**9 - stamp.nanosec) / 1e9, "covariances": len(odometry.pose.covariance),
    "ranges": len(scan.ranges), "nearest": float(min(r for r in scan.ranges if math.isfinite(r))), "step": step["number"]}))
