"""A cache of compiled kernels that is damaged, or has no place, is left aside."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest
from numba.core.caching import IndexDataCacheFile

from mammosim.io import compiled
from mammosim.io.compiled import njit

KERNEL = """
from mammosim.io.compiled import njit


@njit(cache=True)
def twice(x):
    return 2 * x


print(twice(21))
"""


@pytest.fixture
def run(tmp_path):
    """Run the kernel of a module in a process of its own, with these variables."""
    module = tmp_path / "code" / "kernel.py"
    module.parent.mkdir()
    module.write_text(KERNEL)

    def run(**variables):
        environment = {
            "PYTHONPATH": str(Path(__file__).parents[3] / "src"),
            "PATH": "/usr/bin:/bin",
            **variables,
        }
        ran = subprocess.run(
            [sys.executable, str(module)], capture_output=True, text=True, env=environment, check=False
        )
        return ran.returncode, ran.stdout.strip(), ran.stderr

    return run


def test_an_index_without_a_byte_and_a_damaged_kernel_are_compiled_again(run, tmp_path):
    cache = tmp_path / "cache"
    assert run(NUMBA_CACHE_DIR=str(cache))[:2] == (0, "42")
    for pattern in ("*.nbi", "*.nbc"):
        for file in cache.rglob(pattern):
            file.write_bytes(b"" if pattern == "*.nbi" else b"no pickle")
        assert run(NUMBA_CACHE_DIR=str(cache))[:2] == (0, "42")
    assert all(file.stat().st_size for file in cache.rglob("*.nbi")), "the cache is whole again"


SLOW = """
import os
import numba.core.compiler
from mammosim.io.compiled import njit

original = numba.core.compiler.compile_extra


def compile_extra(*args, **kwargs):
    with open(os.environ["COMPILED"], "a") as file:
        file.write("once\\n")
    time.sleep(1.0)
    return original(*args, **kwargs)


import time
import numba.core.dispatcher
numba.core.dispatcher.compiler.compile_extra = compile_extra


@njit(cache=True)
def twice(x):
    return 2 * x


print(twice(21))
"""


def test_of_two_processes_that_lack_a_kernel_one_compiles_it(tmp_path):
    module, told = tmp_path / "kernel.py", tmp_path / "compiled.txt"
    module.write_text(SLOW)
    names = {
        "PYTHONPATH": str(Path(__file__).parents[3] / "src"),
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
        "COMPILED": str(told),
    }
    runs = [subprocess.Popen([sys.executable, module], env=os.environ | names) for _ in range(2)]
    assert [run.wait(timeout=100) for run in runs] == [0, 0]
    assert told.read_text() == "once\n"


def test_a_kernel_that_another_process_holds_for_long_is_compiled_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(compiled, "WAIT_S", 0.1)
    held = compiled._locked(str(tmp_path / "kernel.nbi.lock"))
    assert held is not None
    assert compiled._locked(str(tmp_path / "kernel.nbi.lock")) is None
    os.close(held)
    again = compiled._locked(str(tmp_path / "kernel.nbi.lock"))
    assert again is not None
    os.close(again)


def test_without_any_place_for_a_cache_kernels_still_run(run, tmp_path):
    (tmp_path / "file").write_text("where a folder should be")
    (tmp_path / "code" / "__pycache__").write_text("no folder either")
    nowhere = str(tmp_path / "file" / "cache")
    code, printed, error = run(NUMBA_CACHE_DIR=nowhere, XDG_CACHE_HOME=nowhere, HOME=nowhere)
    assert (code, printed) == (0, "42"), error


def test_a_cache_that_cannot_be_written_is_done_without(tmp_path, monkeypatch):
    def full(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr(IndexDataCacheFile, "_save_index", full)
    assert IndexDataCacheFile(str(tmp_path), "kernel", "today").save("twice", "code") is None


def test_a_kernel_that_cannot_be_compiled_for_another_reason_says_so(monkeypatch):
    def fails(*, cache):
        if cache:
            raise RuntimeError("no such target")
        return lambda kernel: kernel

    monkeypatch.setattr(numba, "njit", fails)
    with pytest.raises(RuntimeError, match="no such target"):
        njit(cache=True)(lambda x: x)
