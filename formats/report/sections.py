"""The parts of a page that stand in its HTML: tables and lists, complete without scripts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ..log.bracket import why_wide
from ..log.result import Stretches
from ..log.summary import PairSummary
from ..log.tables.escapes import html_text
from ..scene.text.errors import counted
from .gathering import MOST_PAIRS, Gathered
from .quantities import interval, length, moment
from .wording import headline, is_proved, jump, nearest, pair_name, proof, sentences, until_the_end, when

# Rows of tables.
_MOST_WORST = 6
_MOST_CONTACTS = 1000

_REASONS = {
    "START": "the first look at the pair",
    "TIME_BOUND": "the certified sleep ran out",
    "TIME_RESOLUTION": "the least step, for the certified sleep was shorter",
    "KNOT": "a motion changes its law",
    "WINDOW": "the swept boxes of both bodies meet",
    "CONTACT": "a look at a contact that stands",
    "REFINE": "narrows the bracket of a begin, an end or a margin",
    "END": "the last look at the pair",
    "MINIMUM": "narrows the least distance",
}

_BOUNDS = {
    "speed_acceleration": "speed and acceleration of all points: (√(v² + 2 a d) − v) / a",
    "displacement": "how far the known trajectories can move the bodies",
    "sphere_slabs": "slabs between the bounding spheres",
    "body_slab": "a slab between the whole bodies",
    "triangle_slabs": "slabs between the triangles that are near each other",
    "inscribed_spheres": "spheres inside both bodies go on overlapping",
    "triangle_overlap": "two triangles go on overlapping",
    "time_resolution": "the least step",
    "contact_tolerance": "the step inside a bracket",
    "windows": "swept boxes that do not meet",
    "": "none: the last look, or a contact",
}

_MEANINGS = {
    "contact": "They touch: measured at both inner ends; a shorter gap than a time resolution may hide.",
    "breach": "Proved free of contact, but nearer than the pair's margin.",
    "unresolved": "Neither contact nor clearance could be proved.",
    "possible": "The path of a body is unknown: contact cannot be excluded.",
    "near": "Proved clear, and nearer than the distance chosen here.",
    "clear": "Proved: no point is shared at any instant, and the margin is kept.",
}


def verdict(gathered: Gathered) -> str:
    """Return the headline, what follows it, and what is lost."""
    places = {pair["pair"]: place for place, pair in enumerate(gathered.pairs)}
    told = "".join(f"<p>{sentence}</p>" for sentence in sentences(gathered.found, places))
    return f"{_banner(gathered)}<h1>{html_text(headline(gathered.found.summary))}</h1>{told}"


def worst(gathered: Gathered) -> str:
    """Return the table of the worst pairs, and what is proved of each."""
    pairs = gathered.pairs[:_MOST_WORST]
    if not pairs:
        return f"<p>{_nothing(gathered, 'No pair is listed')}</p>"
    lost = gathered.found.lost
    rows = [_worst_row(index, pair, lost.get(pair["pair"], [])) for index, pair in enumerate(pairs)]
    more = gathered.found.summary["pairs_total"] - len(pairs)
    rest = f"<p>And {counted(more, 'more pair')}.</p>" if more > 0 else ""
    return _table(("Pair", "Verdict", "Least distance", "When", "What is proved"), rows) + rest


def legend() -> str:
    """Return what the colours and patterns of the map mean."""
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
        return f"<p>{_nothing(gathered, 'No contact was found')}</p>"
    kinds = {(row, touch.time): touch.kind for row, touches in gathered.touches.items() for touch in touches}
    rows = []
    for pair, index, contact in found[:_MOST_CONTACTS]:
        (clear, touching), end = contact["begin"], contact["end"]
        begin = "stands at the start" if clear == touching else interval(clear, touching)
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
    heads = ("Pair", "Touches at", "Begin proved within", "End proved within", "Lasts at least", "Kind", "Between keys")
    more = len(found) - _MOST_CONTACTS
    note = f"<p>And {counted(more, 'later contact')}: closecall summary LOG --json lists all.</p>" if more > 0 else ""
    return _table(heads, rows) + note


def _nothing(gathered: Gathered, told: str) -> str:
    """Return that there is nothing, and of how much that is true."""
    return f"{told}." if gathered.loss is None and gathered.found.loss is None else f"{told} in what could be read."


def awakenings(gathered: Gathered) -> str:
    """Return why pairs woke, and which bound sent them to sleep."""
    by_reason: dict[str, dict[str, int]] = {}
    for (reason, level), count in gathered.awakening.reasons.items():
        by_reason.setdefault(reason, {})[level] = count
    if not by_reason:
        return f"<p>{_nothing(gathered, 'No wakeup was logged')}</p>"
    totals = {reason: sum(levels.values()) for reason, levels in by_reason.items()}
    most = max(totals.values())
    rows = []
    for reason in sorted(totals, key=lambda reason: (-totals[reason], reason)):
        levels = ", ".join(f"{count} {level.lower()}" for level, count in sorted(by_reason[reason].items()))
        told = f"<code>{html_text(reason)}</code> {html_text(_REASONS.get(reason, ''))}"
        selected = f'<span data-reason="{html_text(reason)}"></span>'
        rows.append((told, _bar(totals[reason], most), html_text(levels), selected))
    heads = ("Reason", "How often", "Measured by", "Selected pair")
    return f'<div class="columns">{_table(heads, rows)}{_sleeps(gathered)}</div>'


def provenance(gathered: Gathered) -> str:
    """Return the settings, and what was run."""
    identity, summary = gathered.identity, gathered.found.summary
    start, end = summary["time"]
    messages = ", ".join(f"{count} {topic}" for topic, count in sorted(gathered.messages.items()))
    facts = {
        "Log": gathered.name,
        "Made by": f"closecall {identity.version}",
        "Scene file, SHA-256": identity.scene_sha256,
        "Time": f"{moment(start)} to {moment(end)}",
        "Epoch": f"{identity.epoch} ns",
        "Bodies": str(identity.bodies),
        "Pairs": f"{summary['pairs_total']} checked, {summary['pairs_ignored']} ignored by the scene",
        "Messages shown here": messages,
    }
    units = {"margin": "m", "time_resolution": "s", "contact_tolerance": "s"}
    for key, value in summary["settings"].items():
        unit = f" {units[key]}" if key in units else ""
        facts[key] = "none" if value is None else f"{value!r}{unit}"
    if gathered.warnings:
        facts["Warnings"] = "; ".join(gathered.warnings)
    terms = "".join(f"<dt>{html_text(key)}</dt><dd><bdi>{html_text(value)}</bdi></dd>" for key, value in facts.items())
    return f"<dl>{terms}</dl>"


def guarantees() -> str:
    """Return what each verdict says is proved."""
    rows = [(_badge(name), html_text(meaning)) for name, meaning in _MEANINGS.items() if name != "near"]
    return _table(("Verdict", "What is certain"), rows)


def shown(gathered: Gathered) -> str:
    """Return which of the pairs are on the map."""
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
    folded = "This page tells what could be read; where spans are lost, nothing is proved."
    carried = (
        "What is said of pairs is the log's own summary, which is whole; map, curves and replay show what is left."
    )
    told = folded if gathered.found.folded else carried
    what = f"The log is {loss.told}."
    return f'<p class="banner" role="alert"><strong>Not the whole log.</strong> {html_text(what)} {told}</p>'


def _worst_row(index: int, pair: PairSummary, lost: Stretches) -> Sequence[str]:
    time = when(pair)
    chord = pair["chord_error"]
    round_off = f". Round shapes are measured as polyhedra, up to {length(chord)} outside them" if chord else ""
    if (why := why_wide(pair["distance"])) is not None:
        round_off += f". Wide: {why}"
    sure = "yes" if is_proved(pair) and not lost else "no"
    return (
        pair_name(pair),
        _badge(pair["verdict"]),
        nearest(pair),
        "" if time is None else jump(index, time),
        f'<span class="proved" data-sure="{sure}">{proof(pair, lost)}{round_off}.</span>',
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
    return _table(("What set the sleep after it", "How often"), rows)


def _bar(count: int, most: int) -> str:
    width = 100.0 * count / most
    return f'<span class="count"><span class="bar"><span style="width: {width:.1f}%"></span></span>{count}</span>'


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of cells in HTML; each cell bears its column's head, for screens too narrow for columns."""
    head = "".join(f'<th scope="col">{name}</th>' for name in heads)
    body = []
    for first, *others in rows:
        cells = "".join(f'<td data-head="{name}">{cell}</td>' for name, cell in zip(heads[1:], others, strict=True))
        body.append(f'<tr><th scope="row">{first}</th>{cells}</tr>')
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{"".join(body)}</tbody></table></div>'
