"""Coroutines: hooks and operations that extend over several cycles, on the time of the engine."""

import asyncio
import unittest

import asmotion
from asmotion import Bench, CallError, Fault
from tests.test_component import Doubling, Number


class Mission(asmotion.Component):
    goal = asmotion.In(Number)
    place = asmotion.Out(Number)
    helper = asmotion.Reference(Doubling)
    work = asmotion.Service("acme/Work")

    @work.operation
    async def double(self, request: Number) -> Number:
        return await self.helper.double(request)

    @work.operation
    async def slow(self, request: Number) -> Number:
        await asyncio.sleep(request.value)
        return Number(self.cycle.seconds)

    @work.operation
    async def bounded(self, request: Number) -> Number:
        try:
            return await asyncio.wait_for(self.helper.double(request), 0.25)
        except asyncio.TimeoutError:
            raise Fault("LATE", "the helper is late") from None

    async def update(self, cycle: asmotion.Cycle) -> None:
        goal = await self.goal.next()
        self.place.write(Number(goal.value))
        await asyncio.sleep(0.2)
        self.place.write(Number(-goal.value))


class Tasks(unittest.TestCase):
    def test_an_update_may_extend_over_several_cycles(self):
        bench = Bench(Mission)
        self.assertEqual(bench.cycle().outputs, {})
        self.assertEqual(bench.give("goal", Number(3.0)).cycle()["place"], Number(3.0))
        self.assertEqual(bench.cycle().outputs, {})
        self.assertEqual(bench.cycle()["place"], Number(-3.0))

    def test_an_event_driven_component_wakes_at_the_time_of_its_sleep(self):
        bench = Bench(Mission, period_s=0)
        outcomes = bench.run_for(0.05)
        self.assertEqual([outcome.requested_at_s for outcome in outcomes], [None])
        outcomes = bench.give("goal", Number(3.0)).run_for(0.5)
        self.assertEqual(outcomes[0].requested_at_s, 0.25)
        self.assertEqual([list(outcome.outputs) for outcome in outcomes], [["place"], ["place"]])
        self.assertEqual(bench.now, 550_000_000)

    def test_the_earliest_of_several_sleeps_counts_and_cancelled_ones_do_not(self):
        class Napping(asmotion.Component):
            place = asmotion.Out(Number)

            async def nap(self, seconds):
                await asyncio.sleep(seconds)
                self.place.write(Number(self.cycle.seconds))

            async def update(self, cycle):
                naps = [asyncio.ensure_future(self.nap(seconds)) for seconds in (0.5, 0.3, 0.1)]
                await asyncio.sleep(0.2)
                naps[1].cancel()
                await naps[0]

        outcomes = Bench(Napping, period_s=0).run_for(0.7)
        self.assertEqual([outcome.requested_at_s for outcome in outcomes[:4]], [0.1, 0.2, 0.5, None])
        times = [sample.value for outcome in outcomes for sample in outcome.outputs.get("place", ())]
        self.assertEqual(times, [0.1, 0.5])

    def test_a_cycle_requests_the_next_one_at_a_time(self):
        class Ticking(asmotion.Component):
            def update(self, cycle):
                cycle.request_cycle_at(cycle.seconds + 0.25)
                cycle.request_cycle_at(1e300)

        bench = Bench(Ticking, period_s=0)
        self.assertEqual(len(bench.run_for(1.0)), 5)
        self.assertEqual(len(bench.run_for(1.0)), 4)

    def test_an_operation_awaits_a_call(self):
        bench = Bench(Mission)
        request = bench.request("work", "double", Number(4.0))
        (call,) = bench.cycle().calls
        self.assertFalse(request.is_done)
        call.reply(Number(8.0))
        bench.cycle()
        self.assertEqual(request.result(), Number(8.0))

    def test_the_error_of_an_awaited_call_is_passed_on(self):
        bench = Bench(Mission)
        request = bench.request("work", "double", Number(4.0))
        bench.cycle().calls[0].fail("fault", "JAMMED", "stuck")
        bench.cycle()
        self.assertEqual((request.fault.code, request.fault.text), ("JAMMED", "stuck"))

    def test_time_is_that_of_the_engine(self):
        bench = Bench(Mission)
        request = bench.request("work", "slow", Number(0.3))
        bench.cycle(3)
        self.assertFalse(request.is_done)
        bench.cycle()
        self.assertAlmostEqual(request.result().value, 0.4)

    def test_a_timeout_cancels_the_call(self):
        bench = Bench(Mission)
        request = bench.request("work", "bounded", Number(1.0))
        (call,) = bench.cycle().calls
        bench.cycle(3)
        self.assertTrue(call.is_cancelled)
        self.assertEqual(request.fault.code, "LATE")

    def test_a_cancelled_request_cancels_its_coroutine(self):
        bench = Bench(Mission)
        request = bench.request("work", "double", Number(1.0))
        (call,) = bench.cycle().calls
        bench.cancel(request).cycle()
        self.assertTrue(call.is_cancelled)
        bench.cycle()

    def test_an_exception_in_a_task_is_a_fault_of_its_cycle(self):
        class Failing(asmotion.Component):
            async def update(self, cycle):
                await asyncio.sleep(0.1)
                raise ValueError("no")

        bench = Bench(Failing)
        bench.cycle()
        with self.assertRaisesRegex(Fault, "ValueError: no"):
            bench.cycle()

    def test_tasks_that_never_wait_are_a_fault(self):
        class Endless(asmotion.Component):
            async def update(self, cycle):
                while True:
                    await asyncio.sleep(0)

        with self.assertRaisesRegex(Fault, "ENDLESS"):
            Bench(Endless).cycle()

    def test_many_tasks_and_threads_are_deterministic(self):
        class Many(asmotion.Component):
            place = asmotion.Out(Number)

            async def one(self, value):
                await asyncio.sleep(0.1 * (value % 3))
                self.place.write(Number(await asyncio.to_thread(lambda: value)))

            async def update(self, cycle):
                await asyncio.gather(*(self.one(float(value)) for value in range(9)))

        def run():
            return [outcome.outputs.get("place") for outcome in Bench(Many).run_for(1.0)]

        self.assertEqual(run()[0], [Number(0.0), Number(3.0), Number(6.0)])
        self.assertEqual(run(), run())

    def test_the_end_of_a_component_ends_its_coroutines(self):
        ended = []

        class Held(asmotion.Component):
            async def update(self, cycle):
                try:
                    await asyncio.sleep(1e9)
                finally:
                    ended.append(True)

        bench = Bench(Held)
        bench.cycle()
        with self.assertRaisesRegex(Fault, "a coroutine is under way"):
            bench.freeze()
        bench.stop()
        self.assertEqual(ended, [True])

    def test_a_call_error_in_update_is_a_fault_with_its_code(self):
        class Caller(asmotion.Component):
            helper = asmotion.Reference(Doubling)

            async def update(self, cycle):
                await self.helper.double()

        bench = Bench(Caller)
        bench.cycle().calls[0].fail("timeout")
        with self.assertRaises(Fault) as caught:
            bench.cycle()
        self.assertEqual(caught.exception.code, "TIMEOUT")
        self.assertTrue(issubclass(CallError, Fault))
