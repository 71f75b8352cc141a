"""By hand, from tests/: each spoil, or those that are named, must fail its test; `NAME FILE...` tries other files.

`python -m spoilt --table` prints the table of docs/testing.md.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from . import Spoil
from .lemmas import SPOILS, table

HERE = Path(__file__).parents[1]


def failed(spoil: Spoil, *tests: str) -> list[str]:
    """Return the tests that fail while a lemma is spoilt; a file that cannot be run fails as a whole."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "spoilt.plugin", "-p", "no:cacheprovider", "-rfE", "--tb=no"]
    path = os.pathsep.join((str(HERE), os.environ.get("PYTHONPATH", "")))
    environment = {**os.environ, "CLOSECALL_SPOIL": spoil.name, "PYTHONPATH": path}
    ran = subprocess.run([*command, *tests], cwd=HERE, env=environment, capture_output=True, text=True, check=False)
    if ran.returncode not in (0, 1):
        raise RuntimeError(f"pytest ended with {ran.returncode}:\n{ran.stdout}\n{ran.stderr}")
    lines = ran.stdout.splitlines()
    return [line.split(" - ")[0].split("::")[-1] for line in lines if line.startswith(("FAILED", "ERROR"))]


def main(arguments: list[str]) -> int:
    """Run the spoils that the arguments name; return how many nothing noticed."""
    if arguments == ["--table"]:
        print(table(), end="")
        return 0
    files = [word for word in arguments if word.endswith(".py")]
    names = [word for word in arguments if word not in files]
    unnoticed = 0
    for spoil in SPOILS:
        if names and spoil.name not in names:
            continue
        noticed = failed(spoil, *(files or [spoil.test]))
        unnoticed += not noticed
        print(f"{spoil.name}: {', '.join(noticed) if noticed else 'NOTHING NOTICES'}", flush=True)
    return unnoticed


if __name__ == "__main__":
    sys.exit(bool(main(sys.argv[1:])))
