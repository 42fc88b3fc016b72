"""Figures as PNG, the same bytes for the same figure."""

from io import BytesIO
from pathlib import Path
from typing import Any

from mammosim.io.atomic import replacing

DPI = 150


def png_of(figure: Any) -> bytes:
    """A matplotlib figure as PNG."""
    buffer = BytesIO()
    figure.savefig(buffer, dpi=DPI, format="png", metadata={"Software": None})
    return buffer.getvalue()


def write_figure(figure: Any, path: str | Path) -> None:
    """Write a matplotlib figure as PNG, complete or not at all."""
    with replacing(path) as temporary:
        Path(temporary).write_bytes(png_of(figure))
