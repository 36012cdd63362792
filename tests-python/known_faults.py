"""Checks that fail because of a fault of splatvol that is known. One that passes must leave this list."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Fault:
    """What is wrong, and a part of the message by which the check fails."""

    reason: str
    says: str


KNOWN_FAULTS: dict[str, Fault] = {}
