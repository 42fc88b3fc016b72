"""What was understood of one volunteer's data, and every reason for which the study would stop: a page."""

import logging

import _log
import _pages
import check_input
import numpy as np

from mammosim.chain.thickness import depth_in, of_depth
from mammosim.core.errors import MammosimError
from mammosim.core.positions import gravity_vector
from mammosim.core.volume import Image
from mammosim.figures.understood import one_slice, understood
from mammosim.imaging.quality import image_quality
from mammosim.io.any_slice import any_slice
from mammosim.io.atomic import replacing
from mammosim.io.figures import png_of
from mammosim.io.tables import write_json
from mammosim.io.understood import codes_read, orientation_read, series_read
from mammosim.study.report.pages import Picture, report
from mammosim.study.report.women import Checked, checked_sections


def main(volunteer: str, rows: list[dict], told: dict, out: dict[str, str]) -> None:
    looked = {row["position"]: look(row, told) for row in rows if row["there"]}
    thickness = " ".join([told["thickness"], *thickness_words(looked, told)])
    checked = [position_checked(volunteer, row, looked[row["position"]]) for row in rows if row["there"]]
    sections = checked_sections(
        checked, told["planned"], told["gains"], thickness=thickness, waits=told["waits"]
    )
    title = f"mammosim: {volunteer}, what was understood"
    page = report(title, sections, numbers={}, footer=_pages.made_by("snakemake check"))
    with replacing(out["page"]) as temporary:
        temporary.write_text(page, encoding="utf-8")
    stops = [f"{each.position}: {why}" for each in checked if each.used for why in each.reasons]
    write_json({"volunteer": volunteer, "stops": stops, "waits": told["waits"]}, out["verdict"])


def look(row: dict, told: dict) -> check_input.Seen:
    """All that is given of a position; a fault of the program is one of its faults, too."""
    try:
        gravity = gravity_vector(row["gravity"])
        taken = check_input.taken_by(row["codes"], told["element_mm"])
        asked = check_input.Asked(**told["asked"], how=row["how"], taken=taken)
        return check_input.look(row["files"], row["position"], gravity, asked)
    except Exception as error:
        return check_input.Seen(faults=[fault_of_the_program(error)])


def position_checked(volunteer: str, row: dict, seen: check_input.Seen) -> Checked:
    """One position: all that can be seen of it, and why it cannot be used."""
    position = row["position"]
    try:
        pictures = pictures_of(volunteer, row, seen)
        quality = {} if seen.image is None else image_quality(seen.image, position=position)
        if "images" not in seen.images:  # labels have no noise
            quality = {name: value for name, value in quality.items() if "noise" not in name}
        read = read_of(row, seen)
    except Exception as error:
        pictures, quality, read = (), {}, {}
        seen.faults.append(fault_of_the_program(error))
    reasons = tuple(" ".join(str(fault).split()) for fault in seen.faults)
    return Checked(position, row["used"], row["files"], reasons, quality, pictures, tuple(seen.notes), read)


def read_of(row: dict, seen: check_input.Seen) -> dict[str, str]:
    """How her files were read: codes, series, gaps, and where her head and her left are taken to be."""
    files, tag = row["files"], None if seen.scan is None else seen.scan.patient_position
    found = {} if seen.coded is None else codes_read(seen.coded, row["codes"]["codes"])
    found |= {} if seen.scan is None else series_read(seen.scan, **row["how"])
    if seen.image is None:
        return found
    path = files["images"] if "images" in seen.images else files["labels"]
    return found | {"orientation": orientation_read(path, tag, listed="listed" in files)}


def thickness_words(looked: dict[str, check_input.Seen], told: dict) -> list[str]:
    """How thick that is, as far as labels tell; no sensible thickness is a fault of the modelled position."""
    seen = looked.get(told["modelled"])
    if told["stated"] or seen is None or seen.labels is None or seen.listed is None:
        return []
    given, words = told["compression"], []
    for side in given["sides"]:
        if f"nipple_{side}" not in seen.listed.names:
            continue  # which is a fault already
        with seen.judged():
            nipple = seen.listed.point(f"nipple_{side}")
            depth = depth_in(seen.labels, nipple)
            if np.isfinite(depth):
                found = of_depth(depth, share=given["depth_share"], smallest_mm=given["smallest_mm"])
                words.append(f"In her labels that is about {found.mm:.0f} mm ({side}).")
    return words


def fault_of_the_program(error: Exception) -> MammosimError:
    """What nobody foresaw, which the log tells in full: it hides nothing of another position."""
    if isinstance(error, MammosimError):
        return error
    logging.error("not foreseen", exc_info=error)
    return MammosimError(f"a fault of the program, {type(error).__name__}: {error}")


def pictures_of(volunteer: str, row: dict, seen: check_input.Seen) -> tuple[Picture, ...]:
    """What can be drawn of a position: planes of its image or its labels, else one slice as it is stored."""
    name = f"{volunteer}, {row['position'].replace('_', ' ')}"
    image, labels = seen.image, seen.labels
    if image is None and seen.coded is not None:  # codes that nobody knows
        image = Image(seen.coded.grid, seen.coded.codes.astype(np.float32))
    if image is None:
        values = any_slice(row["files"].get("images", ""))
        stored = f"{name}: one slice as it is stored; the series makes no volume"
        return () if values is None else (Picture(png_of(one_slice(values, title=stored)), stored),)
    name = f"{name}: {' x '.join(f'{step:.2f}' for step in image.grid.spacing)} mm"
    figure = understood(
        image,
        labels=labels,
        fiducials=seen.listed,
        gravity=gravity_vector(row["gravity"]),
        title=name,
    )
    return (Picture(png_of(figure), caption_of(name, labels is not None, seen.listed is not None)),)


def caption_of(name: str, labelled: bool, listed: bool) -> str:
    """What a picture shows."""
    more = [
        words
        for words, there in (("outlines of the labels", labelled), ("points as listed or found", listed))
        if there
    ]
    with_them = f", with {' and '.join(more)}" if more else ""
    return (
        f"{name}{with_them}. g is gravity (a dot: towards the eye, a cross: away from it); R and L are her "
        "right and left, A and P anterior and posterior, I and S inferior and superior. Filled points lie "
        "near the slice."
    )


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        snakemake.wildcards.v,
        snakemake.params.rows,
        snakemake.params.told,
        {name: str(path) for name, path in snakemake.output.items()},
    )
