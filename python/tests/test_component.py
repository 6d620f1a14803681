"""Components on the bench."""

import collections
import enum
import random
import unittest
from typing import Annotated

import asmotion
from asmotion import Bench, CallError, Fault, MismatchError, UsageError, f64
from asmotion.errors import DeclarationError


@asmotion.message("acme/Number")
class Number:
    value: Annotated[f64, "m"] = 0.0


@asmotion.message("acme/Text")
class Text:
    text: str = ""


class Manner(enum.Enum):
    SOFT = "soft"
    HARD = "hard"


class Doubling(asmotion.Interface, name="acme/Doubling"):
    double = asmotion.Operation(Number, Number, "doubles")
    note = asmotion.Operation(Text, Text)


class Worker(asmotion.Component):
    """Does a bit of everything."""

    goal = asmotion.In(Number, "where to go")
    place = asmotion.Out(Number, "where it is", safe=Number(-1.0))
    speed = asmotion.Property(0.5, "of the motion", unit="m/s", range=(0.0, 2.0))
    manner = asmotion.Property("soft", "of the motion", choices=("soft", "hard"))
    work = asmotion.Service("acme/Work", "works")
    helper = asmotion.Reference(Doubling, "doubles")

    def __init__(self) -> None:
        self.history: list[float] = []
        self.chance = random.Random(7)
        self.waiting: asmotion.Pending[Number] | None = None
        self.call: asmotion.Call[Number] | None = None
        self.events = [f"made at {self.speed}"]

    def configure(self) -> None:
        self.events.append("configure")

    def start(self) -> None:
        self.events.append("start")

    def cleanup(self) -> None:
        self.events.append("cleanup")

    def stop(self, cycle: asmotion.Cycle) -> None:
        self.place.write(Number(0.0))

    @work.operation
    def now(self, request: Number) -> Number:
        """Replies at once."""
        if request.value < 0:
            raise Fault("NEGATIVE", "the value is negative")
        return Number(request.value + 1)

    @work.operation
    def later(self, request: Number) -> asmotion.Pending[Number]:
        self.waiting = asmotion.Pending()
        return self.waiting

    @work.operation(name="count", while_stopped=True)
    def counted(self) -> Number:
        return Number(len(self.history))

    @work.operation
    def reset(self) -> None:
        self.history.clear()

    def update(self, cycle: asmotion.Cycle) -> None:
        for sample in self.goal.all():
            self.history.append(sample.value)
        if self.goal.is_new:
            self.place.write(Number(self.history[-1] * self.speed))
        if self.history and self.history[-1] == 13:
            1 / 0
        if self.history and self.history[-1] == 42 and self.call is None:
            self.call = self.helper.double(Number(42.0))
            self.helper.note.one_way(Text("asked"))

    def inspect(self) -> dict[str, object]:
        return {"history": self.history, "speed": self.speed}


