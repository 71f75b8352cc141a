"""A comparison as a JUnit report for CI servers: one suite, with one test case per pair."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from pathlib import Path

from ...scene.text.errors import printable
from ..container.output import Output, published
from .difference import Comparison, Difference
from .wording import sentence


def write_junit(output: Output, comparison: Comparison, golden: Path, new: Path) -> None:
    """Write the report; an existing file is replaced once the new one is whole.

    Raises:
        LogError: where the file cannot be written.
    """
    with published(output) as stream:
        stream.write(junit(comparison, golden, new).encode())


def junit(comparison: Comparison, golden: Path, new: Path) -> str:
    """Return the report: a pair that differs is a failure; a place that cannot be read is an error."""
    by_case: dict[str, list[Difference]] = defaultdict(list)
    for one in comparison.differences:
        by_case[one.subject].append(one)
    names = list(dict.fromkeys((*comparison.pairs, *by_case)))
    suite = ElementTree.Element(
        "testsuite",
        name=printable(f"closecall diff {golden.name} {new.name}"),
        tests=str(len(names) + len(comparison.losses)),
        failures=str(len(by_case)),
        errors=str(len(comparison.losses)),
        skipped="0",
    )
    for name in names:
        case = ElementTree.SubElement(
            suite, "testcase", classname=printable(new.name), name=printable(name or "the whole run")
        )
        if name in by_case:
            lines = [printable(sentence(one, comparison.length_unit)) for one in by_case[name]]
            cause = by_case[name][0].cause.label
            ElementTree.SubElement(case, "failure", type=cause, message=lines[0]).text = "\n".join(lines)
    for loss in comparison.losses:
        case = ElementTree.SubElement(
            suite, "testcase", classname=printable(new.name), name=printable(f"{loss.path.name} is complete")
        )
        ElementTree.SubElement(case, "error", type="damaged", message=printable(str(loss)))
    suites = ElementTree.Element("testsuites")
    suites.append(suite)
    ElementTree.indent(suites)
    return ElementTree.tostring(suites, encoding="unicode", xml_declaration=True) + "\n"
