"""Fuzzing of every reader: `./run fuzz [SECONDS]`."""
