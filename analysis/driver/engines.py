"""The engines of the study, by name."""

from __future__ import annotations

from analysis.driver.engine import Engine
from analysis.driver.liggghts import Liggghts
from analysis.driver.yade import Yade

YADE, LIGGGHTS = Yade(), Liggghts()
ENGINES: dict[str, Engine] = {engine.name: engine for engine in (YADE, LIGGGHTS)}
CODES = tuple(ENGINES)
