"""Lemmas spoilt on purpose, to see that a test notices each: `python -m spoilt`, from tests/."""

from __future__ import annotations

from dataclasses import dataclass

ROOT = "closecall.scheduler."


@dataclass(frozen=True, slots=True)
class Spoil:
    """A lemma, and how it is made false.

    Attributes:
        name: of the spoil.
        lemma: what is no longer so.
        module: that says it, below closecall.scheduler.
        old, new: text of the module, which stands there once, and what stands there instead.
        test: the direct test that notices: file and name.
    """

    name: str
    lemma: str
    module: str
    old: str
    new: str
    test: str

    @property
    def place(self) -> str:
        """The module's file, below scheduler/."""
        return f"{self.module.replace('.', '/')}.py"

    def applied(self, source: str) -> str:
        """Return the module's text with the lemma spoilt."""
        found = source.count(self.old)
        if found != 1:
            place = f"scheduler/{self.place}"
            remedy = "expected once: let tests/spoilt/lemmas.py spoil what stands there now"
            raise LookupError(f"spoil {self.name}: {self.old!r} stands {found} times in {place}, {remedy}")
        return source.replace(self.old, self.new)
