"""For pytest, `-p spoilt.plugin`: the spoil that CLOSECALL_SPOIL names is applied to the code as it is imported."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from types import CodeType, ModuleType

from . import ROOT, Spoil
from .lemmas import SPOILS


class SpoiltLoader(SourceFileLoader):
    """Loads a module's text with a lemma spoilt."""

    spoil: Spoil

    def get_code(self, fullname: str) -> CodeType:
        """Compile the spoilt text; no cache is read or written."""
        return compile(self.spoil.applied(self.get_data(self.path).decode()), self.path, "exec")


class Finder:
    """Finds the one module that is to be spoilt."""

    def __init__(self, spoil: Spoil) -> None:
        self._spoil = spoil
        self._module = ROOT + spoil.module

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return how the module is loaded, None for all others."""
        if name != self._module:
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is None or spec.origin is None:
            raise LookupError(f"spoil {self._spoil.name}: there is no module {name}")
        spec.loader = SpoiltLoader(name, spec.origin)
        spec.loader.spoil = self._spoil
        return spec


def install(name: str) -> None:
    """Spoil a lemma from now on.

    Raises:
        LookupError: there is no such spoil, or the module is already imported.
    """
    spoil = next((one for one in SPOILS if one.name == name), None)
    if spoil is None:
        raise LookupError(f"no spoil is called {name}")
    if ROOT + spoil.module in sys.modules:
        raise LookupError(f"spoil {name}: {spoil.module} is already imported, too late to spoil it")
    sys.meta_path.insert(0, Finder(spoil))


install(os.environ["CLOSECALL_SPOIL"])
