"""The servers of Nav2 as its nodes have them: Cyclone DDS, one goal at a time, a robot that needs time to stop.

The argument is a JSON object with the domain and the types. Each line of output is an event for the test; each line of input is a
command: `["next", ACTION, {"code": 105, "after": 0.3}]` lets the next goal of an action fail with an error code, or with `"after"`
alone succeed after this time.
"""

import json
import sys
import threading
import time

from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from dds_types import made, of_schema, qos_of, with_header

EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = 2, 3, 4, 5, 6
# the longest that a test waits for the robot to stop: far more than the 20 ms for which a node of a behaviour tree waits
STOPPING = 0.4
MOVERS = ("follow_path", "spin", "backup")

settings = json.loads(sys.argv[1])
participant = DomainParticipant(settings["domain"])
closed = threading.Event()
default = qos_of({})


def say(*words):
    print(*words, flush=True)


def topic(name, kind):
    return Topic(participant, name, kind)


class Service:
    """A server in the mapping of rmw_cyclonedds."""

    def __init__(self, name, request, response):
        self.request = with_header(of_schema(request["schema"], request["type"]), request["type"])
        self.response = with_header(of_schema(response["schema"], response["type"]), response["type"])
        self.reader = DataReader(participant, topic(f"rq{name}Request", self.request), qos=default)
        self.writer = DataWriter(participant, topic(f"rr{name}Reply", self.response), qos=default)

    def take(self):
        valid = lambda it: hasattr(it, "sample_info") and it.sample_info.valid_data
        return [message for message in self.reader.take(16) if valid(message)]

    def reply(self, to, **members):
        self.writer.write(self.response(guid=to[0], seq=to[1], **members))


class Goal:
    def __init__(self, goal_id, plan):
        self.id, self.plan = goal_id, plan
        self.status, self.asked, self.result = EXECUTING, [], None
        self.begun, self.stopping = time.monotonic(), None


class Action:
    """A server that executes one goal: a new one ends the one before, as nav2_util::SimpleActionServer does."""

    def __init__(self, name, kinds, empty, takes):
        self.name, self.takes = name, takes
        base = f"/{name}/_action/"
        pair = lambda suffix, request, response: Service(base + suffix, kinds[request], kinds[response])
        self.goals = pair("send_goal", "goal", "accepted")
        self.asks = pair("get_result", "ask", "result")
        self.cancels = pair("cancel_goal", "cancel", "cancelled")
        plain = lambda part: of_schema(kinds[part]["schema"], kinds[part]["type"])
        self.feedback_kind, self.status_kind = plain("feedback"), plain("status")
        result = plain("result").__annotations__["result"]
        self.new_result = lambda: result.deserialize(bytes.fromhex(empty))
        self.feedback = DataWriter(participant, topic(f"rt{base}feedback", self.feedback_kind), qos=default)
        latched = qos_of({"transient": True, "depth": 1})
        self.status = DataWriter(participant, topic(f"rt{base}status", self.status_kind), qos=latched)
        self.known, self.current, self.plans, self.left = {}, None, [], None

    def moves(self):
        return self.current is not None and self.name in MOVERS

    def cycle(self):
        for message in self.goals.take():
            self.begin(message)
        for message in self.asks.take():
            goal = self.known[bytes(message.goal_id.uuid)]
            goal.asked.append((message.guid, message.seq))
        for message in self.cancels.take():
            self.cancel(message)
        self.execute()
        for goal in self.known.values():
            while goal.result is not None and goal.asked:
                self.asks.reply(goal.asked.pop(), status=goal.status, result=goal.result)

    def begin(self, message):
        say("begin", self.name)
        before = self.current
        if before is not None:
            self.left = max(0.0, before.plan["after"] - (time.monotonic() - before.begun))
            self.end(before, ABORTED)
        plan = self.plans.pop(0) if self.plans else {"after": self.takes}
        if before is not None and "code" not in plan:
            # the robot goes on from where it is
            plan = plan | {"after": min(plan["after"], self.left)}
        self.current = Goal(message.goal_id, plan)
        self.known[bytes(message.goal_id.uuid)] = self.current
        zero = made["builtin_interfaces::msg::dds_::Time_"](sec=0, nanosec=0)
        self.goals.reply((message.guid, message.seq), accepted=True, stamp=zero)
        self.publish()

    def cancel(self, message):
        named = bytes(message.goal_info.goal_id.uuid)
        everything = named == bytes(16)
        meant = [self.current] if self.current and (everything or bytes(self.current.id.uuid) == named) else []
        for goal in meant:
            if goal.status == EXECUTING:
                say("cancel", self.name)
                goal.status, goal.stopping = CANCELING, time.monotonic()
        code = 0 if meant else (3 if named in self.known else 2)
        infos = [self.info(goal) for goal in meant]
        self.cancels.reply((message.guid, message.seq), return_code=code, goals_canceling=infos)
        self.publish()

    def execute(self):
        goal = self.current
        if goal is None:
            return
        now = time.monotonic()
        if goal.status == CANCELING:
            # in no time if nothing moves
            if now - goal.stopping >= (STOPPING if self.name in MOVERS else 0.0):
                self.end(goal, CANCELED)
        elif now - goal.begun >= goal.plan["after"]:
            self.end(goal, ABORTED if "code" in goal.plan else SUCCEEDED)

    def end(self, goal, status):
        say("end", self.name, status)
        goal.status = status
        goal.result = self.new_result()
        if status == ABORTED:
            goal.result.error_code = goal.plan.get("code", 0)
        if goal is self.current:
            self.current = None
        self.publish()

    def info(self, goal):
        zero = made["builtin_interfaces::msg::dds_::Time_"](sec=0, nanosec=0)
        return made["action_msgs::msg::dds_::GoalInfo_"](goal_id=goal.id, stamp=zero)

    def publish(self):
        state = made["action_msgs::msg::dds_::GoalStatus_"]
        states = [state(goal_info=self.info(goal), status=goal.status) for goal in self.known.values()]
        self.status.write(self.status_kind(status_list=states))


def obey():
    for line in sys.stdin:
        verb, name, plan = json.loads(line)
        assert verb == "next", verb
        actions[name].plans.append({"after": actions[name].takes} | plan)
    closed.set()


actions = {name: Action(name, **it) for name, it in settings["actions"].items()}
services = {name: Service(name, **it) for name, it in settings["services"].items()}
threading.Thread(target=obey, daemon=True).start()
say("ready")
while not closed.is_set():
    for action in actions.values():
        action.cycle()
    movers = [action.name for action in actions.values() if action.moves()]
    if len(movers) > 1:
        say("TWO MOVERS", *movers)
    for name, service in services.items():
        for message in service.take():
            say("clear", name)
            nothing = service.response.__annotations__["response"]
            service.reply((message.guid, message.seq), response=nothing(structure_needs_at_least_one_member=0))
    time.sleep(0.01)
