"""A client of an action as rclpy and rmw_cyclonedds have it."""

import os

from cyclonedds.core import Listener
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from dds_types import made, of_schema, qos_of, with_header


class ActionClient:
    """Sends one goal at a time, and tells its feedback and its end."""

    def __init__(self, participant, action, kinds, say):
        self.action, self.say = action, say
        self.plain = {name: of_schema(it["schema"], it["type"]) for name, it in kinds.items()}
        self.headed = {
            name: with_header(self.plain[name], it["type"])
            for name, it in kinds.items()
            if name not in ("feedback", "status")
        }
        self.sequence, self.goal = 0, None
        base, qos = action + "/_action/", qos_of({})

        def writer(name, of):
            return DataWriter(participant, Topic(participant, f"rq{base}{name}Request", self.headed[of]), qos=qos)

        def reader(topic, kind, receive):
            return DataReader(participant, Topic(participant, topic, kind), qos=qos, listener=Receiver(receive))

        self.goals, self.asks, self.cancels = (
            writer("send_goal", "goal"),
            writer("get_result", "ask"),
            writer("cancel_goal", "cancel"),
        )
        self.readers = [
            reader(f"rr{base}send_goalReply", self.headed["accepted"], self.accepted),
            reader(f"rr{base}get_resultReply", self.headed["result"], self.ended),
            reader(f"rr{base}cancel_goalReply", self.headed["cancelled"], self.cancelled),
            reader(f"rt{base}feedback", self.plain["feedback"], self.told),
        ]

    def is_ready(self):
        writers = (self.goals, self.asks, self.cancels)
        matched = [it.get_publication_matched_status().current_count for it in writers]
        matched += [it.get_subscription_matched_status().current_count for it in self.readers]
        return all(matched)

    def header(self):
        self.sequence += 1
        return {"guid": 4712, "seq": self.sequence}

    def send(self, digits):
        self.goal = made["unique_identifier_msgs::msg::dds_::UUID_"](uuid=list(os.urandom(16)))
        goal = self.plain["goal"].__annotations__["goal"].deserialize(bytes.fromhex(digits))
        self.goals.write(self.headed["goal"](**self.header(), goal_id=self.goal, goal=goal))

    def cancel(self):
        zero = made["builtin_interfaces::msg::dds_::Time_"](sec=0, nanosec=0)
        info = made["action_msgs::msg::dds_::GoalInfo_"](goal_id=self.goal, stamp=zero)
        self.cancels.write(self.headed["cancel"](**self.header(), goal_info=info))

    def accepted(self, reply):
        self.say(self.action + "/accepted", "01" if reply.accepted else "00")
        if reply.accepted:
            self.asks.write(self.headed["ask"](**self.header(), goal_id=self.goal))

    def cancelled(self, reply):
        self.say(self.action + "/cancelling", f"{len(reply.goals_canceling):02x}")

    def ended(self, reply):
        self.say(self.action + "/status", f"{reply.status:02x}")
        self.say(self.action + "/result", reply.result.serialize().hex())

    def told(self, message):
        if list(message.goal_id.uuid) == list(self.goal.uuid):
            self.say(self.action + "/feedback", message.feedback.serialize().hex())


class Receiver(Listener):
    """Gives the messages of a reader to a function."""

    def __init__(self, receive):
        super().__init__()
        self.receive = receive

    def on_data_available(self, reader):
        for sample in reader.take(64):
            if hasattr(sample, "sample_info") and sample.sample_info.valid_data:
                self.receive(sample)
