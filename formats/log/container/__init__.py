"""The bytes of an MCAP file: records, chunks, attachments, whole or damaged."""
