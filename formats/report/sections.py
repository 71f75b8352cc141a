"""The tables and lists in the HTML of a page. They are complete without scripts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ..log.bracket import why_wide
from ..log.result import Stretches
from ..log.summary import PairSummary
from ..log.tables.escapes import html_text
from ..scene.quantities.lengths import length_text
from ..scene.text.errors import counted
from .gathering import MOST_PAIRS, Gathered
from .quantities import interval, length, moment
from .wording import headline, is_proved, jump, nearest, pair_name, proof, sentences, until_the_end, when

# Rows of tables.
_MOST_WORST = 6
_MOST_CONTACTS = 1000

_REASONS = {
    "START": "start of the pair",
    "TIME_BOUND": "end of a certified sleep",
    "TIME_RESOLUTION": "end of a minimum step: the certified sleep was shorter",
    "KNOT": "knot of a motion",
    "WINDOW": "overlap of the swept boxes of both bodies",
    "CONTACT": "measurement during a contact",
    "REFINE": "bisection of a begin, an end or a crossing of the margin",
    "END": "end of the pair",
    "MINIMUM": "search for the minimum distance",
}

_BOUNDS = {
    "speed_acceleration": "speed and acceleration of all points: (√(v² + 2 a d) − v) / a",
    "displacement": "motion bound of the known trajectories",
    "sphere_slabs": "separating slabs between the bounding spheres",
    "body_slab": "separating slab between the whole bodies",
    "triangle_slabs": "separating slabs between nearby triangles",
    "inscribed_spheres": "inscribed spheres that stay overlapping",
    "triangle_overlap": "two triangles that stay overlapping",
    "time_resolution": "minimum step",
    "contact_tolerance": "step inside a bracket",
    "windows": "swept boxes that do not overlap",
    "": "none: end of the pair, or a contact",
}

_MEANINGS = {
    "contact": "The bodies touch, measured at both inner ends. A gap shorter than the time resolution may be missed.",
    "breach": "Proved free of contact, but closer than the margin of the pair.",
    "unresolved": "Neither contact nor clearance is proved.",
    "possible": "The path of a body is unknown, and contact cannot be excluded.",
    "near": "Proved clear, but closer than the distance chosen here.",
    "clear": "Proved: the bodies share no point at any instant, and they keep the margin.",
}


def verdict(gathered: Gathered) -> str:
    """Return the banner about losses, the headline and the sentences after it."""
    places = {pair["pair"]: place for place, pair in enumerate(gathered.pairs)}
    told = "".join(f"<p>{sentence}</p>" for sentence in sentences(gathered.found, places))
    return f"{_banner(gathered)}<h1>{html_text(headline(gathered.found.summary))}</h1>{told}"


def worst(gathered: Gathered) -> str:
    """Return the table of the worst pairs."""
    pairs = gathered.pairs[:_MOST_WORST]
    if not pairs:
        return f"<p>{_nothing(gathered, 'The log lists no pairs')}</p>"
    lost = gathered.found.lost
    rows = [
        _worst_row(index, pair, lost.get(pair["pair"], []), gathered.found.length_unit)
        for index, pair in enumerate(pairs)
    ]
    more = gathered.found.summary["pairs_total"] - len(pairs)
    rest = f"<p>And {counted(more, 'more pair')}.</p>" if more > 0 else ""
    return _table(("Pair", "Verdict", "Minimum distance", "Time", "Proof"), rows) + rest


def legend() -> str:
    """Return the legend of the map."""
    items = (
        f'<li title="{html_text(meaning)}"><canvas class="swatch" data-class="{name}" width="32" height="16"></canvas>'
        f"{name}</li>"
        for name, meaning in _MEANINGS.items()
    )
    return f'<ul class="legend">{"".join(items)}</ul>'


def contacts(gathered: Gathered) -> str:
    """Return the table of contacts with their brackets, by begin."""
    found = [(pair, index, contact) for index, pair in enumerate(gathered.pairs) for contact in pair["contacts"]]
    found.sort(key=lambda row: (row[2]["begin"][1], row[0]["pair"]))
    if not found:
        return f"<p>{_nothing(gathered, 'The log has no contacts')}</p>"
    kinds = {(row, touch.time): touch.kind for row, touches in gathered.touches.items() for touch in touches}
    rows = []
    for pair, index, contact in found[:_MOST_CONTACTS]:
        (clear, touching), end = contact["begin"], contact["end"]
        begin = "at the start" if clear == touching else interval(clear, touching)
        keys = "; ".join(f"{body}: {' → '.join(filter(None, around))}" for body, around in contact["keys"].items())
        cells = (
            pair_name(pair),
            jump(index, touching),
            begin,
            until_the_end(pair["pair"] in gathered.found.lost) if end is None else interval(*end),
            "" if end is None else moment(end[0] - touching),
            kinds.get((index, touching), ""),
            f"<bdi>{html_text(keys)}</bdi>" if keys else "",
        )
        rows.append(cells)
    heads = ("Pair", "Touches at", "Begins within", "Ends within", "Lasts at least", "Kind", "Between keys")
    more = len(found) - _MOST_CONTACTS
    note = (
        f"<p>And {counted(more, 'later contact')}. For all contacts, run closecall summary LOG --json.</p>"
        if more > 0
        else ""
    )
    return _table(heads, rows) + note


def _nothing(gathered: Gathered, told: str) -> str:
    """Return a sentence; if parts of the log cannot be read, add that."""
    return (
        f"{told}."
        if gathered.loss is None and gathered.found.loss is None
        else f"{told} in the parts that can be read."
    )


def awakenings(gathered: Gathered) -> str:
    """Return the reasons of the wakeups, and the bounds that set the sleeps."""
    by_reason: dict[str, dict[str, int]] = {}
    for (reason, level), count in gathered.awakening.reasons.items():
        by_reason.setdefault(reason, {})[level] = count
    if not by_reason:
        return f"<p>{_nothing(gathered, 'The log has no wakeups')}</p>"
    totals = {reason: sum(levels.values()) for reason, levels in by_reason.items()}
    most = max(totals.values())
    rows = []
    for reason in sorted(totals, key=lambda reason: (-totals[reason], reason)):
        levels = ", ".join(f"{count} {level.lower()}" for level, count in sorted(by_reason[reason].items()))
        told = f"<code>{html_text(reason)}</code> {html_text(_REASONS.get(reason, ''))}"
        selected = f'<span data-reason="{html_text(reason)}"></span>'
        rows.append((told, _bar(totals[reason], most), html_text(levels), selected))
    heads = ("Reason", "Wakeups", "Measured by", "Selected pair")
    return f'<div class="columns">{_table(heads, rows)}{_sleeps(gathered)}</div>'


def provenance(gathered: Gathered) -> str:
    """Return the settings and the inputs of the run."""
    identity, summary = gathered.identity, gathered.found.summary
    start, end = summary["time"]
    messages = ", ".join(f"{count} {topic}" for topic, count in sorted(gathered.messages.items()))
    facts = {
        "Log": gathered.name,
        "Written by": f"closecall {identity.version}",
        "Scene file, SHA-256": identity.scene_sha256,
        "Time": f"{moment(start)} to {moment(end)}",
        "Epoch": f"{identity.epoch} ns",
        "Bodies": str(identity.bodies),
        "Pairs": f"{summary['pairs_total']} checked, {summary['pairs_ignored']} ignored by the scene",
        "Messages on this page": messages,
    }
    for key, value in summary["settings"].items():
        facts[key] = "none" if value is None else _setting(key, value, identity.length_unit)
    if gathered.warnings:
        facts["Warnings"] = "; ".join(gathered.warnings)
    terms = "".join(f"<dt>{html_text(key)}</dt><dd><bdi>{html_text(value)}</bdi></dd>" for key, value in facts.items())
    return f"<dl>{terms}</dl>"


def _setting(key: str, value: float, unit: str) -> str:
    if key == "margin":
        return length_text(value, unit, 12)
    return f"{value!r} s" if key in ("time_resolution", "contact_tolerance") else repr(value)


def guarantees() -> str:
    """Return the meaning of each verdict."""
    rows = [(_badge(name), html_text(meaning)) for name, meaning in _MEANINGS.items() if name != "near"]
    return _table(("Verdict", "Meaning"), rows)


def shown(gathered: Gathered) -> str:
    """Return the number of pairs on the map."""
    total, drawn = gathered.found.summary["pairs_total"], len(gathered.pairs)
    if drawn == total:
        return counted(total, "pair") + ", worst first"
    listed = len(gathered.found.summary["pairs"])
    limit = f", the worst of {listed}" if listed > MOST_PAIRS else ""
    return f"{drawn} of {counted(total, 'pair')}{limit}, worst first"


def _banner(gathered: Gathered) -> str:
    if gathered.loss is None and gathered.found.loss is None:
        return ""
    loss = gathered.found.loss or gathered.loss
    assert loss is not None
    folded = "This page shows the parts that can be read. Where spans are lost, nothing is proved."
    carried = (
        "The statements about pairs come from the summary in the log, which is complete. "
        "The map, the curves and the replay show the parts that can be read."
    )
    told = folded if gathered.found.folded else carried
    what = f"The log is {loss.told}."
    return f'<p class="banner" role="alert"><strong>Incomplete log.</strong> {html_text(what)} {told}</p>'


def _worst_row(index: int, pair: PairSummary, lost: Stretches, unit: str) -> Sequence[str]:
    time = when(pair)
    chord = pair["chord_error"]
    round_off = (
        f". Distances are to polyhedra around round shapes, up to {length(chord, unit)} outside them" if chord else ""
    )
    if (why := why_wide(pair["distance"])) is not None:
        round_off += f". Wide bracket: {why}"
    sure = "yes" if is_proved(pair) and not lost else "no"
    return (
        pair_name(pair),
        _badge(pair["verdict"]),
        nearest(pair, unit),
        "" if time is None else jump(index, time),
        f'<span class="proved" data-sure="{sure}">{proof(pair, lost, unit)}{round_off}.</span>',
    )


def _badge(verdict: str) -> str:
    return f'<span class="badge" data-class="{verdict}">{verdict}</span>'


def _sleeps(gathered: Gathered) -> str:
    bounds = gathered.awakening.bounds
    most = max(bounds.values())
    rows = [
        (f"<code>{html_text(bound)}</code> {_BOUNDS.get(bound, '')}", _bar(count, most))
        for bound, count in sorted(bounds.items(), key=lambda item: (-item[1], item[0]))
    ]
    return _table(("Bound that set the next sleep", "Wakeups"), rows)


def _bar(count: int, most: int) -> str:
    width = 100.0 * count / most
    return f'<span class="count"><span class="bar"><span style="width: {width:.1f}%"></span></span>{count}</span>'


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return an HTML table; each cell carries the head of its column, for narrow screens."""
    head = "".join(f'<th scope="col">{name}</th>' for name in heads)
    body = []
    for first, *others in rows:
        cells = "".join(f'<td data-head="{name}">{cell}</td>' for name, cell in zip(heads[1:], others, strict=True))
        body.append(f'<tr><th scope="row">{first}</th>{cells}</tr>')
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{"".join(body)}</tbody></table></div>'
