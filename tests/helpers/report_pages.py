"""What tests of the report share: a page taken apart, and logs whose names would run if they were not escaped."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np

from closecall.formats.log.writer import LogOptions, LogWriter
from closecall.formats.scene.loaded import LoadedScene
from closecall.scheduler.model.events import Bound, Level, PairKey, Reason, Span, Verdict, Wakeup
from closecall.scheduler.model.scene import Body, PairRules, Scene, Settings
from closecall.scheduler.motions import Constant

HOSTILE = (
    "</script><script>window.hacked = 1</script>",
    "\" onmouseover='window.hacked = 2' <img src=x onerror=window.hacked=3>",
    "$data ${title} &lt;b&gt;",
)

WARNING = "mesh <b>plate</b> is open"


class Parsed(HTMLParser):
    """A page's elements and text, the text of scripts and styles apart."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.apart: dict[str, list[str]] = {"script": [], "style": []}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag in self.apart:
            self.apart[tag].append("")

    def handle_data(self, data: str) -> None:
        if self.cdata_elem in self.apart:
            self.apart[self.cdata_elem][-1] += data
        else:
            self.text += data

    def count(self, tag: str) -> int:
        return sum(name == tag for name, _ in self.elements)


def hostile_log(path: Path) -> None:
    """Write a log of bodies whose names no scene allows: a log may be forged."""
    still = Constant((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    bodies = tuple(Body(name, None, np.eye(4), still, ()) for name in HOSTILE)
    source = path.with_suffix(".yaml")
    source.write_bytes(b"closecall: 1\n")
    loaded = LoadedScene(source, source.read_bytes(), Scene(bodies, 0.0, 1.0, PairRules()), Settings(), (), (WARNING,))
    with LogWriter(path, loaded, Settings(), 3, LogOptions()) as log:
        for pair in (PairKey(0, 0, 1), PairKey(1, 0, 2), PairKey(2, 1, 2)):
            log.write(Wakeup(0.0, pair, Reason.START, Level.SPHERE, Bound.SPEED_ACCELERATION, 2.0, 1.0))
            log.write(Span(pair, Verdict.CLEAR, 0.0, 1.0, 1.0, 0.0))


def made_up(
    body_a: str, body_b: str, verdict: str, lower: float, upper: float | None, time: float | None, **facts: Any
) -> Any:
    """Return a pair of a summary."""
    pair = {
        "pair": f"{body_a}|{body_b}",
        "body_a": body_a,
        "body_b": body_b,
        "verdict": verdict,
        "margin": 0.0,
        "distance": {
            "lower": lower,
            "upper": upper,
            "time": time,
            "bracket": "open" if upper is None else "tight",
            "why": None,
            "help": None,
        },
        "error": 0.0,
        "chord_error": 0.0,
        "contacts": [],
        "breaches": [],
        "unresolved": [],
        "possible": [],
        "wakeups": 1,
        "queries": {"sphere": 0, "mesh": 1},
    }
    return pair | facts
