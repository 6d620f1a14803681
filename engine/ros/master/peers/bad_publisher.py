"""A publisher of std_msgs/String that speaks the protocols of ROS by hand, and badly.

Arguments: name of the node, topic, and what it does to each subscriber:
    good        sends "good"
    md5         states another MD5 sum
    utf8        sends a text that is not UTF-8
    huge        sends a length of 4 GiB, and then bytes without end
    truncated   closes the connection in the middle of a message
    short       sends a message whose text claims more bytes than the message has
    header      sends a header that is none
Prints "connected" for each subscriber.
"""

import os
import socket
import struct
import sys
import threading
from xmlrpc.client import ServerProxy
from xmlrpc.server import SimpleXMLRPCServer

name, topic, behaviour = sys.argv[1:4]
MD5 = "992ce8a1687cec8c8bd883ec73ca41d1"

data = socket.socket()
data.bind(("127.0.0.1", 0))
data.listen()


def framed(body):
    return struct.pack("<I", len(body)) + body


def header(**fields):
    lines = (f"{key}={value}".encode() for key, value in fields.items())
    return framed(b"".join(framed(line) for line in lines))


def text(body):
    return framed(framed(body))


def serve(peer):
    peer.recv(4096)
    print("connected", flush=True)
    try:
        if behaviour == "header":
            peer.sendall(framed(framed(b"no equals sign")))
            return peer.close()
        md5 = "0" * 32 if behaviour == "md5" else MD5
        peer.sendall(header(callerid=name, md5sum=md5, type="std_msgs/String", latching="0", message_definition="string data\n"))
        if behaviour == "utf8":
            peer.sendall(text(b"\xff\xfe\xc3") + text(b"after"))
        elif behaviour == "huge":
            peer.sendall(struct.pack("<I", 0xFFFFFFF0))
            while True:
                peer.sendall(bytes(65536))
        elif behaviour == "truncated":
            peer.sendall(text(b"a text that ends too early")[:12])
            peer.close()
        elif behaviour == "short":
            peer.sendall(framed(struct.pack("<I", 1000) + b"few") + text(b"after"))
        else:
            while True:
                peer.sendall(text(b"good"))
                threading.Event().wait(0.05)
    except OSError:
        pass


def accept():
    while True:
        peer, _ = data.accept()
        threading.Thread(target=serve, args=(peer,), daemon=True).start()


threading.Thread(target=accept, daemon=True).start()
api = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False, allow_none=True)
api.register_function(lambda *_: [1, "ready", ["TCPROS", "127.0.0.1", data.getsockname()[1]]], "requestTopic")
api.register_function(lambda *_: [1, "", os.getpid()], "getPid")
uri = f"http://127.0.0.1:{api.server_address[1]}/"
master = ServerProxy(os.environ["ROS_MASTER_URI"])
master.registerPublisher(name, topic, "std_msgs/String", uri)
api.serve_forever()
