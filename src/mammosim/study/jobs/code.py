"""Which files of the package a file depends on: what is edited there reruns what depends on it."""

import re
from collections.abc import Iterator

IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+(?P<module>mammosim[\w.]*)[ \t]+import[ \t]+(?P<names>\([^)]*\)|[^\n#]+)"
    r"|import[ \t]+(?P<whole>mammosim[\w.]+))",
    re.MULTILINE,
)
TABLE = re.compile(r"\btabulated\(\s*[\"'](\w+)[\"']")
TEMPLATE = re.compile(r"\btemplate\(\s*[\"']([\w.]+)[\"']")
NAME = re.compile(r"\w+(?:[ \t]+as[ \t]+\w+)?")


def imported(text: str) -> Iterator[str]:
    """Dotted names that may be modules: of every import of the package, `from a import b` as a and a.b."""
    for found in IMPORT.finditer(text):
        if found["whole"]:
            yield found["whole"]
            continue
        yield found["module"]
        names = re.sub(r"#[^\n]*", "", found["names"])
        yield from (f"{found['module']}.{name.group().split()[0]}" for name in NAME.finditer(names))


def tables(text: str) -> list[str]:
    """Names of the tables of io/data that it reads with tabulated('name')."""
    return TABLE.findall(text)


def templates(text: str) -> list[str]:
    """Names of the templates that it reads with template('name')."""
    return TEMPLATE.findall(text)
