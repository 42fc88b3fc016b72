"""Files that a system leaves beside those of a person, and that are no part of any data."""

from pathlib import PurePath

# As Finder, Explorer and the disks of some makers leave them, in any folder and in any archive.
LEFT_BEHIND = frozenset({"__macosx", "thumbs.db", "ehthumbs.db", "desktop.ini", "@eadir"})


def is_hidden(name: str | PurePath) -> bool:
    """Whether a path below what was given is or lies in one of these: .DS_Store, ._1.dcm, Thumbs.db."""
    return any(part.startswith(".") or part.lower() in LEFT_BEHIND for part in PurePath(name).parts)
