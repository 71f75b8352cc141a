"""The MCAP log: messages, writer, summary."""
