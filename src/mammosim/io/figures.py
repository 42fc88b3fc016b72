"""Figures as PNG, the same bytes for the same figure."""

from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image

from mammosim.io.atomic import replacing

DPI = 150
MISSING = "Description"  # the keyword of a PNG's text that says why a figure is missing


def png_of(figure: Any, *, missing: str | None = None) -> bytes:
    """A matplotlib figure as PNG; missing: why it stands in the place of another one."""
    buffer = BytesIO()
    text = {"Software": None} | ({MISSING: missing} if missing else {})
    figure.savefig(buffer, dpi=DPI, format="png", metadata=text)
    return buffer.getvalue()


def write_figure(figure: Any, path: str | Path, *, missing: str | None = None) -> None:
    """Write a matplotlib figure as PNG, complete or not at all; missing: see png_of."""
    with replacing(path) as temporary:
        Path(temporary).write_bytes(png_of(figure, missing=missing))


def missing_reason(path: str | Path) -> str | None:
    """Why the figure of a file is missing; None where it is there."""
    with Image.open(path) as picture:
        return picture.info.get(MISSING)
