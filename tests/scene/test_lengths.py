"""Lengths as people write and read them."""

from __future__ import annotations

from decimal import ROUND_FLOOR
from fractions import Fraction
from math import inf
from random import Random

import pytest

from closecall.formats.scene.quantities.lengths import at_least_text, length_text, read_length
from closecall.formats.scene.quantities.units import METRES


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("2mm", 0.002),
        (" 2 mm ", 0.002),
        ("0.002", 0.002),
        ("2e-3m", 0.002),
        ("35mm", 0.035),
        ("1cm", 0.01),
        ("5um", 5e-6),
        ("1in", 0.0254),
        ("10ft", 3.048),
        ("-1mm", -0.001),
        ("inf", inf),
    ],
)
def test_a_length_is_a_number_and_a_unit(text: str, metres: float) -> None:
    assert read_length(text) == metres


@pytest.mark.parametrize("text", ["", "mm", "2 furlong", "2mmm", "2 m m", "nan", "nanmm", "0x2", "2,5mm", "2MM"])
def test_other_texts_are_not_lengths(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011
        read_length(text)


@pytest.mark.parametrize(
    ("metres", "unit", "text"),
    [
        (0.0, "mm", "0"),
        (0.035, "mm", "35 mm"),
        (0.0254, "in", "1 in"),
        (1 / 3, "m", "0.333333 m"),
        (1e-9, "m", "1e-9 m"),
        (1.25e-9, "mm", "1.25e-6 mm"),
        (123456.7, "m", "123457 m"),
        (1234567.8, "m", "1234570 m"),
        (1.0, "ft", "3.28084 ft"),
        (1e31, "m", "1e31 m"),
    ],
)
def test_a_length_is_told_in_six_digits_of_its_unit(metres: float, unit: str, text: str) -> None:
    assert length_text(metres, unit) == text


def test_a_lower_bound_is_never_rounded_up_in_any_unit() -> None:
    draw = Random(7)
    for _ in range(2000):
        metres, unit = draw.random() * 10.0 ** draw.randint(-12, 9), draw.choice(list(METRES))
        number, _, name = at_least_text(metres, unit).partition(" ")
        numerator, denominator = METRES[unit]
        told, written = Fraction(number) * numerator / denominator, Fraction(repr(metres))
        assert name == unit
        assert written * (1 - Fraction(1, 1000)) <= told <= written
        assert length_text(metres, unit, 3, ROUND_FLOOR).endswith(unit)
