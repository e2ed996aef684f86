"""Bakes that many processes share, on one machine or a cluster.

>>> from pycullet import distributed
>>> plan = distributed.plan("city:objects=200", view_cells=8, rays=200_000)
>>> made = distributed.run(plan)
>>> made.cells
8

A plan is a text; a bake is *rounds* of *units*. What a unit finds is a function of the plan and of the rounds before, whoever
runs it, and when. So the result is the same bytes on any engine, for any number of workers, after any loss and any repetition.

Engines: `Here` (this process), `Processes` (others on this machine), `Ray` (extra ``pycullet[ray]``) and `Dask`
(``pycullet[dask]``). `run_command` shares any command of the program ``cullet`` that works in units. ``python -m pycullet.distributed --help`` shows them by example.
"""

from ._commands import SharesFailed, run_command
from ._driver import UnitsFailed, run
from ._engines import Dask, Engine, Here, Processes, Ray
from ._plan import Plan, plan

__all__ = [
    "Dask",
    "Engine",
    "Here",
    "Plan",
    "Processes",
    "Ray",
    "SharesFailed",
    "UnitsFailed",
    "plan",
    "run",
    "run_command",
]
