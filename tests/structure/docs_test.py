"""Usage: docs_test.py ROOT

What the documentation shows of the examples is what stands there.
"""

import pathlib
import sys
import textwrap
import unittest

ROOT = pathlib.Path(sys.argv[1])


def text(path):
    return (ROOT / path).read_text()


class Excerpts(unittest.TestCase):
    def test_plan_of_the_coin(self):
        self.assertIn(f"```toml\n{text('examples/coin/plan.toml')}```", text("README.md"))

    def test_sidecar_of_the_coin(self):
        self.assertIn(f"```toml\n{text('examples/coin/coin.toml')}```", text("docs/captures.md"))

    def test_plan_of_a_command(self):
        self.assertIn(f"```toml\n{text('examples/command/settling.toml')}```", text("docs/plans.md"))

    def test_loop_of_a_program_that_is_kept(self):
        loop = text("examples/command/suspension.py").split("def main():\n")[1].split("\n\n")[0]
        self.assertIn(f"```python\n{textwrap.dedent(loop)}\n```", text("docs/plans.md"))

    def test_own_model(self):
        for name in ["predator_prey.toml", "plan.toml", "predator_prey.h", "own_model.cpp", "library.cpp"]:
            kind = "toml" if name.endswith("toml") else "cpp"
            self.assertIn(f"```{kind}\n{text('examples/own_model/' + name)}```", text("docs/own_models.md"))

    def test_sweep_of_the_card(self):
        self.assertIn(f"```toml\n{text('examples/falling_card/sweep.toml')}```", text("docs/patterns.md"))
        self.assertIn(f"```toml\n{text('examples/drawn_fall/motion.toml')}```", text("docs/synthesis.md"))

    def test_queries(self):
        self.assertIn(f"```cpp\n{text('examples/query/query.cpp')}```", text("docs/queries.md"))

    def test_strategies(self):
        self.assertIn(f"```cpp\n{text('examples/nonlinear/strategies.cpp')}```", text("docs/strategies.md"))

    def test_wind_of_the_meadow(self):
        self.assertIn(f"```toml\n{text('examples/meadow/wind.toml')}```", text("docs/flow.md"))

    def test_flow(self):
        self.assertIn(f"```toml\n{text('examples/flow/square.toml')}```", text("docs/flow.md"))

    def test_profile(self):
        self.assertIn(f"```cpp\n{text('examples/profile/profile.cpp')}```", text("docs/fits.md"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
