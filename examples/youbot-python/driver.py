"""The dummy driver of the youBot's arm as a program: in place of `youbot::DummyDriver`, with the same ports."""

import random

import asmotion
from asmotion.messages import Bool, Float64, JointCommand, JointStatus, Period, String, Time

FAR = 2.9  # largest random position of a joint, rad
ERROR_BITS = 0x3FF


class DummyDriver(asmotion.Component):
    """Joints that turn to their targets, or report random values."""

    commands = asmotion.In(JointCommand, "Target positions of the joints, rad.")
    period = asmotion.In(Float64, "Period of the driver itself, s, 0.001 to 10.")
    status = asmotion.Out(JointStatus, "Measurements of each joint, every cycle.", name="jointStatus")
    driver = asmotion.Service("youbot/Driver", "Sets the period; returns the state.")
    joints = asmotion.Property(5, "Number of joints.", type=asmotion.u32, range=(1, 16))
    seed = asmotion.Property(1, "Seed of all random values.", type=asmotion.u64)
    is_random = asmotion.Property(False, "Whether every value is random.", name="random")
    speed = asmotion.Property(1.0, "Speed of a turning joint.", unit="rad/s", range=(0.01, 10.0))
    faults: asmotion.Property[list[int]] = asmotion.Property(
        [], "Error bits to report, joint by joint.", type=list[asmotion.u16]
    )

    def __init__(self) -> None:
        self.chance = random.Random(self.seed)
        self.goal = [0.0] * self.joints
        self.position = [0.0] * self.joints
        self.measured_at = 0

    @driver.operation(name="setPeriod")
    def set_period(self, request: Period) -> Bool:
        return Bool(self.follow(request.period))

    @driver.operation(name="state")
    def describe(self) -> String:
        return String("resting" if self.position == self.goal else "moving")

    def update(self, cycle: asmotion.Cycle) -> None:
        command, period = self.commands.read(), self.period.read()
        if command and self.commands.is_new and len(command.position) == len(self.goal):
            self.goal = list(command.position)
        if period and self.period.is_new:
            self.follow(period.data)
        self.status.write(self.measure(cycle.now))

    def follow(self, period: float) -> bool:
        """Sets the period (s) from the next cycle on; returns whether it is acceptable."""
        is_valid = 0.001 <= period <= 10.0
        if is_valid:
            self.cycle.set_period(period)
        return is_valid

    def measure(self, now: int) -> JointStatus:
        """Turns the joints and returns their status. Each joint takes the same number of random values in every cycle."""
        passed = (now - self.measured_at) * 1e-9
        step, self.measured_at = self.speed * passed, now
        turns, noises, flags = [], [], []
        for joint, (goal, place) in enumerate(zip(self.goal, self.position)):
            noise, bits = self.chance.uniform(-1.0, 1.0), self.chance.randrange(ERROR_BITS + 1)
            injected = self.faults[joint] & ERROR_BITS if joint < len(self.faults) else 0
            turns.append(FAR * noise - place if self.is_random else max(-step, min(step, goal - place)))
            noises.append(noise)
            flags.append(bits if self.is_random else injected)
        self.position = [place + turn for place, turn in zip(self.position, turns)]
        velocity = [turn / max(passed, 1e-3) for turn in turns]
        effort = [min(abs(speed), 2.0) for speed in velocity]
        return JointStatus(
            stamp=Time(now // 1_000_000_000, now % 1_000_000_000),
            position=self.position,
            velocity=velocity,
            current=[0.2 + 0.8 * load + 0.05 * noise for load, noise in zip(effort, noises)],
            temperature=[35.0 + 5.0 * load + noise for load, noise in zip(effort, noises)],
            error_flags=flags,
        )


if __name__ == "__main__":
    asmotion.run(DummyDriver)
