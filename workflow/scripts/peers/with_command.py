"""A task by a user's own command, whose words are the arguments; docs/contracts.md says what it is given."""

import json
import resource
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from _adapter import NotConverged, XrayTask, run


class Command:
    """The whole command is timed, unless it says how many processor-seconds its transport took."""

    def __init__(self, problem: XrayTask) -> None:
        self.problem, self.seed = problem, 0

    def solve(self) -> dict:
        self.seed += 1
        with TemporaryDirectory() as folder:
            facts, answer = Path(folder) / "facts.json", Path(folder) / "answer.json"
            facts.write_text(json.dumps(self.problem.facts | {"seed": self.seed}))
            ended = subprocess.run([*sys.argv[5:], self.problem.path, facts, answer], check=False)
            if ended.returncode or not answer.exists():
                raise NotConverged(f"the command ended with {ended.returncode} and wrote no answer")
            return json.loads(answer.read_text())

    def answer(self, solved: dict) -> dict:
        value, error = float(solved["value_ev"]), float(solved["standard_error_ev"])
        known = {"value": value, "standard_error": error, "reached": error / value}
        own_time = {"cpu_s": float(solved["cpu_s"])} if "cpu_s" in solved else {}
        return {"histories": float(solved["histories"]), **known, **own_time}


if __name__ == "__main__":
    run(XrayTask, Command, who=resource.RUSAGE_CHILDREN)
