"""The list of lemmas that are spoilt on purpose fits the code and the tests, and docs/testing.md tells it."""

from __future__ import annotations

from dataclasses import replace

import pytest
from places import ROOT
from spoilt import Spoil
from spoilt.__main__ import failed
from spoilt.lemmas import SPOILS, table

NAMES = [spoil.name for spoil in SPOILS]


def source_of(spoil: Spoil) -> str:
    return (ROOT / "scheduler" / spoil.place).read_text(encoding="utf-8")


@pytest.mark.parametrize("spoil", SPOILS, ids=NAMES)
def test_what_is_to_be_spoilt_is_there(spoil: Spoil) -> None:
    spoilt = spoil.applied(source_of(spoil))
    assert spoilt != source_of(spoil)
    compile(spoilt, spoil.module, "exec")


@pytest.mark.parametrize("spoil", SPOILS, ids=NAMES)
def test_the_test_that_notices_is_there(spoil: Spoil) -> None:
    file, name = spoil.test.split("::")
    assert f"def {name}(" in (ROOT / "tests" / file).read_text(encoding="utf-8")


def test_a_spoil_of_code_that_is_gone_says_what_to_do() -> None:
    gone = replace(SPOILS[0], old="what nobody has written")
    with pytest.raises(LookupError, match=r"stands 0 times in scheduler/kinematics/chain\.py.*tests/spoilt/lemmas\.py"):
        gone.applied(source_of(gone))


def test_the_names_of_spoils_differ() -> None:
    assert len(set(NAMES)) == len(NAMES) >= 40


def test_the_table_in_the_docs_is_that_of_the_list() -> None:
    docs = (ROOT / "docs" / "testing.md").read_text(encoding="utf-8")
    assert table() in docs, "let docs/testing.md have what `python -m spoilt --table` prints, run from tests/"


def test_a_spoilt_lemma_fails_its_test_and_no_other() -> None:
    """All other lemmas are tried so by hand: `python -m spoilt`, some minutes."""
    spoil = next(one for one in SPOILS if one.name == "radii-nine-tenths")
    noticed = failed(
        spoil, spoil.test, "bounds/test_lemmas.py::test_two_measurements_prove_as_much_as_the_way_between_leaves"
    )
    assert noticed == [spoil.test.split("::")[1]]
