"""Environments in which a child process computes with the vector instructions of another processor.

numpy, OpenBLAS, MKL, numba and glibc choose their kernels when a process starts. Without AVX2 and FMA, sums
run in another order and products are rounded before they are added, so that the last bits differ as they do
between two machines. Import this in a process that is not itself held to fewer instructions.
"""

import numpy as np

# What numpy was built to choose from; it refuses names that it does not know.
_DISPATCHED: tuple[str, ...] = tuple(np._core._multiarray_umath.__cpu_dispatch__)
_PRESENT: dict[str, bool] = np._core._multiarray_umath.__cpu_features__
_BEYOND_AVX2 = tuple(name for name in _DISPATCHED if "AVX512" in name or name == "X86_V4")
_GLIBC_BEYOND_AVX2 = ("AVX512F", "AVX512VL", "AVX512BW", "AVX512DQ", "AVX512CD")
_GLIBC_BEYOND_SSE = ("AVX", "AVX2", "FMA", "FMA4", "BMI2", *_GLIBC_BEYOND_AVX2)


def _without(names: tuple[str, ...]) -> str:
    return " ".join(name for name in names if _PRESENT[name])


def _glibc(names: tuple[str, ...]) -> str:
    # Releases of glibc before 2.33 call the same features ..._Usable, and skip names that they do not know.
    return "glibc.cpu.hwcaps=" + ",".join(f"-{name},-{name}_Usable" for name in names)


INSTRUCTION_SETS: dict[str, dict[str, str]] = {
    "plain": {
        "NPY_DISABLE_CPU_FEATURES": _without(_DISPATCHED),
        "OPENBLAS_CORETYPE": "Nehalem",
        "MKL_ENABLE_INSTRUCTIONS": "SSE4_2",
        "NUMBA_CPU_NAME": "generic",
        "NUMBA_CPU_FEATURES": "",
        "GLIBC_TUNABLES": _glibc(_GLIBC_BEYOND_SSE),
    },
    "avx2": {
        "NPY_DISABLE_CPU_FEATURES": _without(_BEYOND_AVX2),
        "OPENBLAS_CORETYPE": "Haswell",
        "MKL_ENABLE_INSTRUCTIONS": "AVX2",
        "NUMBA_CPU_NAME": "haswell",
        "NUMBA_CPU_FEATURES": "",
        "GLIBC_TUNABLES": _glibc(_GLIBC_BEYOND_AVX2),
    },
    # Named, since the environment of the tests may hold OpenBLAS to less.
    "native": {"OPENBLAS_CORETYPE": "SkylakeX"} if _PRESENT.get("AVX512_SKX") else {},
}
"""Name -> environment variables to add to those of a child process: SSE only, AVX2 at most, all there is."""
