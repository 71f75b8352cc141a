"""What a log found, in sentences: no more than is proved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..log.bracket import why_wide
from ..log.result import Found, Stretches
from ..log.severity import badness
from ..log.summary import PairSummary, Summary
from ..log.tables.escapes import html_text
from ..scene.text.errors import counted
from .quantities import at_least, interval, length, moment

# Of intervals told of one pair.
_MOST_INTERVALS = 2


def pair_name(pair: PairSummary) -> str:
    """Return both names as HTML, apart in whatever direction they are written."""
    return f'<span class="pair"><bdi>{html_text(pair["body_a"])}</bdi> | <bdi>{html_text(pair["body_b"])}</bdi></span>'


def headline(summary: Summary) -> str:
    """Return the verdict over all pairs."""
    counts, total = summary["totals"]["pairs"], summary["pairs_total"]
    start, end = summary["time"]
    of_all = f"of {counted(total, 'pair')}"
    if total == 0:
        return "No pair had to be checked."
    if counts["contact"]:
        return f"{counts['contact']} {of_all} {_verb(counts['contact'], 'touches', 'touch')}."
    if counts["breach"]:
        return f"{counts['breach']} {of_all} {_verb(counts['breach'], 'comes', 'come')} nearer than the margin."
    if counts["unresolved"]:
        return f"{counts['unresolved']} {of_all} {_verb(counts['unresolved'], 'is', 'are')} not proved to stay clear."
    if counts["possible"]:
        return f"{counts['possible']} {of_all} could touch, as far as their motion is known."
    stay = "The pair stays" if total == 1 else f"All {total} pairs stay"
    return f"{stay} clear, which is proved for every instant from {moment(start)} to {moment(end)}."


def jump(place: int | None, time: float) -> str:
    """Return a time, s, as a button that shows the pair in that place of the page then; of a pair without, as text."""
    if place is None:
        return moment(time)
    return f'<button type="button" class="jump" data-pair="{place}" data-time="{time!r}">{moment(time)}</button>'


def sentences(found: Found, places: Mapping[str, int]) -> list[str]:
    """Return, as HTML, what comes after the headline: the first contact, the closest of the others, what is open.

    Args:
        found: by the log.
        places: of the pairs in the page, by name.
    """
    summary = found.summary
    told = [_counts(summary), _first_contact(found, places), _closest(found, places), _unlisted(found)]
    return [sentence for sentence in told if sentence]


def nearest(pair: PairSummary) -> str:
    """Return how near a pair comes."""
    upper = pair["distance"]["upper"]
    if pair["verdict"] == "contact":
        return "0 (they touch)"
    if upper is not None:
        return length(upper)
    return f"above {at_least(pair['distance']['lower'])}" if pair["distance"]["lower"] > 0.0 else "not known"


def when(pair: PairSummary) -> float | None:
    """Return when, s, a pair begins to touch, or else is nearest; None where it is not known."""
    return pair["contacts"][0]["begin"][1] if pair["contacts"] else pair["distance"]["time"]


def proof(pair: PairSummary, lost: Stretches) -> str:
    """Return what is proved of a pair, whose spans are lost in some intervals."""
    if not lost:
        return _proof(pair)
    nothing = f"nothing is known of {_intervals(lost)}, which the log has lost"
    return f"Touches: {contact(pair, True)}; {nothing}" if pair["contacts"] else f"Not proved: {nothing}"


def _proof(pair: PairSummary) -> str:
    lower = pair["distance"]["lower"]
    match pair["verdict"]:
        case "contact":
            return f"Touches: {contact(pair, False)}" if pair["contacts"] else "Touches"
        case "clear":
            return f"Never nearer than {at_least(lower)}, at any instant"
        case "breach":
            within = f"within the margin of {length(pair['margin'])} in {_intervals(pair['breaches'])}"
            return f"No contact: never nearer than {at_least(lower)}; {within}"
        case "possible":
            return f"Path unknown: contact cannot be excluded in {_intervals(pair['possible'])}"
        case _:
            open_in = _intervals(pair["unresolved"])
            if lower > 0.0:
                margin = f"whether the margin of {length(pair['margin'])} is kept is open in {open_in}"
                return f"No contact: never nearer than {at_least(lower)}; {margin}"
            return f"Not proved: contact is neither found nor excluded in {open_in}"


def is_proved(pair: PairSummary) -> bool:
    """Tell whether the pair's verdict leaves nothing open."""
    return pair["verdict"] in ("contact", "breach", "clear")


def _counts(summary: Summary) -> str:
    """Return how many pairs have which verdict, unless all are clear."""
    counts = summary["totals"]["pairs"]
    told = {
        "contact": "in contact",
        "breach": "nearer than the margin",
        "unresolved": "not resolved",
        "possible": "could touch, of unknown path",
        "clear": "proved clear at every instant",
    }
    found = [f"{counts[verdict]} {words}" for verdict, words in told.items() if counts[verdict]]
    return "" if counts["clear"] == summary["pairs_total"] else f"All pairs: {', '.join(found)}."


