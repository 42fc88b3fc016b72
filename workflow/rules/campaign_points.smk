# Functions of the campaigns: their files, the breasts and settings that they begin with, and their points.
import json
import shutil

from mammosim.study.campaigns import grouping as campaign_grouping
from mammosim.study.campaigns import points as campaign_points
from mammosim.study.campaigns import prediction as campaign_prediction
from mammosim.study.campaigns.campaign import ASKED as ASKED_QUANTITIES
from mammosim.study.campaigns.campaign import Campaign
from mammosim.study.campaigns.points import Case
from mammosim.study.campaigns.settings import Known

CAMPAIGNS = stems("config/campaigns")
# What the run that is at work has planned, for its jobs: to plan all of thousands of points takes each of them seconds.
KEPT_JOBS = Path(".snakemake/mammosim_campaigns")


@cache
def campaign_given(name):
    """The values of config/campaigns/{name}.yaml, with whose breasts it is about; rejected if they cannot be meant."""
    file = f"config/campaigns/{name}.yaml"
    given = checked(read_yaml(file), "campaign", [file], known=KNOWN)
    given = {"subjects": {WOMEN[0]: COMPRESSION["sides"][:1]}} | given
    checked_overrides(given.get("settings", {}), file)
    return given


@cache
def campaign_of(name):
    """The campaign of config/campaigns/{name}.yaml, each of whose questions the data of its volunteers allow."""
    file = f"config/campaigns/{name}.yaml"
    try:
        campaign = Campaign.of(name, campaign_given(name), file=file)
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None
    for volunteer, _ in campaign.subjects:
        if volunteer not in {v for v, _ in VOLUNTEERS}:
            raise WorkflowError(f"ConfigurationError: {file}: {volunteer!r} is not studied; add her to `volunteers`")
        why = next((lacking(volunteer)[each] for each in campaign.products if lacking(volunteer)[each]), "")
        if why:
            raise WorkflowError(f"ConfigurationError: {file}: {', '.join(campaign.asked)} cannot be had: {why}")
    return campaign


@cache
def campaign_names():
    """What the settings of a campaign are checked by, and what they may name."""
    schemas = {kind: schema_of(kind) for kind in ("config", "tissues", "compression")}
    tissues = {name: tissue_table(name) for name in stems("config/tissues")}
    settings = {group: config[group] for group in OF_CHAIN} | {"tissues": TISSUES}
    return Known(schemas, WAYS, tissues, settings)


def campaign_case(campaign, volunteer, side):
    """One breast of a campaign: its chain before anything varies, and what the study has of it."""
    breast = {"v": volunteer, "side": side}
    first = {each.key: each.levels[0].value for each in campaign.axes if each.levels}
    load = {name: first.get(f"load.{name}", given) for name, given in campaign.load.items()}
    load |= {"position": first["load.position"]} if "load.position" in first else {}
    settings = settings_of(breast | load)
    if campaign.tissues:
        settings = settings | {"tissues": tissue_table(campaign.tissues)}
        same = {"load": {"tissues": settings["tissues"]}} if load["moduli"] == "gravity" else {}
        settings = overridden(settings, same)
    labelled = ("registration", "segmentation")  # what the images were labelled with is the study's
    finer = {key: value for key, value in preset(campaign.accuracy).items() if key in settings and key not in labelled}
    settings = overridden(overridden(settings, finer), {k: v for k, v in campaign.settings.items() if k in settings})
    effects = [*settings["mechanics"]["effects"], *settings["xray"]["effects"]]
    return Case(
        volunteer,
        side,
        chain_of({"subject": subject_of(breast), "settings": settings, "effects": effects}, {}),
        study=lambda load: study_chain(breast | load),
        paths=lambda product, load: STAGES[product].files.paths(places(breast | {k: v for k, v in load.items() if v})),
    )


