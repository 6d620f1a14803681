"""Recorded inputs on the bench."""

import os
import tempfile
import unittest
from dataclasses import field

import asmotion
from asmotion import Bench, MismatchError

TABLE = """time_s,Arm.state.name,Arm.state.at.sec,Arm.state.joints.0,Arm.state.joints.1,Arm.state.ok,Arm.scan.ranges.count
0.000000000,12,0,0.5,,true,100
0.150000000,"a, b",1,1,-2.5,false,
0.150000000,c,2,inf,NaN,false,
"""


@asmotion.message("acme/At")
class At:
    sec: int = 0


@asmotion.message("acme/State")
class State:
    name: str = ""
    at: At = field(default_factory=At)
    joints: tuple[float, ...] = ()
    ok: bool = False


@asmotion.message("acme/Scan")
class Scan:
    ranges: tuple[float, ...] = ()


class Reader(asmotion.Component):
    state = asmotion.In(State)
    scan = asmotion.In(Scan)
    any = asmotion.In("acme/Other")

    def update(self, cycle: asmotion.Cycle) -> None:
        cycle.report("seen", [sample.name for sample in self.state.all()])


class Recordings(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = os.path.join(folder.name, "arm.csv")
        with open(self.file, "w") as out:
            out.write(TABLE)

    def test_each_sample_arrives_in_the_first_cycle_after_its_time(self):
        bench = Bench(Reader).give_recorded(self.file, state="Arm.state")
        outcomes = bench.run_for(0.3)
        self.assertEqual([outcome.reports for outcome in outcomes], [[("seen", s)] for s in (["12"], ["a, b", "c"], [])])
        last = bench.component.state.read()
        self.assertEqual((last.at, last.joints[0], last.ok), (At(2), float("inf"), False))
        self.assertNotEqual(last.joints[1], last.joints[1])

    def test_types_of_other_packages_are_guessed(self):
        bench = Bench(Reader).give_recorded(self.file, any="Arm.state")
        bench.cycle()
        self.assertEqual(bench.component.any.read(), {"name": 12, "at": {"sec": 0}, "joints": [0.5], "ok": True})

    def test_a_sample_without_parts_is_one_column(self):
        with open(self.file, "w") as out:
            out.write("time_s,Tank.level,Tank.level_set\n0.000000000,0.5,7\n0.100000000,,8\n0.150000000,-1,\n")
        bench = Bench(Reader).give_recorded(self.file, any="Tank.level")
        seen = []
        for _ in range(3):
            bench.cycle()
            seen.append(list(bench.component.any.all()))
        self.assertEqual(seen, [[0.5], [-1], []])

    def test_mistakes_name_what_there_is(self):
        bench = Bench(Reader)
        with self.assertRaisesRegex(LookupError, "no port `Arm.stat`; it has `Arm.scan`, `Arm.state`"):
            bench.give_recorded(self.file, state="Arm.stat")
        with self.assertRaisesRegex(ValueError, "long lists such as `ranges` of `Arm.scan`"):
            bench.give_recorded(self.file, scan="Arm.scan")
        with self.assertRaisesRegex(MismatchError, "has no field `name`"):
            bench.give_recorded(self.file, scan="Arm.state")
        with self.assertRaisesRegex(ValueError, "is no recording"):
            bench.give_recorded(__file__, state="Arm.state")
