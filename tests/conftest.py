"""What every test starts from."""

import os


def pytest_configure() -> None:
    """Forget how wide the terminal around the tests is: their outputs go down a pipe."""
    os.environ.pop("COLUMNS", None)
