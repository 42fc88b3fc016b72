"""The entries of a BibTeX text as rows to print."""

import re

ENTRY = re.compile(r"@(\w+)\{(\w+),(.*?)\n\}", re.S)
FIELD = re.compile(r"(\w+) = \{(.*?)\},?\s*(?=\n|$)", re.S)
ACCENT = re.compile(r"\{\\\^i\}")


def entries(text: str) -> list[dict[str, str]]:
    """key, author, year, title and where it appeared, of every entry, sorted by key."""
    rows = []
    for _, key, body in ENTRY.findall(text):
        fields = {name: _plain(value) for name, value in FIELD.findall(body)}
        where = fields.get("journal") or fields.get("institution", "")
        rows.append(
            {"key": key, "author": fields.get("author", ""), "year": fields.get("year", "")}
            | {"title": fields.get("title", ""), "in": f"{where} {fields.get('volume', '')}".strip()}
        )
    return sorted(rows, key=lambda row: row["key"])


def _plain(value: str) -> str:
    return ACCENT.sub("î", value).replace("{", "").replace("}", "").replace("\\", "")