class Cycles(unittest.TestCase):
    def test_inputs_outputs_and_properties(self):
        bench = Bench(Worker, speed=0.25)
        outcome = bench.give("goal", Number(1.0)).give("goal", {"value": 2.0}).cycle()
        self.assertEqual(outcome.outputs, {"place": [Number(0.5)]})
        self.assertEqual((bench.now, bench.number), (100_000_000, 1))
        self.assertNotIn("place", bench.cycle())
        self.assertEqual(bench.set(speed=2).give("goal", Number(3.0)).cycle()["place"], Number(6.0))
        self.assertEqual(bench.component.events, ["made at 0.25", "configure", "start"])
        self.assertEqual(bench.inspect(), {"history": [1.0, 2.0, 3.0], "speed": 2.0})

    def test_time_age_and_losses_of_an_input(self):
        bench = Bench(Worker, period_s=0.5)
        bench.give("goal", Number(1.0)).lose("goal", 3).cycle()
        port = bench.component.goal
        self.assertEqual((port.read(), port.is_new, port.written_at, port.lost), (Number(1.0), True, 500_000_000, 3))
        bench.expire("goal").cycle()
        self.assertEqual((port.read(), port.is_new, port.is_stale, port.lost), (Number(1.0), False, True, 3))
        bench.give("goal", Number(2.0)).cycle()
        self.assertFalse(port.is_stale)

    def test_an_operation_replies_at_once_later_or_with_a_fault(self):
        bench = Bench(Worker)
        at_once, refused = bench.request("work", "now", Number(1.0)), bench.request("work", "now", Number(-1.0))
        later, one_way = bench.request("work", "later"), bench.request("work", "now", one_way=True)
        bench.cycle()
        self.assertEqual(at_once.result(), Number(2.0))
        with self.assertRaisesRegex(Fault, "NEGATIVE: the value is negative"):
            refused.result()
        self.assertFalse(later.is_done or one_way.is_done)
        with self.assertRaises(LookupError):
            later.result()
        self.assertEqual(bench.component.waiting.caller, "Bench")
        with self.assertRaisesRegex(UsageError, "outside of a cycle"):
            bench.component.waiting.reply(Number(5.0))

    def test_a_pending_reply_is_given_in_a_later_cycle(self):
        class Patient(asmotion.Component):
            work = asmotion.Service("acme/Work")
            waiting = None

            @work.operation
            def later(self, request: Number) -> asmotion.Pending[Number]:
                self.waiting = asmotion.Pending()
                if request.value == 1.0:
                    self.waiting.refuse("EARLY", "too early")
                return self.waiting

            def update(self, cycle):
                if cycle.number == 3 and not self.waiting.is_done:
                    self.waiting.reply(Number(9.0))

        bench = Bench(Patient)
        request = bench.request("work", "later")
        bench.cycle(2)
        self.assertFalse(request.is_done)
        bench.cycle()
        self.assertEqual(request.result(), Number(9.0))
        bench = Bench(Patient)
        request = bench.request("work", "later", Number(1.0))
        bench.cycle()
        self.assertEqual(request.fault.code, "EARLY")
        bench = Bench(Patient)
        request = bench.request("work", "later")
        bench.cycle()
        bench.cancel(request).cycle(2)
        self.assertTrue(bench.component.waiting.is_cancelled)
        self.assertFalse(request.is_done)

    def test_a_call_ends_in_a_later_cycle(self):
        bench = Bench(Worker)
        outcome = bench.give("goal", Number(42.0)).cycle()
        call, note = outcome.calls
        self.assertEqual((call.reference, call.operation, call.argument), ("helper", "double", Number(42.0)))
        self.assertEqual((note.operation, note.is_one_way), ("note", True))
        made = bench.component.call
        self.assertFalse(made.is_done)
        with self.assertRaisesRegex(UsageError, "Worker.helper.double. is under way"):
            made.result()
        call.reply(Number(84.0))
        bench.cycle()
        self.assertEqual(made.result(), Number(84.0))

    def test_a_call_can_fail(self):
        for kind, code in (("timeout", "TIMEOUT"), ("fault", "JAMMED")):
            bench = Bench(Worker)
            (call, _) = bench.give("goal", Number(42.0)).cycle().calls
            call.fail(kind, code if kind == "fault" else "")
            bench.cycle()
            with self.assertRaises(CallError) as caught:
                bench.component.call.result()
            self.assertEqual((caught.exception.kind, caught.exception.code), (kind, code))

    def test_an_exception_is_a_fault_with_the_lines_that_led_to_it(self):
        bench = Bench(Worker)
        with self.assertRaisesRegex(Fault, r"ZeroDivisionError.*\n.*test_component.py:\d+, in update: 1 / 0"):
            bench.give("goal", Number(13.0)).cycle()

    def test_the_last_cycle_ends_with_the_safe_samples(self):
        self.assertEqual(Bench(Worker).stop().outputs, {"place": [Number(0.0), Number(-1.0)]})

    def test_a_stopped_component_serves_and_commands_nothing(self):
        class Stopped(asmotion.Component):
            place = asmotion.Out(Number)
            work = asmotion.Service("acme/Work")

            @work.operation(while_stopped=True)
            def ask(self, request: Number) -> Number:
                if request.value:
                    self.place.write(request)
                return request

        bench = Bench(Stopped)
        self.assertTrue(Stopped.declaration().data()["services"][0]["operations"][0]["while_stopped"])
        bench.stop()
        request = bench.request("work", "ask")
        bench.serve()
        self.assertTrue(request.is_done)
        bench.request("work", "ask", Number(1.0))
        with self.assertRaisesRegex(Fault, "while the component is stopped"):
            bench.serve()

    def test_effects_of_a_cycle(self):
        class Restless(asmotion.Component):
            def update(self, cycle):
                cycle.set_period(0.25)
                cycle.set_duration(0.001)
                cycle.request_cycle()
                cycle.report("notice", "slow")
                cycle.report("data", {"number": Number(1.0)})
                cycle.error("LIMP", "one wheel is gone")
                self.wake()

        bench = Bench(Restless)
        outcome = bench.cycle()
        self.assertEqual((outcome.period_s, outcome.duration_s, outcome.requested_cycle), (0.25, 0.001, True))
        self.assertEqual(outcome.reports, [("notice", "slow"), ("data", {"number": {"value": 1.0}})])
        self.assertEqual((outcome.error.code, bench.woken), ("LIMP", 1))
        self.assertEqual(len(bench.run_for(1.0)), 4)
        self.assertEqual(bench.recover().error, None)

    def test_two_runs_are_equal(self):
        def run():
            bench = Bench(Worker)
            return [repr(bench.give("goal", Number(float(n))).cycle().outputs) for n in range(5)] + [bench.freeze()]

        self.assertEqual(run(), run())


