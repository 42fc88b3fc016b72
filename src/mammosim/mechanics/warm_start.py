"""Where a compression may begin: on the way that another one of the same body went."""

from dataclasses import dataclass, replace

import numpy as np

from mammosim.mechanics.press import Press
from mammosim.mechanics.stage import Stage


@dataclass(frozen=True)
class WarmStart:
    """A stage between rigid plates, as it may be kept in a file.

    thickness: of the plates, mm; penalty: of their contacts, kPa/mm; x (n_node, 3) mm.
    """

    thickness: float
    penalty: float
    x: np.ndarray

    def stage(self, press: Press) -> Stage:
        """The same stage of a press, its paddle at rest."""
        paddle, support = (
            replace(contact, obstacle=box, penalty=self.penalty)
            for contact, box in zip(press.apart, press.plates.at(self.thickness))
        )
        return Stage(self.thickness, press.plates.at_rest, self.x, (paddle, support))
