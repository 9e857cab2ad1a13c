"""Proof of the code that must be right: every branch taken, every mutant killed, every decoder fuzzed. One table of files."""
