"""closecall as a process of its own, or inside the tests' own: what the tests of the command line share."""

import os
import pty
import signal
import subprocess
import sys
import time
from contextlib import chdir, redirect_stderr, redirect_stdout
from io import BytesIO, TextIOWrapper
from pathlib import Path

from mcap.exceptions import McapError
from mcap.records import Message
from mcap.stream_reader import StreamReader

from closecall.cli.main import main

SPHERES = """\
closecall: 1
units: {length: m, angle: deg}
time: {start: 0, end: 5}
bodies:
  left: {pose: {xyz: [-2, 0, 0]}, shapes: [{sphere: 0.5}], motion: {type: constant, velocity: [1, 0, 0]}}
  right: {pose: {xyz: [2, 0.3, 0]}, shapes: [{sphere: 0.25}], motion: {type: constant, velocity: [-1, 0, 0]}}
"""


def command(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "closecall", *map(str, arguments)]


def closecall(*arguments: object, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the command to its end."""
    variables = {**os.environ, **environment}
    return subprocess.run(command(*arguments), cwd=cwd, env=variables, capture_output=True, text=True, timeout=120)


def closecall_inside(*arguments: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the command inside this process, which saves starting one."""
    out, err = (TextIOWrapper(BytesIO(), encoding="utf-8") for _ in range(2))
    argv, handler = sys.argv, signal.getsignal(signal.SIGTERM)
    sys.argv = ["closecall", *map(str, arguments)]
    code: object = None
    try:
        with chdir(cwd), redirect_stdout(out), redirect_stderr(err):
            main()
    except SystemExit as left:
        code = left.code
    finally:
        sys.argv = argv
        signal.signal(signal.SIGTERM, handler)
    for stream in (out, err):
        stream.seek(0)
    return subprocess.CompletedProcess(sys.argv, code if isinstance(code, int) else 0, out.read(), err.read())


def long_scene() -> str:
    """Return a scene that takes minutes: spheres that touch in a point and turn, woken every 1e-5 s."""
    body = "  b{0}: {{pose: {{xyz: [{0}, 0, 0]}}, shapes: [{{sphere: 0.5}}], motion: {{type: constant, {1}}}}}\n"
    text = SPHERES.split("bodies:")[0] + "settings: {time_resolution: 1e-5}\nbodies:\n"
    return text + "".join(body.format(i, "angular_velocity: [0, 0, 10]") for i in range(8))


def started(scene: Path, output: Path, *options: str) -> subprocess.Popen[str]:
    """Start a run of the long scene and wait until its log has grown."""
    scene.write_text(long_scene())
    process = subprocess.Popen(
        command("run", scene, "-o", output, *options),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # whoever runs the tests in the background has SIGINT ignored, and children inherit that
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    partial = Path(f"{output}.partial")
    for _ in range(6000):
        if partial.exists() and partial.stat().st_size > 100_000:
            return process
        time.sleep(0.01)
    process.kill()
    raise AssertionError(f"no log after a minute: {process.communicate()}")


def messages_before_the_cut(path: Path) -> int:
    """Return how many messages mcap's stream reader gets out of an unfinished log."""
    count = 0
    try:
        with path.open("rb") as file:
            for record in StreamReader(file).records:
                count += isinstance(record, Message)
    except McapError:
        pass
    return count


def on_a_terminal(*arguments: object, cwd: Path, columns: int = 80, **environment: str) -> str:
    """Run the command on a terminal of this width and return all that it showed."""
    leader, follower = pty.openpty()
    variables = {**os.environ, "TERM": "xterm-256color", "COLUMNS": str(columns), "LINES": "40", **environment}
    process = subprocess.Popen(command(*arguments), cwd=cwd, env=variables, stdout=follower, stderr=follower)
    os.close(follower)
    shown = b""
    try:
        while data := os.read(leader, 65536):
            shown += data
    except OSError:  # the other side closed
        pass
    process.wait(timeout=60)
    os.close(leader)
    return shown.decode()
