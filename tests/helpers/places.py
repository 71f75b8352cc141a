"""Where things lie: folders of the repository, for the tests."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
"""The repository."""

HELPERS = ROOT / "tests" / "helpers"
SAMPLES = ROOT / "sample_scenes"

SHARED = ROOT.parent / "shared" / "data"
"""Files that are too large for the repository; tests of them are skipped where they are not there."""
