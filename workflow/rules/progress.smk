# The time left, learned from the jobs that end; long chains of jobs first; and what failed, said at the end.
import logging
import signal
import threading
import time
from contextlib import suppress

import psutil

from snakemake.logging import logger
from snakemake_interface_logger_plugins.common import LogEvent

from mammosim.study.jobs.cluster_words import cluster_reason
from mammosim.study.jobs.last_words import LOCKED_BY, Failure, Run, interrupted, last_words, locked, missing_in_brief
from mammosim.study.jobs.time_left import TimeLeft, chains, seconds_before, stranded, time_words

# What Snakemake says behind the last words, which say it, too.
REPEATED = ("Complete log(s):", "Elapsed time:", "WorkflowError:\nAt least one job did not complete")

# What is left out when a person has ended a run.
ENDING_WORDS = ("Will exit after", "Shutting down,")
SILENT = (LogEvent.JOB_ERROR, LogEvent.ERROR, LogEvent.GROUP_ERROR)
# What only looks, which Snakemake lets go on beside a run.
LOOKING = ("--summary", "-S", "--detailed-summary", "-D", "--dag", "--rulegraph", "--filegraph", "--d3dag", "--lint")
# An input that is rejected ends the run at once: it is to be mended before anything long runs.
ENDING_RULES = ("check_input",)
ENDING_PRIORITY = 10**9  # no chain of jobs lasts so many seconds


class Progress(logging.Handler):
    """Names each job as it starts, says 'about 12 min left' as each one ends, and at last what failed.

    costs: seconds of one job of each rule, as measured before; cores: how many jobs run at a time.
    """

    def __init__(self, costs, cores):
        super().__init__()
        self.time_left, self.start = TimeLeft(costs, cores), time.time()
        self.ended = None
        self.said = {}  # by a cluster of a job that failed: id -> its message, and the logs
        self.interrupted = False

    def interrupt(self, number, frame):
        """What Ctrl-C does: jobs end at once, and what they say of it is left out; a second one ends this process."""
        if self.interrupted:
            signal.default_int_handler(number, frame)
        self.interrupted = True
        # Ctrl-C comes at any moment, also while this thread has the lock of the scheduler.
        threading.Thread(target=self.end_jobs, daemon=True).start()

    def end_jobs(self):
        """Let no job begin any more, and end those that run."""
        logger.addFilter(
            lambda record: getattr(record, "event", None) not in SILENT and not str(record.msg).startswith(ENDING_WORDS)
        )
        workflow.scheduler.exit_gracefully()
        for job in psutil.Process().children(recursive=True):
            with suppress(psutil.Error):
                job.terminate()

    def emit(self, record):
        # Snakemake would end the run on an error in here.
        try:
            self.tell(record)
        except Exception:
            self.handleError(record)

    def tell(self, record):
        event = getattr(record, "event", None)
        if event == LogEvent.JOB_INFO:
            self.time_left.begin(record.jobid, record.rule_name, time.time())
            logger.info(self.label(record.rule_name, record.wildcards))
        elif event == LogEvent.JOB_FINISHED:
            self.time_left.end(record.job_id, time.time())
            self.ended = record.job_id
        elif event == LogEvent.JOB_ERROR:
            self.time_left.running.pop(record.jobid, None)
            self.said[record.jobid] = record.rule_msg, record.log
            if record.rule_name in ENDING_RULES:
                workflow.scheduler.keepgoing = False
        elif event == LogEvent.PROGRESS and record.done < record.total:
            logger.info(self.words())
            # By what has been learned; and a checkpoint may have brought new rules.
            self.longest_chain_first()

    def label(self, rule, wildcards):
        """A job in one line: its rule and what it is about; a wildcard may be empty."""
        return " ".join(filter(None, [rule, *map(str, dict(wildcards or {}).values())]))

    def to_do(self):
        """Of the jobs that have not ended: id -> ids of the jobs that it needs, and id -> rule."""
        dag = workflow.dag
        jobs = {dag.jobid(job): job for job in dag.needrun_jobs()}
        needs = {i: [dag.jobid(other) for other in dag.job_dependencies(job)] for i, job in jobs.items()}
        return needs, {i: job.rule.name for i, job in jobs.items()}

    def words(self):
        """A bar, the time left, and the time so far."""
        needs, rules = self.to_do()
        failed = {workflow.dag.jobid(job) for job in workflow.scheduler.failed}
        # One whose outputs were not there when it had ended has said no more.
        for job in failed:
            self.time_left.running.pop(job, None)
        # Snakemake's graph still has the job whose end it reports.
        out = {self.ended} | failed | stranded(needs, failed)
        now = time.time()
        left = self.time_left.left({job: needs[job] for job in needs if job not in out}, rules, now)
        return time_words(now - self.start, left)

    def learn(self):
        """What jobs took in this folder before: those of a rule together as much as one job of this run."""
        for name, seconds in seconds_before(Path("results/benchmarks")).items():
            self.time_left.learn(name, seconds)

    def longest_chain_first(self):
        """Of the jobs that are ready, the one goes first that begins the longest chain of jobs.

        Else such a chain comes last: it takes one core, and the others are idle.
        """
        needs, rules = self.to_do()
        expected = self.time_left.expected(set(rules.values()))
        longest = {}
        for job, seconds in chains(needs, {job: expected[name] for job, name in rules.items()}).items():
            longest[rules[job]] = max(longest.get(rules[job], 0.0), seconds)
        for each in workflow.rules:
            # What ends the run when it fails goes before everything else.
            each.priority = ENDING_PRIORITY if each.name in ENDING_RULES else round(longest.get(each.name, 0.0))
        workflow.dag.update_priority()

    def cluster_says(self, job):
        """Why a job of a cluster has failed, where the cluster knows; nothing of a job of this machine."""
        message, logs = self.said.get(workflow.dag.jobid(job), (None, []))
        if workflow.local_exec or workflow.is_local(job.rule) or not message:
            return ""
        text = "".join(path.read_text(errors="replace") for path in map(Path, logs) if path.is_file())
        return cluster_reason(text, message, {name: job.resources.get(name) for name in ("mem_mb", "runtime")})

    def last_words(self, run_log):
        """Which jobs failed, why, and where their logs are; run_log: the files of what Snakemake has said."""
        said = Path(run_log[0]) if run_log else None
        if self.interrupted:
            return interrupted(left=len(self.to_do()[0]), results=Path("results").resolve(), run_log=said)
        failed = workflow.scheduler.failed
        names = [self.label(job.rule.name, job.wildcards_dict) for job in failed]
        logs = [Path(job.log[0]).resolve() if job.log else None for job in failed]
        return last_words(
            map(Failure, names, logs, [job.resources.get("mem_mb") for job in failed], map(self.cluster_says, failed)),
            not_run=len(self.to_do()[0]) - len(failed),
            stopped=not workflow.scheduler.keepgoing,
            results=Path("results").resolve(),
            run_log=said,
            since=self.start,
        )