class Mistakes(unittest.TestCase):
    def test_the_bench_names_what_there_is(self):
        bench = Bench(Worker)
        with self.assertRaisesRegex(LookupError, "no input `gaol`; there are `goal`"):
            bench.give("gaol", Number())
        with self.assertRaisesRegex(LookupError, "no operation `go`; there are `now`, `later`"):
            bench.request("work", "go")
        with self.assertRaisesRegex(MismatchError, "Worker.speed. must be between 0.0 and 2.0 m/s, not 3"):
            bench.set(speed=3)
        with self.assertRaisesRegex(MismatchError, "Worker.manner. must be one of 'soft', 'hard', not 'odd'"):
            bench.set(manner="odd")

    def test_a_use_outside_of_a_cycle_is_an_error(self):
        component = Bench(Worker).component
        for action in (lambda: component.place.write(Number()), lambda: component.helper.double(), lambda: component.cycle):
            with self.assertRaisesRegex(UsageError, "outside of a cycle"):
                action()
        with self.assertRaisesRegex(UsageError, "Worker.place. cannot be assigned; .*write"):
            component.place = Number()
        with self.assertRaisesRegex(UsageError, "Worker.speed. cannot be assigned"):
            component.speed = 1.0

    def test_a_wrong_sample_names_port_and_field(self):
        class Wrong(asmotion.Component):
            place = asmotion.Out(Number)

            def update(self, cycle):
                self.place.write(Number("far") if cycle.number == 1 else Text())

        bench = Bench(Wrong)
        with self.assertRaisesRegex(Fault, r"output `Wrong.place`: the sample's field `value` must be f64, not 'far' \(str\)"):
            bench.cycle()
        with self.assertRaisesRegex(Fault, "output `Wrong.place`: the sample must be acme/Number, not Text"):
            bench.cycle()

    def test_a_wrong_response_names_the_operation(self):
        class Wrong(asmotion.Component):
            work = asmotion.Service("acme/Work")

            @work.operation
            def act(self) -> Number:
                return 5

        bench = Bench(Wrong)
        bench.request("work", "act")
        with self.assertRaisesRegex(Fault, "Wrong.act.: the response must be acme/Number, not 5"):
            bench.cycle()

    def test_contradictions_of_a_class_are_found_before_it_runs(self):
        def declared(text, **body):
            with self.assertRaisesRegex(DeclarationError, text):
                type("Odd", (asmotion.Component,), body).declaration().data()

        declared("input `Odd.goal`: int is no message type", goal=asmotion.In(int))
        declared("property `Odd.speed`: .*between 0 and 1 m/s, not 2", speed=asmotion.Property(2, unit="m/s", range=(0, 1)))
        declared("property `Odd.mode`: .*one of 'a', not 'b'", mode=asmotion.Property("b", choices=["a"]))
        declared("property `Odd.x`: `complex` has no form in a message", x=asmotion.Property(1j))
        declared("output `Odd.out`: the safe sample", out=asmotion.Out(Number, safe=Text()))
        declared("service `Odd.work` has no operation; decorate a method", work=asmotion.Service("acme/Work"))
        declared("reference `Odd.helper` has no operation", helper=asmotion.Reference("acme/Doubling"))
        declared("the input `goal` twice", a=asmotion.In(Number, name="goal"), b=asmotion.In(Number, name="goal"))

    def test_an_input_for_commands_says_so(self):
        class Driven(asmotion.Component):
            goal = asmotion.In(Number, "where to go", command=True)
            map = asmotion.In(Number, "where it is free")

        goal, map = Driven.declaration().data()["inputs"]
        self.assertIs(goal["command"], True)
        self.assertNotIn("command", map)

    def test_a_service_agrees_with_its_interface(self):
        def declared(text, **methods):
            body = {"work": asmotion.Service(Doubling)}
            for name, method in methods.items():
                body[name] = body["work"].operation(name=name)(method)
            with self.assertRaisesRegex(DeclarationError, text):
                type("Odd", (asmotion.Component,), body).declaration()

        def double(self, request: Number) -> Number: ...
        def wrong(self, request: Text) -> Number: ...
        def bare(self, request): ...
        def untyped(self, request) -> Number: ...

        declared("does not serve `note`", double=double)
        declared("its request is acme/Text, and acme/Number in `acme/Doubling`", double=wrong)
        declared("none of `acme/Doubling`, which has double, note", treble=double)
        declared("must have the form", double=bare)
        declared("the parameter `request` has no type", double=untyped)


