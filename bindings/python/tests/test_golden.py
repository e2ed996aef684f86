"""The same baked files give the same answers here as in every other host, bit for bit."""

from __future__ import annotations

import json
import pathlib

import numpy as np
import pytest

import pycullet


@pytest.mark.parametrize("data", ["CULLET_GOLDEN"], indirect=True)
def test_baked_files_give_the_answers_of_every_host(data: pathlib.Path) -> None:
    golden = json.loads((data / "golden.json").read_text())
    assert len(golden["scenes"]) == 5
    for expected in golden["scenes"]:
        scene = pycullet.Scene.open(data / expected["file"])
        assert scene.instance_count == expected["instances"]
        for number, view in enumerate(expected["views"]):
            matrix = np.array(view["clip_from_world"]).reshape(4, 4).T
            camera = pycullet.Camera.from_matrix(matrix, size=tuple(view["viewport"]), depth="reversed")
            # Each twice: what a view remembers changes no answer.
            for _ in range(2):
                result = scene.cull(camera, view["preset"])
                what = f"{expected['name']} {number}"
                assert result.visible.tolist() == view["visible"], what
                rows = [
                    {
                        "stage": str(row["stage"]),
                        "unit": str(row["unit"]),
                        "in": [int(row[f"{unit}_in"]) for unit in ("instances", "clusters", "triangles")],
                        "out": [int(row[f"{unit}_out"]) for unit in ("instances", "clusters", "triangles")],
                    }
                    for row in result.funnel
                ]
                assert rows == view["funnel"], what
