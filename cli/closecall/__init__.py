"""closecall: do any of these moving bodies come too close, and when? Answered with a certificate."""

__version__ = "0.1.0"
