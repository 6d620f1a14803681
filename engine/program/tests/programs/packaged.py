"""The gripper of `gripper.py`, with the package `asmotion`: as it is, or `waiting` in coroutines."""

import sys

import asmotion


@asmotion.message("acme/GripperCommand")
class GripperCommand:
    opening: float = 0.0


@asmotion.message("acme/GripperState")
class GripperState:
    opening: float = 0.0
    is_closed: bool = False


@asmotion.message("acme/Close")
class Close:
    force: float = 0.0


@asmotion.message("acme/Closed")
class Closed:
    width: float = 0.0


@asmotion.message("acme/Permission")
class Permission:
    granted: bool = False


class Guard(asmotion.Interface, name="acme/Guard"):
    ask = asmotion.Operation(Close, Permission)


class Gripper(asmotion.Component):
    command = asmotion.In(GripperCommand, "wanted opening")
    state = asmotion.Out(GripperState, "where the fingers are", safe=GripperState(0.1))
    grip = asmotion.Service("acme/Grip", "closes the fingers")
    guard = asmotion.Reference(Guard, "asked before the fingers close", optional=True)
    speed = asmotion.Property(0.1, "of the fingers", unit="m/s", range=(0.01, 0.5))
    mode = asmotion.Property("soft", "of the controller", choices=("soft", "hard"))

    def __init__(self):
        self.opening, self.target = 0.0, 0.0
        self.asked = []

    def configure(self):
        print("configured with", self.speed)

    @grip.operation(while_stopped=True)
    def close(self, request: Close) -> asmotion.Pending[Closed]:
        if not self.cycle.is_running:
            raise asmotion.Fault("STOPPED", "start me first")
        reply = asmotion.Pending()
        self.asked.append((self.guard.ask(request), reply))
        return reply

    def answer(self):
        for call, reply in [pair for pair in self.asked if pair[0].is_done]:
            self.asked.remove((call, reply))
            try:
                if not call.result().granted:
                    reply.refuse("REFUSED", "the guard says no")
                    continue
            except asmotion.CallError as error:
                reply.refuse("NO_GUARD", error.kind)
                continue
            self.target = 0.0
            reply.reply(Closed(self.opening))

    def update(self, cycle):
        for sample in self.command.all():
            self.target = sample.opening
        self.answer()
        step = self.speed * 0.1
        self.opening = min(max(self.target, self.opening - step), self.opening + step)
        self.state.write(GripperState(self.opening, self.opening == 0.0))
        cycle.report("opening", self.opening)

    def inspect(self):
        return {"opening": self.opening, "target": self.target}


class Waiting(Gripper):
    async def close(self, request):
        try:
            permission = await self.guard.ask(request)
        except asmotion.CallError as error:
            raise asmotion.Fault("NO_GUARD", error.kind) from None
        if not permission.granted:
            raise asmotion.Fault("REFUSED", "the guard says no")
        self.target = 0.0
        return Closed(self.opening)


asmotion.run(Waiting if "waiting" in sys.argv else Gripper)
