"""Figures as PNG for a page and as PDF at print size, the same bytes for the same figure."""

from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image, ImageChops, ImageStat
from PIL.PngImagePlugin import PngInfo

from mammosim.io.atomic import replacing

DPI = 200  # of a page on a screen: a figure of 17 cm has 1340 pixels
PRINT_DPI = 300  # of what a vector file holds as pixels: images, shaded surfaces, dense clouds of points
SEEN = 1.0  # of 255 levels, rms over a picture: a difference that is seen
MISSING = "Description"  # the keyword of a PNG's text that says why a figure is missing


def png_of(figure: Any, *, missing: str | None = None) -> bytes:
    """A matplotlib figure as PNG; missing: why it stands in the place of another one."""
    drawn, small, text = BytesIO(), BytesIO(), PngInfo()
    figure.savefig(drawn, dpi=DPI, format="png", pil_kwargs={"compress_level": 1})
    if missing:
        text.add_text(MISSING, missing)
    few = _few_colours(Image.open(drawn).convert("RGB"))
    few.save(small, "png", pnginfo=text, dpi=(DPI, DPI), optimize=True)
    return small.getvalue()


def _few_colours(picture: Image.Image) -> Image.Image:
    """The picture in 256 colours where nobody sees the difference: lines and letters, no photographs."""
    few = picture.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    difference = ImageStat.Stat(ImageChops.difference(picture, few.convert("RGB")))
    return few if max(difference.rms) < SEEN else picture


def pdf_of(figure: Any) -> bytes:
    """A matplotlib figure as PDF of its own size in inches, without a date."""
    buffer = BytesIO()
    figure.savefig(buffer, dpi=PRINT_DPI, format="pdf", metadata={"CreationDate": None})
    return buffer.getvalue()


def write_figure(figure: Any, path: str | Path, *, missing: str | None = None) -> None:
    """Write a matplotlib figure as PNG, and as PDF beside it; missing: see png_of."""
    with replacing(path) as temporary:
        Path(temporary).write_bytes(png_of(figure, missing=missing))
    # What the first drawing laid out is kept, so that both are the same and the layout is found once.
    figure.set_layout_engine("none")
    with replacing(Path(path).with_suffix(".pdf")) as temporary:
        Path(temporary).write_bytes(pdf_of(figure))


def missing_reason(path: str | Path) -> str | None:
    """Why the figure of a PNG is missing; None where it is there."""
    with Image.open(path) as picture:
        return picture.info.get(MISSING)
