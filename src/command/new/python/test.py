import unittest

import asmotion
from asmotion.messages import Bool
from gripper import Gripper


class GripperTest(unittest.TestCase):
    def test_it_moves_at_its_speed(self) -> None:
        bench = asmotion.Bench(Gripper, period_s=0.1, speed=0.2)
        bench.give("closing", Bool(True)).cycle()
        position = bench.cycle()["position"]
        self.assertAlmostEqual(position.data, 0.06)


if __name__ == "__main__":
    unittest.main()
