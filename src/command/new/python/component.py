"""A gripper: moves its fingers to the commanded position."""

import asmotion
from asmotion.messages import Float64


class Gripper(asmotion.Component):
    """Moves to the commanded position, at a limited speed."""

    command = asmotion.In(Float64, "commanded distance of the fingers, m")
    position = asmotion.Out(Float64, "distance of the fingers, m; written in each cycle")
    speed = asmotion.Property(0.1, "speed of the fingers", unit="m/s", range=(0.01, 0.5))

    at = 0.08
    last: float | None = None

    def update(self, cycle: asmotion.Cycle) -> None:
        elapsed = cycle.seconds - self.last if self.last is not None else 0.0
        self.last = cycle.seconds
        if command := self.command.read():
            step = self.speed * elapsed
            self.at += max(-step, min(step, command.data - self.at))
        self.position.write(Float64(self.at))


if __name__ == "__main__":
    asmotion.run(Gripper)
