"""MCAP recordings: record a drive, read it, recover it, sum it up, check its steps, play it. Imports `wire` only."""
