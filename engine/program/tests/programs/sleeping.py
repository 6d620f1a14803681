"""Sleeps in a coroutine, with the package `asmotion`."""

import asyncio

import asmotion


class Sleeping(asmotion.Component):
    async def update(self, cycle):
        for seconds in (0.2, 0.03, 0.17):
            await asyncio.sleep(seconds)
            self.cycle.report("awake", self.cycle.now)
        await asyncio.wait_for(asyncio.Event().wait(), 60.0)


asmotion.run(Sleeping)
