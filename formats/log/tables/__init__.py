"""Messages as rows, for CSV, NDJSON and Parquet."""
