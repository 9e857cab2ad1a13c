"""Which way and how fast, and what stands in it."""
