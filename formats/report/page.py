"""One self-contained page: HTML, styles, scripts and data in one file. The page needs no network."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from importlib.resources import files
from math import floor, log10
from string import Template

from ..log.summary import PairSummary
from ..log.tables.escapes import html_text
from ..scene.quantities.units import in_unit, metres
from . import sections
from .gathering import Gathered
from .packing import packed
from .replay import Replay
from .wording import headline, when

# The page joins these in this order into one script.
_SCRIPTS = (
    "data.js",
    "quantities.js",
    "colours.js",
    "pairs.js",
    "map.js",
    "curves.js",
    "bodies.js",
    "replay.js",
    "main.js",
)
_LIBRARIES = "libraries.js"
_STYLES = ("libraries.css", "style.css")

# A clear pair counts as near within this many margins or, without margins, this many minimum distances.
_NEAR_MARGINS = 3.0
_NEAR_LEAST = 3.0

# Below this, powers of ten lose digits.
_LEAST = 1e-300


def page(gathered: Gathered) -> str:
    """Return the page. The same log gives the same page."""
    libraries = _source(_LIBRARIES)
    scripts = "\n".join(map(_source, _SCRIPTS))
    values = {
        "title": html_text(f"{gathered.name}: {headline(gathered.found.summary)}"),
        "policy": _policy(libraries, scripts),
        "name": html_text(gathered.name),
        "styles": "\n".join(map(_source, _STYLES)),
        "verdict": sections.verdict(gathered),
        "worst": sections.worst(gathered),
        "shown": sections.shown(gathered),
        "legend": sections.legend(),
        "contacts": sections.contacts(gathered),
        "awakenings": sections.awakenings(gathered),
        "provenance": sections.provenance(gathered),
        "guarantees": sections.guarantees(),
        "replay": _replay_note(gathered.replay, gathered.loss is None),
        "data": packed(gathered, near(gathered), opening(gathered.pairs, gathered.found.summary["time"][0])),
        "libraries": libraries,
        "scripts": scripts,
    }
    return Template(_source("page.html")).substitute(values)


def near(gathered: Gathered) -> float:
    """Return the default distance, m, below which a clear pair is near: 1, 2 or 5 times a power of ten of the unit."""
    unit = gathered.identity.length_unit
    margin = max((pair["margin"] for pair in gathered.pairs), default=0.0)
    if margin > 0.0:
        return metres(_rounded(in_unit(_NEAR_MARGINS * margin, unit)), unit)
    distances = [pair["distance"]["upper"] or pair["distance"]["lower"] for pair in gathered.pairs]
    least = min((distance for distance in distances if distance > 0.0), default=0.1)
    return metres(_rounded(in_unit(_NEAR_LEAST * least, unit)), unit)


def opening(pairs: Sequence[PairSummary], start: float) -> tuple[int, float]:
    """Return the index of the pair that the page shows at first, and the time, s.

    This is the first contact. Without contacts it is the minimum distance of the worst pair with a known minimum; else
    the first pair at the start of the run.

    Args:
        pairs: worst first.
        start: s, of the run.
    """
    known = [(place, time) for place, pair in enumerate(pairs) if (time := when(pair)) is not None]
    touching = [(time, pairs[place]["pair"], place) for place, time in known if pairs[place]["contacts"]]
    if touching:
        time, _, place = min(touching)
        return place, time
    return known[0] if known else (0, start)


def _rounded(value: float) -> float:
    """Return a number > 0 rounded up to 1, 2 or 5 times a power of ten."""
    value = max(value, _LEAST)
    power = floor(log10(value))
    first = next(digit for digit in (1, 2, 5, 10) if value <= digit * 10.0**power * (1.0 + 1e-9))
    return float(f"{first}e{power}")


def _policy(*scripts: str) -> str:
    """Return a content security policy that allows these scripts only, and no network."""
    hashes = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts]
    allowed = " ".join(f"'sha256-{hashed}'" for hashed in hashes)
    return f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; img-src data: blob:"


def _replay_note(replay: Replay | None, whole: bool) -> str:
    if replay is None:
        certificate = "The log has no bodies to draw: the run used <code>--log certificate</code>."
        told = certificate if whole else "The readable parts of the log have no bodies to draw."
        return f'<p class="note">{told} The rest of the page is complete.</p>'
    if not replay.moves:
        told = "The log has the bodies at their start poses, but not their motions: the run used <code>--rate 0</code>."
        return f'<p class="note">{told} The rest of the page is complete.</p>'
    return ""


def _source(name: str) -> str:
    return (files("closecall.formats.report") / "page" / name).read_text(encoding="utf-8")