class State(unittest.TestCase):
    def test_a_frozen_component_continues_where_it_stopped(self):
        bench = Bench(Worker)
        bench.request("work", "later", timeout_s=1.0)
        (call, _) = bench.give("goal", Number(42.0)).cycle().calls
        bench.component.chance.random()
        state = bench.freeze()
        other = Bench(Worker).thaw(state)
        self.assertEqual(other.freeze(), state)
        self.assertEqual(other.component.chance.random(), bench.component.chance.random())
        self.assertEqual(other.component.goal.read(), Number(42.0))
        self.assertEqual(other.component.waiting.caller, "Bench")
        other._ends.append({"call": call.id, "result": {"value": 84.0}})
        other.cycle()
        self.assertEqual(other.component.call.result(), Number(84.0))

    def test_attributes_of_every_kind_survive(self):
        bench = Bench(Worker)
        bench.component.kinds = kinds = [
            b"ab", (1, 2.5), {"a": {1: None}, 2: True}, {3, 1}, frozenset("x"), collections.deque([1], 3), Number(4.0),
            Manner.HARD, asmotion.Record(a=1),
        ]  # fmt: skip
        thawed = Bench(Worker).thaw(bench.freeze()).component.kinds
        self.assertEqual((thawed, thawed[5].maxlen), (kinds, 3))
        self.assertEqual([type(kind) for kind in thawed], [type(kind) for kind in kinds])

    def test_an_attribute_without_a_form_is_named(self):
        bench = Bench(Worker)
        bench.component.device = open(__file__)
        with self.assertRaisesRegex(Fault, "UNSUPPORTED: `Worker.device` has the type TextIOWrapper"):
            bench.freeze()
        bench.component.device.close()
        with self.assertRaisesRegex(Fault, "not the state"):
            bench.thaw(b"\xa0")
