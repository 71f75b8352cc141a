"""The results in a log as sentences that state no more than the log proves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..log.bracket import why_wide
from ..log.result import Found, Stretches
from ..log.severity import badness
from ..log.summary import PairSummary, Summary
from ..log.tables.escapes import html_text
from ..scene.quantities.lengths import at_least_text
from ..scene.text.errors import counted
from .quantities import interval, length, moment

# Intervals in a sentence about one pair.
_MOST_INTERVALS = 2


def pair_name(pair: PairSummary) -> str:
    """Return both names as HTML; each keeps its own writing direction."""
    return f'<span class="pair"><bdi>{html_text(pair["body_a"])}</bdi> | <bdi>{html_text(pair["body_b"])}</bdi></span>'


def headline(summary: Summary) -> str:
    """Return the verdict over all pairs."""
    counts, total = summary["totals"]["pairs"], summary["pairs_total"]
    start, end = summary["time"]
    of_all = f"of {counted(total, 'pair')}"
    if total == 0:
        return "No pairs were checked."
    if counts["contact"]:
        return f"{counts['contact']} {of_all} {_verb(counts['contact'], 'touches', 'touch')}."
    if counts["breach"]:
        return f"{counts['breach']} {of_all} {_verb(counts['breach'], 'comes', 'come')} closer than the margin."
    if counts["unresolved"]:
        return f"{counts['unresolved']} {of_all} {_verb(counts['unresolved'], 'is', 'are')} unresolved."
    if counts["possible"]:
        return f"{counts['possible']} {of_all} could touch: the path of a body is unknown."
    stay = "The pair stays" if total == 1 else f"All {total} pairs stay"
    return f"{stay} clear. This is proved for every instant from {moment(start)} to {moment(end)}."


def jump(place: int | None, time: float) -> str:
    """Return a time, s, as a button that shows the pair at that time; as text if the page does not show the pair."""
    if place is None:
        return moment(time)
    return f'<button type="button" class="jump" data-pair="{place}" data-time="{time!r}">{moment(time)}</button>'


def sentences(found: Found, places: Mapping[str, int]) -> list[str]:
    """Return the HTML after the headline: the first contact, the closest other pair, and the open questions.

    Args:
        found: the results in the log.
        places: the index of each pair on the page, by name.
    """
    summary = found.summary
    told = [_counts(summary), _first_contact(found, places), _closest(found, places), _unlisted(found)]
    return [sentence for sentence in told if sentence]


def nearest(pair: PairSummary, unit: str) -> str:
    """Return the minimum distance of a pair as text in `unit`."""
    upper = pair["distance"]["upper"]
    if pair["verdict"] == "contact":
        return "0 (contact)"
    if upper is not None:
        return length(upper, unit)
    lower = pair["distance"]["lower"]
    return f"above {at_least_text(lower, unit)}" if lower > 0.0 else "unknown"


def when(pair: PairSummary) -> float | None:
    """Return the time, s, of the first contact, or else of the minimum distance; None if unknown."""
    return pair["contacts"][0]["begin"][1] if pair["contacts"] else pair["distance"]["time"]


def proof(pair: PairSummary, lost: Stretches, unit: str) -> str:
    """Return what the log proves about a pair; the log has lost its spans in some intervals."""
    if not lost:
        return _proof(pair, unit)
    nothing = f"the log has lost the spans in {_intervals(lost)}"
    return f"Contact: {contact(pair, True)}; {nothing}" if pair["contacts"] else f"Unresolved: {nothing}"


def _proof(pair: PairSummary, unit: str) -> str:
    lower = pair["distance"]["lower"]
    closer = f"never closer than {at_least_text(lower, unit)}"
    match pair["verdict"]:
        case "contact":
            return f"Contact: {contact(pair, False)}" if pair["contacts"] else "Contact"
        case "clear":
            return f"Clear at every instant: {closer}"
        case "breach":
            within = f"within the margin of {length(pair['margin'], unit)} in {_intervals(pair['breaches'])}"
            return f"No contact: {closer}; {within}"
        case "possible":
            return f"Unknown path: contact cannot be excluded in {_intervals(pair['possible'])}"
        case _:
            open_in = _intervals(pair["unresolved"])
            if lower > 0.0:
                margin = f"a breach of the margin of {length(pair['margin'], unit)} cannot be excluded in {open_in}"
                return f"No contact: {closer}; {margin}"
            return f"Unresolved: contact is neither found nor excluded in {open_in}"


def is_proved(pair: PairSummary) -> bool:
    """Tell whether the verdict is proved."""
    return pair["verdict"] in ("contact", "breach", "clear")


def _counts(summary: Summary) -> str:
    """Return the number of pairs by verdict, unless all are clear."""
    counts = summary["totals"]["pairs"]
    told = {
        "contact": "in contact",
        "breach": "closer than the margin",
        "unresolved": "unresolved",
        "possible": "with an unknown path that could touch",
        "clear": "clear at every instant",
    }
    found = [f"{counts[verdict]} {words}" for verdict, words in told.items() if counts[verdict]]
    return "" if counts["clear"] == summary["pairs_total"] else f"All pairs: {', '.join(found)}."


def contact(pair: PairSummary, lost: bool) -> str:
    """Return a pair's first contact with the brackets of its begin and its end; the end may be lost."""
    first, more = pair["contacts"][0], len(pair["contacts"]) - 1
    clear, touching = first["begin"]
    told = "from the start" if clear == touching else f"begins within {interval(clear, touching)}"
    if first["end"] is None:
        told += f", {until_the_end(lost)}"
    else:
        told += f", lasts until {moment(first['end'][0])}, ends within {interval(*first['end'])}"
    return told + (f", and {counted(more, 'more contact')}" if more else "")


