"""The scene at an instant, for viewers; no part of the certificate."""
