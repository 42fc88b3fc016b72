"""A figure is written as PNG for a page and as PDF at print size, the same bytes every time."""

import io
import re
import zlib

import numpy as np
from PIL import Image

from mammosim.figures.style import new_figure, styled
from mammosim.io.figures import DPI, missing_reason, pdf_of, png_of, write_figure


@styled
def drawn():
    figure = new_figure(2.0, width=4.0)
    left, right = figure.subplots(1, 2)
    left.plot([0, 1], [0, 1], label="a line")
    right.imshow(np.arange(12.0).reshape(3, 4), interpolation="none")
    left.set(xlabel="x (mm)", ylabel="y (mm)")
    return figure


def test_the_same_figure_has_the_same_bytes_and_no_date():
    assert png_of(drawn()) == png_of(drawn())
    pdf = pdf_of(drawn())
    assert pdf == pdf_of(drawn())
    assert b"Date" not in pdf


def test_a_page_gets_an_opaque_picture_and_print_a_vector_file_of_the_size_in_inches(tmp_path):
    write_figure(drawn(), tmp_path / "a figure.png")
    with Image.open(tmp_path / "a figure.png") as picture:
        assert picture.size == (4 * DPI, 2 * DPI)
        assert picture.mode in ("P", "RGB")
        assert "transparency" not in picture.info
    pdf = (tmp_path / "a figure.pdf").read_bytes()
    (box,) = re.findall(rb"/MediaBox \[ ([\d. ]+) \]", pdf)
    assert [float(number) for number in box.split()] == [0, 0, 4 * 72, 2 * 72]
    streams = [zlib.decompress(part) for part in re.findall(rb"stream\n(x.*?)\nendstream", pdf, re.S)]
    assert any(b" l\n" in each and b"BT" in each for each in streams), "lines and letters, no picture of them"
    assert re.search(rb"/Width 4\b", pdf), "an image has its own pixels"


def test_a_drawing_has_few_colours_and_a_photograph_all_of_its_own():
    assert Image.open(io.BytesIO(png_of(drawn()))).mode == "P"
    figure = new_figure(2.0, width=2.0)
    figure.figimage(np.random.default_rng(1).random((400, 400, 3)), resize=False)
    assert Image.open(io.BytesIO(png_of(figure))).mode == "RGB"


def test_both_files_have_one_layout(tmp_path):
    figure = drawn()
    write_figure(figure, tmp_path / "a.png")
    before = [ax.get_position().bounds for ax in figure.axes]
    pdf_of(figure)
    np.testing.assert_array_equal([ax.get_position().bounds for ax in figure.axes], before)


def test_a_reason_is_kept_in_the_picture_and_needs_no_ascii(tmp_path):
    write_figure(drawn(), tmp_path / "a.png", missing="Müller left: größer than 5 mm")
    assert missing_reason(tmp_path / "a.png") == "Müller left: größer than 5 mm"
    assert Image.open(io.BytesIO(png_of(drawn()))).info.get("Description") is None
