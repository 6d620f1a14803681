"""A gripper: closes and opens its fingers."""

import asmotion
from asmotion.messages import Bool, Float64

OPEN = 0.08  # distance of the fingers when they are open, m
TOLERANCE = 1e-6  # distance from an end position at which it counts as reached, m


class Gripper(asmotion.Component):
    """Closes and opens at a limited speed."""

    closing = asmotion.In(Bool, "true to close, false to open")
    closed = asmotion.Out(Bool, "whether the fingers are closed; written in each cycle")
    opened = asmotion.Out(Bool, "whether the fingers are open; written in each cycle")
    position = asmotion.Out(Float64, "distance of the fingers, m; written in each cycle")
    speed = asmotion.Property(0.1, "speed of the fingers", unit="m/s", range=(0.01, 0.5))

    at = OPEN
    last: float | None = None

    def update(self, cycle: asmotion.Cycle) -> None:
        elapsed = cycle.seconds - self.last if self.last is not None else 0.0
        self.last = cycle.seconds
        if closing := self.closing.read():
            target = 0.0 if closing.data else OPEN
            step = self.speed * elapsed
            self.at += max(-step, min(step, target - self.at))
        self.closed.write(Bool(self.at < TOLERANCE))
        self.opened.write(Bool(self.at > OPEN - TOLERANCE))
        self.position.write(Float64(self.at))


if __name__ == "__main__":
    asmotion.run(Gripper)