if workflow.is_main_process and not workflow.dryrun and not OF_ANOTHER:
    PROGRESS = Progress({name: float(row["seconds"]) for name, row in COSTS.items()}, AT_A_TIME)
    logger.addHandler(PROGRESS)
    # Which executor it has, the workflow learns when all rules are read: it takes itself for no dry run until then.
    may_begin = workflow.output_settings.dryrun or {"--unlock", "--nolock", *LOOKING} & set(sys.argv)
    if not may_begin and any(Path(".snakemake/locks").glob("*")):
        raise WorkflowError(locked(Run.read(LOCKED_BY), Path().absolute()))


onstart:
    Run.here().write(LOCKED_BY)
    keep_campaign_jobs()
    # On a cluster Snakemake's own way cancels the jobs, which are no children of this process.
    if workflow.local_exec:
        signal.signal(signal.SIGINT, PROGRESS.interrupt)
        if (pool := getattr(workflow.scheduler._local_executor or workflow.scheduler._executor, "pool", None)) is not None:
            # Threads that start jobs leave Ctrl-C to this one: jobs inherit that, and end when they are told.
            pool._initializer = lambda: signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    PROGRESS.learn()
    PROGRESS.longest_chain_first()
    # Under a limit of jobs per second, the scheduler examines every ready job once a second for each job that has
    # ended, and soon does nothing else (pull request 3744 of snakemake). Jobs of this machine need no such limit.
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None


onerror:
    logger.error(PROGRESS.last_words(log))
    logger.addFilter(lambda record: not str(record.msg).startswith(REPEATED))


onsuccess:
    gaps = Path("results/study/missing.csv")
    made_now = gaps.exists() and gaps.stat().st_mtime >= PROGRESS.start
    if made_now and (lines := missing_in_brief([row["reason"] for row in read_plain(gaps)])):
        logger.warning(lines)