def contact(pair: PairSummary, lost: bool) -> str:
    """Return a pair's first contact, with the brackets that hold its begin and its end, which may be lost."""
    first, more = pair["contacts"][0], len(pair["contacts"]) - 1
    clear, touching = first["begin"]
    told = "from the start" if clear == touching else f"begin proved within {interval(clear, touching)}"
    if first["end"] is None:
        told += f", {until_the_end(lost)}"
    else:
        told += f", until {moment(first['end'][0])}, end proved within {interval(*first['end'])}"
    return told + (f", and {counted(more, 'more contact')}" if more else "")


def until_the_end(lost: bool) -> str:
    """Return what is known of a contact without an end."""
    return "its end is not known" if lost else "to the end"


def _first_contact(found: Found, places: Mapping[str, int]) -> str:
    """Return the first contact that was found, and those that may be as early: their brackets overlap."""
    touching = sorted((pair for pair in found.summary["pairs"] if pair["contacts"]), key=_touches_at)
    if not touching:
        return ""
    first, *later = touching
    time = first["contacts"][0]["begin"][1]
    rivals = [pair for pair in later if pair["contacts"][0]["begin"][0] < time or _touches_at(pair)[0] == time]
    told = contact(first, first["pair"] in found.lost)
    sentence = f"First contact: {pair_name(first)} at {jump(places.get(first['pair']), time)}, {told}."
    return f"{sentence} As early or earlier may touch {_such_as(rivals)}." if rivals else sentence


def _touches_at(pair: PairSummary) -> tuple[float, str]:
    """Return when, s, a pair that touches is first known to, as a sorting key."""
    return pair["contacts"][0]["begin"][1], pair["pair"]


def _closest(found: Found, places: Mapping[str, int]) -> str:
    """Return the pair that was measured closest without touching, and whether that is proved."""
    summary = found.summary
    apart = [pair for pair in summary["pairs"] if pair["verdict"] != "contact" and not pair["contacts"]]
    others = len(apart) < len(summary["pairs"])
    measured = [pair for pair in apart if pair["distance"]["upper"] is not None]
    if not measured:
        lowest = min(apart, key=_lower, default=None)
        if lowest is None:
            return ""
        whose = "the others" if others else "they"
        proved = proof(lowest, found.lost.get(lowest["pair"], []))
        return f"How near {whose} come was not measured. {pair_name(lowest)}: {proved}."
    best = min(measured, key=lambda pair: (pair["distance"]["upper"] or 0.0, badness(pair)))
    distance = best["distance"]
    upper, time = distance["upper"] or 0.0, distance["time"] or 0.0
    never_nearer = f"proved never nearer than {at_least(distance['lower'])}"
    certain = never_nearer if distance["lower"] > 0.0 else "its least distance is not proved to be above 0"
    if (why := why_wide(distance)) is not None:
        certain += f": a wide bracket, because {why}"
    title = "Closest of the others" if others else "Closest"
    at = jump(places.get(best["pair"]), time)
    sentence = f"{title}: {pair_name(best)}, measured {length(upper)} apart at {at} ({certain})."
    rivals = sorted((pair for pair in apart if pair is not best and pair["distance"]["lower"] < upper), key=_lower)
    if rivals:
        return f"{sentence} As near or nearer may come {_such_as(rivals)}, {_stays(rivals[0])}."
    if len(apart) == 1 or summary["pairs_total"] > len(summary["pairs"]):
        return sentence
    return f"{sentence} It is proved that {'none of the others' if others else 'no other pair'} comes nearer."


def _lower(pair: PairSummary) -> tuple[float, str]:
    """Return what is proved of a pair's distance, m, as a sorting key."""
    return pair["distance"]["lower"], pair["pair"]


def _stays(pair: PairSummary) -> str:
    """Return how far a pair is proved to stay apart."""
    lower = pair["distance"]["lower"]
    return f"proved to stay {at_least(lower)} apart" if lower > 0.0 else "of which nothing is proved"


def _such_as(pairs: Sequence[PairSummary]) -> str:
    """Return how many other pairs there are, by the first."""
    return (f"{len(pairs)} other pairs, such as " if len(pairs) > 1 else "") + pair_name(pairs[0])


def _unlisted(found: Found) -> str:
    summary = found.summary
    unlisted = summary["pairs_total"] - len(summary["pairs"])
    if unlisted <= 0:
        return ""
    if found.folded and found.loss is not None:
        return f"Of {counted(unlisted, 'pair')} nothing could be read."
    cleared = f"{counted(unlisted, 'pair')} stayed clear by boxes that never meet"
    return f"{cleared}: how near they come is not told, so one may come closer."


def _intervals(spans: Sequence[Sequence[float]]) -> str:
    told = [interval(start, end) for start, end in spans[:_MOST_INTERVALS]]
    more = len(spans) - len(told)
    return ", ".join(told) + (f" and {counted(more, 'more interval')}" if more else "") if told else "no interval"


def _verb(count: int, singular: str, plural: str) -> str:
    return singular if count == 1 else plural
