"""Entry of ``python -m closecall``."""

from .cli.main import main

main()
