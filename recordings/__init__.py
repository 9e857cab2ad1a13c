"""MCAP recordings: record a drive, read it, recover it, sum it up. Imports `wire` only."""
