"""Tissue labels of voxels and elements, the same numbers in every file."""

from enum import IntEnum


class Label(IntEnum):
    """What a voxel or an element consists of; THORAX is everything behind the muscle."""

    AIR = 0
    ADIPOSE = 1
    GLANDULAR = 2
    SKIN = 3
    MUSCLE = 4
    THORAX = 5
    MARKER = 6
    LESION = 7

    @property
    def tissue(self) -> str:
        """The tissue's name in configuration files, e.g. 'glandular'."""
        return self.name.lower()


# Voxels that the mechanics deforms; the rest is air, or moves rigidly with the rib cage.
DEFORMABLE = (Label.ADIPOSE, Label.GLANDULAR, Label.SKIN, Label.MUSCLE, Label.LESION)
# ASSUME: a piece of a twentieth of the largest one is a breast of its own; smaller ones are strays.
LEAST_PIECE = 0.05
