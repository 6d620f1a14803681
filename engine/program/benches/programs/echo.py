"""Returns each sample of its input."""

import asmotion


@asmotion.message("bench/Sample")
class Sample:
    number: int = 0
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


class Echo(asmotion.Component):
    input = asmotion.In(Sample, name="in")
    output = asmotion.Out(Sample, name="out")

    def update(self, cycle):
        for sample in self.input.all():
            self.output.write(sample)


asmotion.run(Echo)
