"""What a solve may spend before it ends without an answer."""

import time
from dataclasses import dataclass, field

import numpy as np

# Attempts since the last step may take so many times the iterations of all steps before, so that a refusal
# costs at most three times as much as an answer; and at least so many, as nothing is before a first step.
FAILED_PER_USEFUL = 2.0
LEAST_FAILED = 120


class BudgetSpent(Exception):
    """A solve took more than its budget; internal to the package. x (n_node, 3): the last shape."""

    def __init__(self, message: str, x: np.ndarray) -> None:
        super().__init__(message)
        self.x = x


@dataclass(frozen=True)
class Budget:
    """iterations of Newton, failed attempts included, and processor seconds of all threads."""

    iterations: int = 1000
    seconds: float = 3600.0


@dataclass
class Spending:
    """What a solve has spent so far: iterations in all, and those of the steps that succeeded."""

    budget: Budget = field(default_factory=Budget)
    iterations: int = 0
    useful: int = 0
    began: float = field(default_factory=time.process_time)

    def iterate(self, x: np.ndarray) -> None:
        """Count an iteration that begins at a shape x (n_node, 3). Raises BudgetSpent."""
        self.iterations += 1
        failed, allowed = self.iterations - self.useful, max(LEAST_FAILED, FAILED_PER_USEFUL * self.useful)
        if failed > allowed:
            raise BudgetSpent(f"{failed - 1} iterations since the last step came to no equilibrium", x)
        if self.iterations > self.budget.iterations:
            raise BudgetSpent(f"the budget of {self.budget.iterations} iterations is spent", x)
        if (seconds := time.process_time() - self.began) > self.budget.seconds:
            raise BudgetSpent(f"{seconds:.0f} s are spent, of a budget of {self.budget.seconds:.0f} s", x)

    def succeed(self) -> None:
        """What was spent so far led to a step."""
        self.useful = self.iterations
