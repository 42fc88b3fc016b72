"""Why a job of a cluster failed, where its own log does not say: from the cluster's log and its status."""

import re
from collections.abc import Mapping

from mammosim.study.jobs.last_words import NO_ERROR, reason

AGAIN = "ask for more by --set-resources"
# What Slurm writes into the log of a job that it ends.
TIME_LIMIT = re.compile(r"DUE TO TIME LIMIT|TIMEOUT")
# The last of them are of Slurm without cgroups, and of a shell whose process the kernel has killed.
OUT_OF_MEMORY = re.compile(r"oom.kill|OUT_OF_MEMORY|exceeded (?:job |step )?memory limit", re.IGNORECASE)
CANCELLED = re.compile(r"CANCELLED AT|'CANCELLED'")
OF_SLURM = re.compile(r"^(?:slurmstepd|srun|sbatch|slurmd)(?:-\S+)?: (?:error|fatal): (.*)$", re.MULTILINE)


def cluster_reason(log: str, status: str, asked: Mapping[str, int | str]) -> str:
    """One line of reason.

    log: what the cluster kept of the job's output; status: what the executor says of its end;
    asked: `mem_mb` and `runtime` (min) that the job asked for.
    """
    said = f"{log}\n{status}"
    if OUT_OF_MEMORY.search(said):
        return f"out of memory: it needed more than its mem_mb = {asked.get('mem_mb', 'none')}; {AGAIN}"
    if TIME_LIMIT.search(said):
        return f"out of time: it needed more than its runtime = {asked.get('runtime', 'none')} min; {AGAIN}"
    if CANCELLED.search(said):
        return "cancelled on the cluster"
    # What failed before the job had a log of its own.
    if (error := reason(log)) != NO_ERROR:
        return error
    if errors := OF_SLURM.findall(said):
        return f"the cluster says: {errors[-1]}"
    first = next(iter(status.splitlines()), "")
    return first or "the cluster gives no reason"
