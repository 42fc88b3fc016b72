"""A full disk, or a job that is killed, leaves nothing that looks like a result."""

import multiprocessing
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mammosim.core.rigid import RigidTransform, rotation
from mammosim.core.volume import Grid, Image, LabelMap
from mammosim.io import atomic
from mammosim.io.atomic import replacing
from mammosim.io.images import write_image, write_labels
from mammosim.io.meshes import write_mesh, write_mesh_arrays
from mammosim.io.missing import write_missing
from mammosim.io.tables import write_json, write_table
from mammosim.io.transforms import write_transform
from mammosim.meshing.shapes import box

GRID = Grid((20, 24, 28), np.full(3, 2.0), np.zeros(3))
RNG = np.random.default_rng(3)
IMAGE = Image(GRID, RNG.normal(size=GRID.shape).astype(np.float32))
LABELS = LabelMap(GRID, RNG.integers(0, 6, GRID.shape).astype(np.uint8))
MOTION = RigidTransform(rotation(np.array([3.0, -2, 5])), np.array([4.0, -5, 1 / 3]))
MESH = box((3, 3, 3), np.array([10.0, 10, 10]))
TABLE = pd.DataFrame(RNG.random((200, 3)), columns=list("abc"))
WRITERS = {
    "a.nii.gz": lambda path: write_image(IMAGE, path),
    "labels.nii.gz": lambda path: write_labels(LABELS, path),
    "a.tfm": lambda path: write_transform(MOTION, path),
    "a.csv": lambda path: write_table(TABLE, path),
    "a.json": lambda path: write_json({"x": list(range(100))}, path),
    "a.vtu": lambda path: write_mesh(MESH, path),
    "a.npz": lambda path: write_mesh_arrays(MESH, path),
    "gone.csv": lambda path: write_missing(path, "no equilibrium " * 20),
}


@contextmanager
def room(n_bytes: int) -> Iterator[None]:
    """No file may grow beyond that, which answers as a full disk does."""
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (n_bytes, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, before)


@pytest.mark.parametrize("share", [0, 0.5, -1])
@pytest.mark.parametrize("name", WRITERS)
def test_without_room_every_writer_raises_and_the_earlier_file_stays(tmp_path, name, share):
    path = tmp_path / name
    WRITERS[name](path)
    earlier = path.read_bytes()
    size = len(earlier) - 1 if share < 0 else int(share * len(earlier))
    with pytest.raises(OSError, match=name), room(size):
        WRITERS[name](path)
    assert [file.name for file in tmp_path.iterdir()] == [name]
    assert path.read_bytes() == earlier


def test_what_cannot_be_flushed_has_no_name(tmp_path, monkeypatch):
    """As of a server of files that only says so at the end."""

    def full(number: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(atomic.os, "fsync", full)
    with pytest.raises(OSError, match=r"No space left on device; nothing was written: '.*a\.json'"):
        write_json({}, tmp_path / "a.json")
    assert list(tmp_path.iterdir()) == []


def _killed(path: Path) -> None:
    with replacing(path) as temporary:
        if path.suffix:
            temporary.write_text("half")
        else:
            temporary.mkdir()
            (temporary / "slice_001.dcm").write_text("half")
        os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.parametrize("name", ["a.vtu", "a.nii.gz", "series"])
def test_what_a_killed_job_left_is_removed_by_the_next_writer(tmp_path, name):
    path = tmp_path / name
    job = multiprocessing.get_context("fork").Process(target=_killed, args=(path,))
    job.start()
    job.join()
    assert len(list(tmp_path.iterdir())) == 1
    with replacing(tmp_path / "another.vtu") as temporary:
        temporary.write_text("whole")
    assert len(list(tmp_path.iterdir())) == 2, "not of this file"
    with replacing(path) as temporary:
        temporary.write_text("whole")
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted(["another.vtu", name])


def test_a_number_of_a_process_says_nothing_on_another_machine(tmp_path, monkeypatch):
    path = tmp_path / "a.vtu"
    job = multiprocessing.get_context("fork").Process(target=_killed, args=(path,))
    job.start()
    job.join()
    (half,) = tmp_path.iterdir()
    monkeypatch.setattr(atomic, "machine", lambda: "elsewhere")
    WRITERS["a.vtu"](path)
    assert half.exists(), "it may be written there still"


def test_what_another_job_is_writing_stays(tmp_path):
    path = tmp_path / "a.vtu"
    with replacing(path) as first:
        first.write_text("first")
        with replacing(path) as second:
            second.write_text("second")
        assert first.read_text() == "first"
    assert path.read_text() == "first", "the last to end"


def test_of_another_machine_only_what_nobody_touched_for_an_hour_is_removed(tmp_path, monkeypatch):
    path = tmp_path / "a.vtu"
    with replacing(path) as temporary:
        name = temporary.name
        temporary.touch()
    monkeypatch.setattr(atomic, "machine", lambda: "elsewhere")
    (tmp_path / name).write_text("half")
    WRITERS["a.vtu"](path)
    assert (tmp_path / name).exists()
    old = time.time() - atomic.IDLE_S - 1
    os.utime(tmp_path / name, (old, old))
    WRITERS["a.vtu"](path)
    assert not (tmp_path / name).exists()


def test_of_a_folder_that_two_write_at_once_the_first_one_stays(tmp_path):
    def written(text, meanwhile=lambda: None):
        with replacing(tmp_path / "shared", keep=True) as temporary:
            temporary.mkdir()
            (temporary / "a.txt").write_text(text)
            meanwhile()

    written("second", meanwhile=lambda: written("first"))
    assert (tmp_path / "shared/a.txt").read_text() == "first"
    assert list(tmp_path.iterdir()) == [tmp_path / "shared"]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the state of a process is read from /proc")
def test_a_process_that_has_ended_is_not_alive_though_nobody_has_asked_how():
    process = subprocess.Popen(["sleep", "60"])
    assert atomic.is_alive(process.pid)
    process.kill()
    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
    os.kill(process.pid, 0)  # its number is still there
    assert not atomic.is_alive(process.pid)
    process.wait()
    assert not atomic.is_alive(process.pid)


def test_the_process_of_another_user_is_alive(monkeypatch):
    def forbidden(process, number):
        raise PermissionError

    monkeypatch.setattr(os, "kill", forbidden)
    assert atomic.is_alive(os.getpid())
