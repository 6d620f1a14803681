"""The blocks of the README: they run, and `mypy --strict` accepts them."""

import os
import re
import subprocess
import sys
import tempfile
import unittest

README = os.path.join(os.path.dirname(__file__), "..", "README.md")


def program():
    with open(README, encoding="utf-8") as text:
        return "\n\n".join(re.findall(r"```python\n(.*?)```", text.read(), re.DOTALL))


class Readme(unittest.TestCase):
    def test_its_blocks_run(self):
        text = program()
        self.assertGreater(text.count("class "), 4)
        module = {"__name__": "readme"}
        exec(compile(text, "README.md", "exec"), module)

        import asmotion

        bench = asmotion.Bench(module["Polling"])
        (call,) = bench.cycle().calls
        call.reply(module["Opening"](0.2))
        self.assertEqual(bench.cycle().reports, [("planned", {"width": 0.2})])
        bench = asmotion.Bench(module["Waiting"])
        bench.cycle().calls[0].reply(module["Opening"](0.3))
        reports = [report for outcome in bench.run_for(1.0) for report in outcome.reports]
        self.assertEqual(reports, [("planned", {"width": 0.3})])

    def test_its_component_has_about_twenty_lines(self):
        first = program().split('if __name__')[0]
        lines = [line for line in first.splitlines() if line.strip() and not line.startswith(("import", "from"))]
        self.assertLessEqual(len(lines), 22)

    def test_its_blocks_have_correct_types(self):
        try:
            import mypy  # noqa: F401
        except ImportError:
            self.skipTest("mypy is not installed")
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "readme.py")
            with open(file, "w", encoding="utf-8") as out:
                out.write(program())
            checked = subprocess.run(
                [sys.executable, "-m", "mypy", "--strict", "--cache-dir", folder, file], capture_output=True, text=True
            )
        self.assertEqual(checked.returncode, 0, checked.stdout)
