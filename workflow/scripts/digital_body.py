"""The stress-free body of a virtual patient as a mesh, what it consists of, and her true moduli."""

import _log
import numpy as np

from mammosim.core.labels import Label
from mammosim.core.settings import read
from mammosim.core.tissues import TissueTable
from mammosim.digital.anatomy import make_anatomy
from mammosim.digital.constitution import Constitution
from mammosim.digital.loading import truth_mesh
from mammosim.digital.patient import VirtualPatient
from mammosim.io.meshes import write_mesh
from mammosim.io.tables import read_json, write_json, write_table

COUNTED_MM = 2.0


def main(files: dict[str, str], volunteer: str, tissues: dict, element_mm: dict) -> None:
    patient = VirtualPatient.read(read_json(files["woman"]))
    anatomy = make_anatomy(patient)
    mesh = truth_mesh(anatomy, breast_mm=element_mm["breast"], chest_mm=element_mm["chest"])
    write_mesh(mesh, files["mesh"])
    moduli = Constitution.of(patient, read(TissueTable, tissues, "digital.tissues")).moduli()
    moduli.insert(0, "volunteer", volunteer)
    write_table(moduli, files["moduli"])
    values = {}
    for side, mound in zip(("left", "right"), anatomy.mounds):
        points = anatomy.breast_points(mound, COUNTED_MM)
        labels = anatomy.labels_at(points)
        values[f"breast_{side}_cm3"] = len(points) * COUNTED_MM**3 / 1e3
        values[f"gland_fraction_{side}"] = float(np.mean(labels == Label.GLANDULAR))
    write_json(values, files["facts"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()) | dict(snakemake.output.items()),
        snakemake.wildcards.w,
        snakemake.params.tissues,
        snakemake.params.element_mm,
    )
