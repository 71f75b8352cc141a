"""Entry of ``python -m closecall``."""

from closecall.cli.main import main

main()
