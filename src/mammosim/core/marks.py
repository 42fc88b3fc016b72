"""What marks something in the texts of pages, and how it stands there as letters."""

import re

MARKS = r"\`*[](){}$"


def literal(text: object) -> str:
    """What a person, a file or a program has written, for a text: its marks are letters, its lines one."""
    return re.sub(rf"[{re.escape(MARKS)}]", r"\\\g<0>", " ".join(str(text).split()))
