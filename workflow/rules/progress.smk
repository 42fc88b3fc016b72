# An estimate of the time left, from what each rule cost when it was last measured; and no time lost in between.
import logging
import time

from snakemake.logging import logger
from snakemake_interface_logger_plugins.common import LogEvent


class TimeLeft(logging.Handler):
    """Names each job as it starts, and says 'about 12 min left' whenever one finishes.

    cost: seconds of one job of each rule, as measured before; their sum over the jobs still to do, divided by
    the cores, is scaled by how fast this machine turned out to be.
    """

    def __init__(self, cost, cores):
        super().__init__()
        self.cost, self.cores, self.rule_of = cost, cores, {}
        self.left = self.done = 0.0
        self.start = time.monotonic()

    def emit(self, record):
        event = getattr(record, "event", None)
        if event == LogEvent.RUN_INFO:
            counts = {rule: n for rule, n in record.stats.items() if rule != "total"}
            self.left = sum(n * self.seconds(rule) for rule, n in counts.items())
        elif event == LogEvent.JOB_INFO:
            self.rule_of[record.jobid] = record.rule_name
            logger.info(" ".join([record.rule_name, *map(str, dict(record.wildcards or {}).values())]))
        elif event == LogEvent.JOB_FINISHED:
            seconds = self.seconds(self.rule_of.get(record.job_id, ""))
            self.left, self.done = max(self.left - seconds, 0.0), self.done + seconds
        elif event == LogEvent.PROGRESS and record.done < record.total:
            elapsed = time.monotonic() - self.start
            # Two minutes of the table's own word keep the first jobs from swinging the estimate.
            pace = (elapsed + 120) / (self.done / self.cores + 120)
            logger.info(f"about {self.left / self.cores * pace / 60:.0f} min left, {elapsed / 60:.0f} min so far")

    def seconds(self, rule):
        return self.cost.get(rule, 2.0)


if workflow.is_main_process and not workflow.dryrun:
    costs = pd.read_table(home("config/costs.tsv"), comment="#").set_index("rule").seconds.to_dict()
    logger.addHandler(TimeLeft(costs, workflow.cores or 1))


onstart:
    # Under a limit of jobs per second, the scheduler examines every ready job once a second for each job that has
    # ended, and soon does nothing else (pull request 3744 of snakemake). Jobs of this machine need no such limit.
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None
