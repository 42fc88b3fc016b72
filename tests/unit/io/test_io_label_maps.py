"""Label maps of other programs: formats, overlapping segments, and codes with what explains them."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
import SimpleITK as sitk

from mammosim.core.errors import ConfigurationError, ImageError
from mammosim.core.labels import Label
from mammosim.core.volume import Grid
from mammosim.io.colours import write_slicer_colours, write_snap_labels
from mammosim.io.label_codes import BREAST, IGNORE, explained, fits, meaning_of, presets
from mammosim.io.label_maps import CodedMap, read_label_map, tissue_map

DATA = Path(__file__).parents[3].parent / "shared/data"
SHAPE = (3, 4, 5)
GRID = Grid(SHAPE, np.array([1.0, 2.0, 3.0]), np.array([-7.0, 5.0, 11.0]))


def coded(*codes: int, **about) -> CodedMap:
    """A map whose first voxels have these codes, all others the first one."""
    values = np.full(SHAPE, codes[0], np.int32)
    values.ravel()[: len(codes)] = codes
    return CodedMap(GRID, values, "mine.nrrd", **about)


def written(path, values: np.ndarray, **metadata: str):
    """The file of these values (nz, ny, nx) or (nz, ny, nx, layer)."""
    volume = sitk.GetImageFromArray(values, isVector=values.ndim == 4)
    volume.SetSpacing(GRID.spacing.tolist())
    volume.SetOrigin(GRID.origin.tolist())
    for key, value in metadata.items():
        volume.SetMetaData(key, value)
    sitk.WriteImage(volume, str(path))
    return path


@pytest.mark.parametrize("ending", [".nii", ".nii.gz", ".nrrd", ".mha", ".mhd"])
@pytest.mark.parametrize("kind", [np.int16, np.float32, np.uint16])
def test_every_format_and_whole_type_gives_the_same_codes_in_the_same_place(tmp_path, ending, kind):
    values = np.zeros(SHAPE, kind)
    values[0, 1, 2] = 4
    if kind is not np.uint16:
        values[2, 3, 4] = -300
    found = read_label_map(written(tmp_path / f"l{ending}", values))
    assert np.array_equal(found.codes, values)
    assert found.grid.same_as(GRID)
    assert found.found == tuple(np.unique(values).astype(int))


def test_axes_are_turned_to_left_posterior_superior(tmp_path):
    volume = sitk.GetImageFromArray(np.arange(60, dtype=np.int16).reshape(SHAPE))
    sitk.WriteImage(sitk.DICOMOrient(volume, "RSA"), str(tmp_path / "l.mha"))
    assert np.array_equal(read_label_map(tmp_path / "l.mha").codes, np.arange(60).reshape(SHAPE)), (
        "the same voxels, whatever the order of the axes in the file"
    )


def test_an_archive_holds_one_map(tmp_path):
    written(tmp_path / "l.mha", np.full(SHAPE, -3, np.int16))
    with zipfile.ZipFile(tmp_path / "one.zip", "w") as archive:
        archive.write(tmp_path / "l.mha", "Label_map/l.mha")
        archive.writestr("Label_map/read me.txt", "x")
    found = read_label_map(tmp_path / "one.zip")
    assert (found.found, found.path) == ((-3,), str(tmp_path / "one.zip"))
    with zipfile.ZipFile(tmp_path / "two.zip", "w") as archive:
        archive.write(tmp_path / "l.mha", "a.mha")
        archive.write(tmp_path / "l.mha", "b.mha")
    with pytest.raises(ImageError, match=r"two\.zip holds 2 label maps"):
        read_label_map(tmp_path / "two.zip")
    (tmp_path / "no.zip").write_bytes(b"no archive")
    with pytest.raises(ImageError, match=r"no\.zip is no whole zip archive"):
        read_label_map(tmp_path / "no.zip")


def test_what_a_mac_packs_beside_a_map_is_no_map(tmp_path):
    written(tmp_path / "l.nii.gz", np.full(SHAPE, 2, np.int16))
    with zipfile.ZipFile(tmp_path / "mac.ZIP", "w") as archive:
        archive.write(tmp_path / "l.nii.gz", "l.nii.gz")
        archive.writestr("__MACOSX/._l.nii.gz", b"\0\5\x16\7")
    assert read_label_map(tmp_path / "mac.ZIP").found == (2,)


def test_an_archive_is_unpacked_into_its_own_folder_only(tmp_path):
    written(tmp_path / "l.nii", np.full(SHAPE, 2, np.int16))
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.write(tmp_path / "l.nii", "l.nii")
        for name in (f"{tmp_path}/root.txt", "../above.txt"):
            member = zipfile.ZipInfo("x")
            member.filename = name
            archive.writestr(member, "x")
    before = sorted(tmp_path.rglob("*"))
    assert read_label_map(tmp_path / "a.zip").found == (2,)
    assert sorted(tmp_path.rglob("*")) == before


def test_a_map_keeps_its_voxels_in_another_file_of_the_archive(tmp_path):
    written(tmp_path / "l.mhd", np.full(SHAPE, 2, np.int16))
    with zipfile.ZipFile(tmp_path / "two.zip", "w") as archive:
        for name in ("l.mhd", "l.raw"):
            archive.write(tmp_path / name, f"labels/{name}")
    assert read_label_map(tmp_path / "two.zip").found == (2,)


def test_a_fault_inside_an_archive_is_named_by_the_archive(tmp_path):
    """And not by where it was unpacked, which is gone."""
    whole = written(tmp_path / "l.nii", np.full(SHAPE, 2, np.int16)).read_bytes()
    with zipfile.ZipFile(tmp_path / "a.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("labels/l.nii", whole[:-20])
    with pytest.raises(ImageError, match=r"a\.zip: labels/l\.nii ends early") as caught:
        read_label_map(tmp_path / "a.zip")
    assert str(caught.value).startswith(str(tmp_path))
    packed = bytearray((tmp_path / "a.zip").read_bytes())
    at = packed.index(b"labels/l.nii") + len("labels/l.nii")
    packed[at : at + 8] = b"\xff" * 8
    (tmp_path / "wrong.zip").write_bytes(packed)
    with pytest.raises(ImageError, match=r"wrong\.zip: labels/l\.nii does not unpack: it is damaged"):
        read_label_map(tmp_path / "wrong.zip")


@pytest.mark.data
def test_a_published_map_comes_straight_out_of_its_archive():
    """Signed codes, axes right, superior, anterior; its first voxel in LPS, and a breast of many litres."""
    path = DATA / "pelicano_exam10_label_map_simple.zip"
    if not path.exists():
        pytest.skip(f"the label map {path.name} is not beside the checkout (shared/data)")
    found = read_label_map(path)
    assert found.found == (-3, -2, -1, 0, 1)
    assert np.allclose(found.grid.direction, np.eye(3))
    assert fits(found.found).startswith("fits preset pelicano_simple")
    breast = tissue_map(found, "pelicano_simple").values == BREAST
    assert breast.sum() * found.grid.voxel_volume == pytest.approx(4.655e6, rel=1e-3)


def test_codes_that_a_slope_has_rounded_are_whole_ones_and_a_code_between_two_is_none(tmp_path):
    """As of programs that store codes with a slope: 3 becomes 3.00006."""
    codes = np.arange(60, dtype=np.float32).reshape(SHAPE) % 4
    found = read_label_map(written(tmp_path / "scaled.nii", codes * np.float32(1.00002)))
    np.testing.assert_array_equal(found.codes, codes)
    with pytest.raises(ImageError, match="no whole numbers"):
        read_label_map(written(tmp_path / "between.nii", codes * np.float32(0.9882)))


def test_what_is_no_label_map_is_named(tmp_path):
    half = written(tmp_path / "half.nii", np.linspace(0, 0.5, 60, dtype=np.float32).reshape(SHAPE))
    with pytest.raises(ImageError, match=r"half\.nii has values from 0 to 0\.5 that are no whole numbers"):
        read_label_map(half)
    with pytest.raises(ImageError, match=r"nan\.nrrd has values that are no numbers"):
        read_label_map(written(tmp_path / "nan.nrrd", np.full(SHAPE, np.nan, np.float32)))
    with pytest.raises(ImageError, match=r"two\.nrrd has 2 values per voxel and no segments"):
        read_label_map(written(tmp_path / "two.nrrd", np.zeros((*SHAPE, 2), np.uint8)))
    (tmp_path / "text.nrrd").write_text("no image")
    with pytest.raises(ImageError, match=r"text\.nrrd is not a readable image; give \.nii"):
        read_label_map(tmp_path / "text.nrrd")
    with pytest.raises(ImageError, match=r"no label map .*absent\.nrrd"):
        read_label_map(tmp_path / "absent.nrrd")


def test_dicom_is_named_and_not_guessed(tmp_path):
    (tmp_path / "seg").write_bytes(bytes(128) + b"DICM" + bytes(20))
    with pytest.raises(
        ImageError, match=r"seg holds no label map; give a DICOM segmentation, or one of: \.nii"
    ):
        read_label_map(tmp_path / "seg")


SEGMENTS = {"Segment0_Name": "Breast", "Segment0_LabelValue": "1", "Segment1_Name": "Dense tissue"}


def test_segments_of_slicer_have_the_tissues_of_their_names(tmp_path):
    values = np.zeros(SHAPE, np.uint8)
    values[1], values[2] = 1, 5
    found = tissue_map(
        read_label_map(written(tmp_path / "l.seg.nrrd", values, **SEGMENTS, Segment1_LabelValue="5"))
    )
    assert found.values[:, 0, 0].tolist() == [Label.AIR, BREAST, Label.GLANDULAR]


def test_overlapping_segments_lie_over_a_whole_breast_whatever_their_order(tmp_path):
    layers = np.zeros((*SHAPE, 2), np.uint8)
    layers[1:, ..., 1] = 1  # the breast
    layers[2, ..., 0] = 1  # dense tissue in it
    about = {
        **{"Segment0_Name": "Dense", "Segment0_LabelValue": "1", "Segment0_Layer": "0"},
        **{"Segment1_Name": "Breast", "Segment1_LabelValue": "1", "Segment1_Layer": "1"},
    }
    found = tissue_map(read_label_map(written(tmp_path / "l.seg.nrrd", layers, **about)))
    assert found.values[:, 0, 0].tolist() == [Label.AIR, BREAST, Label.GLANDULAR]
    assert read_label_map(tmp_path / "l.seg.nrrd").overlapping == np.prod(SHAPE[1:]), "which is said"


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_a_lesion_lies_over_the_gland_that_it_is_in_whatever_their_order(order):
    gland, lesion = np.zeros(SHAPE, bool), np.zeros(SHAPE, bool)
    gland[1:], lesion[2] = True, True
    segments = [("Gland", gland), ("Lesion", lesion)]
    found = tissue_map(CodedMap.of_segments(GRID, [segments[n] for n in order], "mine.nrrd"))
    assert found.values[:, 0, 0].tolist() == [Label.AIR, Label.GLANDULAR, Label.LESION]


def test_layers_are_turned_to_left_posterior_superior(tmp_path):
    layers = np.zeros((*SHAPE, 2), np.uint8)
    layers[0, 0, 0, 0] = layers[2, 3, 4, 1] = 1
    about = {
        **{"Segment0_Name": "Dense", "Segment0_LabelValue": "1", "Segment0_Layer": "0"},
        **{"Segment1_Name": "Fat", "Segment1_LabelValue": "1", "Segment1_Layer": "1"},
    }
    volume = sitk.ReadImage(str(written(tmp_path / "l.seg.nrrd", layers, **about)))
    volume.SetDirection(np.diag([-1.0, -1.0, 1.0]).ravel().tolist())  # right, anterior, superior
    sitk.WriteImage(volume, str(tmp_path / "ras.seg.nrrd"))
    codes = read_label_map(tmp_path / "ras.seg.nrrd").codes
    assert (codes[0, -1, -1], codes[2, 0, 0], np.count_nonzero(codes)) == (1, 2, 2)


def test_segments_of_slicer_before_4_11_have_layers_of_their_own(tmp_path):
    layers = np.zeros((*SHAPE, 2), np.uint8)
    layers[1, ..., 0] = layers[2, ..., 1] = 1
    about = {"Segment0_ID": "a", "Segment0_Name": "Fat", "Segment1_ID": "b", "Segment1_Name": "Skin"}
    found = tissue_map(read_label_map(written(tmp_path / "l.seg.nrrd", layers, **about)))
    assert found.values[:, 0, 0].tolist() == [Label.AIR, Label.ADIPOSE, Label.SKIN]


def test_segments_need_not_be_numbered_from_0(tmp_path):
    values = np.full(SHAPE, 4, np.uint8)
    about = {"Segment3_Name": "Fat", "Segment3_LabelValue": "4"}
    found = tissue_map(read_label_map(written(tmp_path / "l.seg.nrrd", values, **about)))
    assert np.all(found.values == Label.ADIPOSE)


@pytest.mark.parametrize(
    ("about", "words"),
    [
        ({"Segment1_LabelValue": "two"}, "Segment1 has no whole number as layer and code"),
        ({"Segment1_Layer": "0.5"}, "Segment1 has no whole number as layer and code"),
        ({"Segment1_Layer": "2"}, "a segment lies in layer 2, and layers are 0 to 1"),
        ({"Segment1_Layer": "0"}, r"two segments have layer and code \(0, 1\)"),
    ],
)
def test_no_segment_is_lost_without_a_word(tmp_path, about, words):
    names = {f"Segment{n}_{key}": value for n in range(2)
             for key, value in {"Name": "Fat", "LabelValue": "1", "Layer": str(n)}.items()}  # fmt: skip
    layers = np.ones((*SHAPE, 2), np.uint8)
    with pytest.raises(ImageError, match=rf"l\.seg\.nrrd: {words}"):
        read_label_map(written(tmp_path / "l.seg.nrrd", layers, **names | about))


@pytest.mark.parametrize("value", [2**31, -(2**31) - 1])
def test_codes_beyond_32_bits_are_no_image(tmp_path, value):
    with pytest.raises(ImageError, match=r"l\.nrrd has codes from .*; give codes of at most 32 bits"):
        read_label_map(written(tmp_path / "l.nrrd", np.full(SHAPE, value, np.int64)))


def test_segments_in_an_archive_keep_their_names(tmp_path):
    values = np.full(SHAPE, 7, np.uint8)
    written(tmp_path / "l.seg.nrrd", values, Segment0_Name="Fat", Segment0_LabelValue="7")
    with zipfile.ZipFile(tmp_path / "one.zip", "w") as archive:
        archive.write(tmp_path / "l.seg.nrrd", "l.seg.nrrd")
    (tmp_path / "one.zip").rename(tmp_path / "ONE.ZIP")
    assert np.all(tissue_map(read_label_map(tmp_path / "ONE.ZIP")).values == Label.ADIPOSE)


def test_names_of_a_file_that_no_voxel_has_are_not_asked_for():
    assert tissue_map(coded(0, 1, names={1: "Fat", 2: "Label 2"})).values.ravel()[1] == Label.ADIPOSE


def test_a_name_without_a_meaning_is_not_shown_since_it_may_be_a_patients():
    with pytest.raises(
        ImageError, match=r"^mine\.nrrd: the name of code 2 in mine\.nrrd is of no tissue"
    ) as error:
        tissue_map(coded(0, 1, 2, names={1: "Fat", 2: "Jane Roe"}))
    assert "Roe" not in str(error.value)


@pytest.mark.parametrize(
    ("name", "tissue"),
    [
        ("Left_Fibroglandular tissue", "glandular"),
        ("PECTORAL MUSCLE (R)", "muscle"),
        ("Clear Label", "air"),
        ("breast-left", "breast"),
        ("implant", ""),
    ],
)
def test_names_mean_the_same_with_side_case_and_signs(name, tissue):
    assert meaning_of(name) == tissue


PELICANO = (-4, -3, -2, -1, 0, 1)


def test_presets_have_the_published_codes():
    assert tissue_map(coded(*PELICANO), "pelicano_simple").values.ravel()[:6].tolist() == [
        *(Label.LESION, Label.LESION, Label.SKIN, Label.MUSCLE, Label.AIR, BREAST)
    ]
    victre = (0, 1, 2, 29, 33, 40, 88, 95, 125, 150, 225)
    assert set(victre) < set(presets()["victre"])
    assert tissue_map(coded(*victre), "victre").values.ravel()[1:6].tolist() == [
        *(Label.ADIPOSE, Label.SKIN, Label.GLANDULAR, Label.SKIN, Label.MUSCLE)
    ]
    assert presets()["mammosim"] == {int(label): label.tissue for label in Label}


def test_codes_without_a_meaning_are_listed_with_the_presets_they_fit():
    words = (
        r"mammosim has no tissue for codes -4, -3, -2, -1 of .*, 1; .*fits preset pelicano_simple or pelic"
    )
    with pytest.raises(ImageError, match=words):
        tissue_map(coded(*PELICANO))
    with pytest.raises(
        ImageError, match=r"no tissue for code 12 of 1, 12; .*\(presets are: mammosim, pelicano"
    ):
        tissue_map(coded(1, 12))


def test_the_vessels_and_dense_tissue_of_duke_are_no_breast():
    with pytest.raises(ImageError, match="duke has no breast; give it in one file with it, as segments"):
        tissue_map(coded(0, 1, 2), "duke")


def test_a_table_explains_codes(tmp_path):
    table = tmp_path / "codes.tsv"
    table.write_text("code\ttissue\n-7\tAdipose # fat\n300\tignore\n")
    assert tissue_map(coded(-7, 300), str(table)).values.ravel()[:2].tolist() == [Label.ADIPOSE, IGNORE]
    for text, words in {
        "code\tlabel\n1\tfat\n": "has the columns code, label; it needs code and tissue",
        "code\ttissue\n1\tfat\n": "row 1, column tissue: it names no tissue; did you mean adipose",
        "code\ttissue\n0\tair\n1\tx\n": "row 2, column tissue: it names no tissue; choose among: air,",
        "code\ttissue\none\tadipose\n": "row 1, column code: a code is no whole number",
        "code\ttissue\n1.5\tadipose\n": "row 1, column code: a code is no whole number",
        "code\ttissue\n\tadipose\n": "row 1, column code: a code is no whole number",
        "code\ttissue\n1\t\n": "row 1, column tissue: it names no tissue",
        "code\ttissue\n1\tadipose\n1\tskin\n": "row 2, column code: a code stands twice",
        "code\ttissue\n1\tadipose\t9\n": "row 1 has 3 cells and the header 2",
        "": r"codes\.tsv is empty; its first line should be: code,tissue",
        "code\ttissue\n": "has a header and no rows",
        'code\ttissue\n1\t"skin\n': "close what a quotation mark opens",
    }.items():
        table.write_text(text)
        with pytest.raises(ConfigurationError, match=words):
            tissue_map(coded(1), str(table))
    with pytest.raises(
        ConfigurationError, match=r"codes 'pelican' is no file and no preset; presets are: mammosim"
    ):
        tissue_map(coded(1), "pelican")


def test_a_label_description_file_of_itk_snap_explains_codes(tmp_path):
    file = tmp_path / "labels.txt"
    file.write_text(
        "# ITK-SnAP Label Description File\n"
        '    0     0    0    0        0  0  0    "Clear Label"\n'
        '    1   255    0    0        1  1  1    "Fat"\n'
        '    9     0  255    0      0.5  1  1    "Pectoral muscle"\n'
    )
    found = tissue_map(coded(0, 1, 9), str(file)).values.ravel()[:3]
    assert found.tolist() == [Label.AIR, Label.ADIPOSE, Label.MUSCLE]
    file.write_text("1 fat\n")
    with pytest.raises(ConfigurationError, match=r"labels\.txt is no label description file of ITK-SNAP"):
        tissue_map(coded(0, 1), str(file))


def test_a_wrong_line_of_a_label_description_is_named(tmp_path):
    file = tmp_path / "labels.label"
    lines = ['0 0 0 0 0 0 0 "Clear Label"', '1 255 0 0 1e-05 1 1 "Fat"', '2 0 255 0 1 1 1 "Skin']
    file.write_text("\n".join(["", "  # by hand", *lines]))
    with pytest.raises(ConfigurationError, match=r"labels\.label: line 5 is no label as the other lines are"):
        tissue_map(coded(0, 1), str(file))
    file.write_text("\n".join([*lines[:2], '1 0 255 0 1 1 1 "Skin"']))
    with pytest.raises(ConfigurationError, match=r"labels\.label: code 1 has two names; give it one"):
        tissue_map(coded(0, 1), str(file))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        (
            "l.ctbl",
            "# Color table file l.ctbl\n0 Background 0 0 0 0\n7 Fat 255 0 0 255\n9 fat_tissue 0 9 0 255\n",
        ),
        ("l.txt", "7 left_fat 255 0 0 255\n9 adipose 0 9 0 255\n"),
        (
            "l.csv",
            "LabelValue,Name,Color_R,Color_G,Color_B,Color_A\n7,Fat,255,0,0,255\n9,Left fat,0,9,0,255\n",
        ),
    ],
)
def test_a_colour_table_of_slicer_explains_codes(tmp_path, name, text):
    """As Slicer writes it beside an exported label map: blanks in a name are _ in all but the .csv."""
    (tmp_path / name).write_text(text)
    found = tissue_map(coded(0, 7, 9), str(tmp_path / name)).values.ravel()[:3]
    assert found.tolist() == [Label.AIR, Label.ADIPOSE, Label.ADIPOSE]


def test_the_colour_tables_that_are_written_explain_what_is_written(tmp_path):
    colours = dict.fromkeys(Label, "#102030")
    write_slicer_colours(colours, tmp_path / "t.ctbl")
    write_snap_labels(colours, tmp_path / "t.txt")
    for name in ("t.ctbl", "t.txt"):
        assert explained(str(tmp_path / name)) == presets()["mammosim"]


def test_a_name_in_a_colour_table_is_not_shown(tmp_path):
    (tmp_path / "l.csv").write_text("LabelValue,Name\n1,Jane Roe\n")
    with pytest.raises(ImageError, match=r"the name of code 1 in .*l\.csv is of no tissue") as error:
        tissue_map(coded(1), str(tmp_path / "l.csv"))
    assert "Roe" not in str(error.value)


@pytest.mark.parametrize(
    ("labels", "words"),
    [
        ({"fat": 1, "skin": 1}, "code 1 has two names"),
        ({"fat": 1.7}, "has no `labels` with a whole number each"),
        ({"fat": True}, "has no `labels` with a whole number each"),
        ({}, "has no `labels` with a whole number each"),
    ],
)
def test_a_dataset_gives_each_code_one_name(tmp_path, labels, words):
    (tmp_path / "dataset.json").write_text(json.dumps({"labels": labels}))
    with pytest.raises(ConfigurationError, match=rf"dataset\.json:? {words}"):
        tissue_map(coded(1), str(tmp_path / "dataset.json"))


@pytest.mark.parametrize(
    "labels",
    [
        {"background": 0, "fat": 1, "FGT": 2, "ignore": 3},
        {"0": "background", "1": "fat", "2": "FGT", "3": "ignore"},
    ],
)
def test_a_dataset_of_nnunet_explains_codes(tmp_path, labels):
    file = tmp_path / "dataset.json"
    file.write_text(json.dumps({"labels": labels}))
    found = tissue_map(coded(0, 1, 2, 3), str(file)).values.ravel()[:4]
    assert found.tolist() == [Label.AIR, Label.ADIPOSE, Label.GLANDULAR, IGNORE]
    file.write_text(json.dumps({"labels": {"breast": [1, 2]}}))
    with pytest.raises(ConfigurationError, match=r"dataset\.json has no `labels` with a whole number each"):
        tissue_map(coded(0, 1), str(file))


@pytest.mark.parametrize("name", ["codes.csv", "codes.tsv", "Codes.CSV"])
def test_a_table_may_be_separated_by_commas_or_tabs(tmp_path, name):
    table = tmp_path / name
    table.write_text("code,tissue\n4,glandular\n".replace(",", "\t" if name.endswith("tsv") else ","))
    assert np.all(tissue_map(coded(4), str(table)).values == Label.GLANDULAR)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_what_explains_codes_is_read_as_editors_save_it(tmp_path, encoding, separator):
    """As every other table that a person gives: with any usual separator and encoding."""
    text = "Code ; Tissue\n# gedrüst\n-2;adipose\n4 ; glandular\n".replace(";", separator)
    (tmp_path / "codes.csv").write_bytes(text.encode(encoding))
    found = tissue_map(coded(-2, 4), str(tmp_path / "codes.csv")).values.ravel()[:2]
    assert found.tolist() == [Label.ADIPOSE, Label.GLANDULAR]
    (tmp_path / "labels.txt").write_bytes('4 0 255 0 1 1 1 "Drüse"\n5 0 9 0 1 1 1 "fat"\n'.encode(encoding))
    assert np.all(tissue_map(coded(5), str(tmp_path / "labels.txt")).values == Label.ADIPOSE)
    (tmp_path / "dataset.json").write_bytes('{"labels": {"fat": 3, "Drüse": 9}}'.encode(encoding))
    assert np.all(tissue_map(coded(3), str(tmp_path / "dataset.json")).values == Label.ADIPOSE)


def test_a_cut_dataset_is_named_with_line_and_column(tmp_path):
    (tmp_path / "dataset.json").write_text('{\n "labels": {"fat": 1,')
    with pytest.raises(
        ConfigurationError, match=r"dataset\.json: line 2, column \d+: no JSON .*; was it cut"
    ):
        tissue_map(coded(1), str(tmp_path / "dataset.json"))
