"""The lines of docs/python.md run as they stand, one after the other, in a folder with the coin's files."""

import pathlib
import re
import shutil

import pytest

from conftest import COIN, ROOT

BLOCK = re.compile(r"^```python\n(.*?)^```$", re.M | re.S)


@pytest.mark.parametrize("page", ["docs/python.md"])
def test_lines_of_the_documentation_run(page, tmp_path, monkeypatch):
    for name in ("plan.toml", "coin.toml", "fit.toml", "coin_10czk_pixels.csv"):
        shutil.copy(COIN / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    blocks = BLOCK.findall((ROOT / page).read_text())
    assert len(blocks) > 3
    names: dict = {}
    for block in blocks:
        needed = re.search(r"^# needs (.*)$", block, re.M)
        if needed:
            for package in needed.group(1).split(", "):
                pytest.importorskip(package)
        exec(compile(block, str(pathlib.Path(page)), "exec"), names)
