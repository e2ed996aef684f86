"""Finds what a 3D scene draws for nothing, and proves that nothing visible was lost.

>>> import pycullet
>>> scene = pycullet.Scene.builtin("city")
>>> camera = pycullet.Camera.look_at(eye=(5, 1.7, 40), target=(5, 1.7, 0), size=(640, 400))
>>> result = scene.cull(camera)
>>> bool(len(result.visible) < scene.instance_count)
True

Arrays go in and come out; the interpreter's lock is free while the engine works. An *id* is the number of an instance
in the order of adding, and is never given twice in a scene. Matrices are 4 × 4 for column vectors, as in NumPy,
trimesh and pyvista: the translation is the last column. Angles are in degrees. The scene is right-handed; nothing says
which way is up but a camera, which takes +Y where it is told nothing else.
"""

from ._native import (
    BUILTIN_SCENES,
    STAGES,
    Camera,
    Cameras,
    Culler,
    FileError,
    Pvs,
    Result,
    Results,
    StaleError,
    __version__,
)
from ._answers import Explanation, Image, Occluder, Step, Verification
from ._report import Report
from ._scene import Scene

__all__ = [
    "BUILTIN_SCENES",
    "STAGES",
    "Camera",
    "Cameras",
    "Culler",
    "Explanation",
    "FileError",
    "Image",
    "Occluder",
    "Pvs",
    "Report",
    "Result",
    "Results",
    "Scene",
    "StaleError",
    "Step",
    "Verification",
    "__version__",
]
