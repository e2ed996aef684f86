"""What is drawn for nothing in a scene, over many cameras."""

from __future__ import annotations

import os
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _html, _native
from ._answers import Verification


@dataclass(frozen=True)
class Report:
    """What culling finds in a scene. A notebook shows it as a page, and `save` writes that."""

    title: str
    proof: Verification
    stages: npt.NDArray[Any]
    """A row for each stage that took something: ``stage``, ``triangles`` and their ``share`` of all."""
    results: _native.Results
    """The answers on each camera."""
    pictures: tuple[bytes, bytes]
    """PNG files of the camera that sees the most triangles: what it sees, and the same from outside."""

    @property
    def wasted(self) -> float:
        """The share of triangles that are drawn for nothing without culling, 0 to 1."""
        return 1 - self.proof.visible / self.proof.all if self.proof.all else 0.0

    def __repr__(self) -> str:
        return (
            f"<pycullet.Report of {self.title}: {self.wasted:.2%} of the triangles are drawn for nothing without culling, "
            f"{self.proof.kept - self.proof.visible} of {self.proof.all} with it>"
        )

    def _repr_html_(self) -> str:
        proof = self.proof
        rows: list[list[Any]] = [
            [str(row["stage"]), int(row["triangles"]), f"{row['share']:.2%}"] for row in self.stages
        ]
        lost = "Nothing visible was lost." if proof.ok else f"{len(proof.false_culls)} visible triangles were LOST."
        return "".join(
            [
                f"<h3>{escape(self.title)}</h3>",
                f"<p>{len(self.results)} cameras. {self.wasted:.2%} of the triangles are drawn for nothing without "
                f"culling. {lost} Tightness {proof.tightness:.2f}: triangles kept over triangles visible.</p>",
                _html.picture(self.pictures[0], "what the fullest camera sees"),
                _html.picture(self.pictures[1], "the scene from outside, by what culled it"),
                _html.table(
                    ["", "triangles", "share"],
                    [
                        ["of all instances", proof.all, ""],
                        *rows,
                        ["kept", proof.kept, f"{proof.kept / max(proof.all, 1):.2%}"],
                        ["visible", proof.visible, f"{proof.visible / max(proof.all, 1):.2%}"],
                    ],
                ),
            ]
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page as one HTML file, which opens without a network."""
        head = f"<!doctype html><meta charset='utf-8'><title>{escape(self.title)}</title>"
        style = "<style>body{font-family:sans-serif;margin:2em auto;max-width:1000px}</style>"
        with open(path, "w", encoding="utf-8") as file:
            file.write(head + style + self._repr_html_())


def report(scene: _native.Scene, cameras: _native.Cameras, culler: Any, samples: int, threads: int) -> Report:
    proof = Verification(*scene._verify(cameras, culler, samples=samples, threads=threads))
    results = scene.cull(cameras, culler, threads=threads)
    taken = [(s, int(proof.figures[s].sum())) for s in _native.STAGES]
    stages = np.array(
        [(s, n, n / max(proof.all, 1)) for s, n in taken if n],
        dtype=[("stage", "U10"), ("triangles", "u8"), ("share", "f8")],
    )
    fullest = scene.cull(cameras[int(np.argmax(proof.figures["visible"]))], culler)
    return Report(scene.title or "scene", proof, stages, results, fullest.pictures(480))