def until_the_end(lost: bool) -> str:
    """Return the end of a contact that has no end in the log."""
    return "end unknown" if lost else "lasts to the end of the run"


def _first_contact(found: Found, places: Mapping[str, int]) -> str:
    """Return the first contact, and the pairs whose brackets overlap its bracket: they may touch as early."""
    touching = sorted((pair for pair in found.summary["pairs"] if pair["contacts"]), key=_touches_at)
    if not touching:
        return ""
    first, *later = touching
    time = first["contacts"][0]["begin"][1]
    rivals = [pair for pair in later if pair["contacts"][0]["begin"][0] < time or _touches_at(pair)[0] == time]
    told = contact(first, first["pair"] in found.lost)
    sentence = f"First contact: {pair_name(first)} at {jump(places.get(first['pair']), time)}, {told}."
    return f"{sentence} {_such_as(rivals)} may touch as early or earlier." if rivals else sentence


def _touches_at(pair: PairSummary) -> tuple[float, str]:
    """Return a sorting key: the time, s, from which the first contact is certain, then the name."""
    return pair["contacts"][0]["begin"][1], pair["pair"]


def _closest(found: Found, places: Mapping[str, int]) -> str:
    """Return the pair with the smallest measured distance, except pairs in contact, and whether no other is closer."""
    summary, unit = found.summary, found.length_unit
    apart = [pair for pair in summary["pairs"] if pair["verdict"] != "contact" and not pair["contacts"]]
    others = len(apart) < len(summary["pairs"])
    measured = [pair for pair in apart if pair["distance"]["upper"] is not None]
    if not measured:
        lowest = min(apart, key=_lower, default=None)
        if lowest is None:
            return ""
        proved = proof(lowest, found.lost.get(lowest["pair"], []), unit)
        whose = "the other pairs" if others else "the pairs"
        return f"The run did not measure the distances of {whose}. {pair_name(lowest)}: {proved}."
    best = min(measured, key=lambda pair: (pair["distance"]["upper"] or 0.0, badness(pair)))
    distance = best["distance"]
    upper, time = distance["upper"] or 0.0, distance["time"] or 0.0
    never_closer = f"proved never closer than {at_least_text(distance['lower'], unit)}"
    certain = never_closer if distance["lower"] > 0.0 else "no lower bound above 0 is proved"
    if (why := why_wide(distance)) is not None:
        certain += f"; wide bracket: {why}"
    title = "Closest other pair" if others else "Closest pair"
    at = jump(places.get(best["pair"]), time)
    sentence = f"{title}: {pair_name(best)}, measured {length(upper, unit)} apart at {at} ({certain})."
    rivals = sorted((pair for pair in apart if pair is not best and pair["distance"]["lower"] < upper), key=_lower)
    if rivals:
        return f"{sentence} {_such_as(rivals)} may come as close or closer ({_stays(rivals[0], unit)})."
    if len(apart) == 1 or summary["pairs_total"] > len(summary["pairs"]):
        return sentence
    return f"{sentence} No other pair{' without contact' if others else ''} comes closer: this is proved."


def _lower(pair: PairSummary) -> tuple[float, str]:
    """Return a sorting key: the certified lower bound of the distance, m, then the name."""
    return pair["distance"]["lower"], pair["pair"]


def _stays(pair: PairSummary, unit: str) -> str:
    """Return the certified lower bound of a pair's distance as text."""
    lower = pair["distance"]["lower"]
    return (
        f"proved never closer than {at_least_text(lower, unit)}" if lower > 0.0 else "no lower bound above 0 is proved"
    )


def _such_as(pairs: Sequence[PairSummary]) -> str:
    """Return the first pair, and the number of pairs if there are more."""
    first = pair_name(pairs[0])
    return f"{len(pairs)} other pairs, such as {first}," if len(pairs) > 1 else first


def _unlisted(found: Found) -> str:
    summary = found.summary
    unlisted = summary["pairs_total"] - len(summary["pairs"])
    if unlisted <= 0:
        return ""
    if found.folded and found.loss is not None:
        return f"Nothing could be read about {counted(unlisted, 'pair')}."
    cleared = f"The broad phase cleared {counted(unlisted, 'pair')}: their swept boxes never overlap"
    return f"{cleared}. The log does not give their distances; one of them may come closer than the pairs above."


def _intervals(spans: Sequence[Sequence[float]]) -> str:
    told = [interval(start, end) for start, end in spans[:_MOST_INTERVALS]]
    more = len(spans) - len(told)
    return ", ".join(told) + (f" and {counted(more, 'more interval')}" if more else "") if told else "no interval"


def _verb(count: int, singular: str, plural: str) -> str:
    return singular if count == 1 else plural
