"""Random numbers inside compiled loops: xoroshiro128+ (Blackman & Vigna 2018), one stream per block."""

import math

import numpy as np

from mammosim.io.compiled import njit

# How all that a photon passes through is compiled: without counting references to arrays (none is made), in
# one piece, and with fused multiply-adds, it takes half the time: see docs/decisions/xray_transport.md.
compiled = njit(
    cache=True, _nrt=False, forceinline=True, error_model="numpy", fastmath={"contract", "nsz", "arcp"}
)

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
MIX_1, MIX_2 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
ONE_BIT_53 = 2.0**-53


@compiled
def scrambled(word: np.uint64) -> np.uint64:
    """Output function of splitmix64."""
    word = (word ^ (word >> np.uint64(30))) * MIX_1
    word = (word ^ (word >> np.uint64(27))) * MIX_2
    return word ^ (word >> np.uint64(31))


@njit(cache=True)
def random_stream(seed: int, block: int) -> np.ndarray:
    """State (2,) uint64 of a block's own stream, as splitmix64 scrambles seed and block."""
    key = scrambled(np.uint64(seed) + GOLDEN) + np.uint64(2) * np.uint64(block) * GOLDEN
    state = np.empty(2, np.uint64)
    state[0] = scrambled(key + GOLDEN)
    state[1] = scrambled(key + GOLDEN + GOLDEN)
    return state


@compiled
def uniform(state: np.ndarray) -> float:
    """The next number in [0, 1)."""
    s0, s1 = state[0], state[1]
    word = s0 + s1
    s1 ^= s0
    state[0] = ((s0 << np.uint64(24)) | (s0 >> np.uint64(40))) ^ s1 ^ (s1 << np.uint64(16))
    state[1] = (s1 << np.uint64(37)) | (s1 >> np.uint64(27))
    return np.float64(word >> np.uint64(11)) * ONE_BIT_53


@compiled
def exponential(state: np.ndarray) -> float:
    """The next number of density exp(-x)."""
    return -math.log(1 - uniform(state))
