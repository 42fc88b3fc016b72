"""Leave out of one lock the pins that stand in another: `without_pins.py cluster.lock environment.lock`."""

import re
import sys
from pathlib import Path

PIN = re.compile(r"(?m)^(?=[A-Za-z][\w.-]*==)")


def without(lock: str, other: str) -> str:
    """The pins of the text of a lock, hashes included, whose names the other one lacks."""
    there = {pin.split("==")[0] for pin in PIN.split(other)}
    return "".join(pin for pin in PIN.split(lock) if pin.split("==")[0] not in there)


if __name__ == "__main__":
    path, other = map(Path, sys.argv[1:])
    path.write_text(
        without(path.read_text(encoding="utf-8"), other.read_text(encoding="utf-8")), encoding="utf-8"
    )
