"""A component with a source of its own: a thread makes a number each 100 ms, and requests a cycle that passes it on."""

import threading
import time
from typing import Annotated

import asmotion


@asmotion.message("std_msgs/Int32")
class Int32:
    data: Annotated[asmotion.i32, "the number"] = 0


class Feeder(asmotion.Component):
    """Numbers, in order."""

    command = asmotion.Out(Int32, "the newest numbers")

    def configure(self) -> None:
        self.waiting: list[int] = []
        threading.Thread(target=self.make, daemon=True).start()

    def make(self) -> None:
        number = 1
        while True:
            time.sleep(0.1)
            self.waiting.append(number)
            number += 1
            self.wake()

    def update(self, cycle: asmotion.Cycle) -> None:
        waiting, self.waiting = self.waiting, []
        for number in waiting:
            self.command.write(Int32(number))


if __name__ == "__main__":
    asmotion.run(Feeder)