@cache
def campaign_plan(name):
    """Every point of a campaign, its batches by name, and what points share."""
    campaign = campaign_of(name)
    cases = [campaign_case(campaign, volunteer, side) for volunteer, side in campaign.subjects]
    code = library("campaign_batch.py", *campaign.read)
    try:
        found = campaign_points.plan(campaign, cases, campaign_names(), code)
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None
    batches, shared = campaign_grouping.batches(found), campaign_grouping.stored(found)
    return {"points": found, "batches": batches, "shared": shared, "cases": cases}


def campaign_points_of(name, batch):
    """The points of one batch. Raises WorkflowError where the campaign has no such batch."""
    batches = campaign_plan(name)["batches"]
    if batch not in batches:
        raise WorkflowError(f"campaign {name} has no batch {batch}; ask for its table")
    return batches[batch]


@cache
def campaign_job(name, batch):
    """What the job of a batch reads and is given, in plain values; in a job of its own, as its run has planned it."""
    kept = KEPT_JOBS / name / f"{batch}.json"
    if not workflow.is_main_process and not OF_ANOTHER and kept.exists():
        return json.loads(kept.read_text(encoding="utf-8"))
    points, plan = campaign_points_of(name, batch), campaign_plan(name)
    products = sorted({product for product, _ in plan["shared"]})
    return {
        "inputs": campaign_grouping.inputs(points),
        "given": campaign_chain(name, points[0].volunteer, points[0].side),
        "batch": campaign_grouping.parameters(points, plan["shared"]),
        "read": campaign_of(name).read,
        "code": {product: library("campaign_batch.py", product) for product in products},
    }


def campaign_chain(name, volunteer, side):
    """Subject, settings and effects of the chain that the points of a breast vary."""
    cases = campaign_plan(name)["cases"]
    (case,) = [each for each in cases if (each.volunteer, each.side) == (volunteer, side)]
    return {
        "subject": subject_of({"v": volunteer, "side": side}),
        "settings": pruned(case.chain.settings, read_by(STAGES, campaign_of(name).read)),
        "effects": sorted(case.chain.effects),
    }


def keep_campaign_jobs():
    """Leave to the jobs of this run what they read and are given."""
    shutil.rmtree(KEPT_JOBS, ignore_errors=True)
    for job in [job for job in workflow.dag.needrun_jobs() if job.rule.name == "campaigns_batch"]:
        file = KEPT_JOBS / job.wildcards.campaign / f"{job.wildcards.batch}.json"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(campaign_job(*job.wildcards)), encoding="utf-8")


def campaign_batch_seconds(wildcards):
    """Processor seconds of a batch at the study's accuracy, with none of its points finished."""
    points = campaign_points_of(*wildcards)
    strategy = campaign_plan(wildcards.campaign)["cases"][0].chain.settings["load"].get("strategy", {})
    made = campaign_prediction.counts(points, strategy, ())
    known = {name: float(each["seconds"]) for name, each in COSTS.items()}
    return campaign_prediction.expected(made, known, pace=1.0, points=len(points), batches=1)


def campaign_cost(name):
    """What a prediction of its time is made of: what is to be made how often, and with which settings."""
    campaign, found = campaign_of(name), campaign_plan(name)
    settings = found["cases"][0].chain.settings
    strategy = settings["load"].get("strategy", {})
    done = {each.name for each in found["points"] if Path(f"results/campaigns/points/{each.name[:2]}/{each.name}.json").exists()}
    left = {each.name for each in found["points"] if each.name not in done and not each.rejected}
    return {
        "made": campaign_prediction.counts(found["points"], strategy, done),
        "points": len(left),
        "jobs": sum(any(each.name in left for each in batch) for batch in found["batches"].values()),
        "batches": f"results/campaigns/{name}/*.json",
        "settings": pruned(settings, read_by(STAGES, campaign.read)),
        "quantities": [ASKED_QUANTITIES[each] for each in campaign.asked],
        "kinds": (
            {each.name: campaign_prediction.paddle(each.changes.get("load.strategy", strategy)) for each in found["points"]}
            if strategy
            else {}
        ),
    }


def campaign_batches(name):
    """The files of all batches of a campaign."""
    return [f"results/campaigns/{name}/{batch}.json" for batch in campaign_plan(name)["batches"]]
