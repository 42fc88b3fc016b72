# What jobs ask of a cluster. A rule's own mem_mb is what its script takes on one machine; a job of a cluster takes
# what the rule was measured to take, with room, the two starts of Snakemake in it, and twice as much with each attempt.
from dataclasses import replace

from snakemake.resources import Resources

from mammosim.study.jobs.requests import requests


def stated_mb(each):
    """The mem_mb of a rule where it is a plain number; None where it is computed, or nothing is run."""
    found = each.resources.get("mem_mb")
    return found.raw if found is not None and isinstance(found.raw, int) else None


def of_this_study(rules):
    """The rules of this study by their own names, whatever name another workflow gives them."""
    own = [each for each in rules if str(each.snakefile).startswith(str(HOME)) and stated_mb(each) is not None]
    measured = {workflow.modifier.modify_rulename(name): name for name in COSTS}
    return {measured.get(each.name, each.name): each for each in own}


# Rules whose jobs are as long as their wildcards say, and seconds of one.
BY_WILDCARDS = {"campaigns_batch": campaign_batch_seconds}


def asked(request, seconds):
    """Resources as functions of the attempt. seconds (wildcards): how long a job is, None where it was measured."""
    length = (lambda wildcards: request.seconds) if seconds is None else seconds
    return {
        "mem_mb": lambda wildcards, attempt: request.mem_mb(attempt),
        "runtime": lambda wildcards, attempt: replace(request, seconds=length(wildcards)).runtime(attempt),
    }


def ask(each, request, seconds):
    """Let a rule ask for so much, but for what `--set-resources` or its profile says of it."""
    chosen = workflow.resource_settings.overwrite_resources.get(each.name, {})
    values = {name: value for name, value in asked(request, seconds).items() if name not in chosen}
    each.resources.update(Resources.from_mapping(values))


def run_here(each, request):
    """Whether jobs run beside Snakemake: short ones whose length no setting changes, as it does that of a stage."""
    return request.short and not str(each.script).endswith("stage.py")


def ask_a_cluster():
    """Let every rule ask for what it takes; those of short jobs for nothing."""
    asking = of_this_study(workflow.rules)
    stated = {name: stated_mb(each) for name, each in asking.items()}
    for name, request in requests(stated, COSTS).items():
        ask(asking[name], request, BY_WILDCARDS.get(name))
        if run_here(asking[name], request):
            workflow.localrules(asking[name].name)


if ON_CLUSTER:
    ask_a_cluster()
