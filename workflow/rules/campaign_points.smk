# Functions of the campaigns: their files, the breasts and settings that they begin with, and their points.
from mammosim.study.campaigns import grouping as campaign_grouping
from mammosim.study.campaigns import points as campaign_points
from mammosim.study.campaigns import prediction as campaign_prediction
from mammosim.study.campaigns.campaign import ASKED as ASKED_QUANTITIES
from mammosim.study.campaigns.campaign import Campaign
from mammosim.study.campaigns.points import Case
from mammosim.study.campaigns.settings import Known

CAMPAIGNS = stems("config/campaigns")


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


def campaign_batch(wildcards):
    """The points of one batch. Raises WorkflowError where the campaign has no such batch."""
    batches = campaign_plan(wildcards.campaign)["batches"]
    if wildcards.batch not in batches:
        raise WorkflowError(f"campaign {wildcards.campaign} has no batch {wildcards.batch}; ask for its table")
    return batches[wildcards.batch]


def campaign_batch_given(wildcards):
    """Subject, settings and effects of the chain that the points of a batch vary."""
    first = campaign_batch(wildcards)[0]
    cases = campaign_plan(wildcards.campaign)["cases"]
    (case,) = [each for each in cases if (each.volunteer, each.side) == (first.volunteer, first.side)]
    breast = {"v": first.volunteer, "side": first.side}
    return {
        "subject": subject_of(breast),
        "settings": pruned(case.chain.settings, read_by(STAGES, campaign_of(wildcards.campaign).read)),
        "effects": sorted(case.chain.effects),
    }


def campaign_batch_points(wildcards):
    """The points of a batch as its job is given them."""
    shared = campaign_plan(wildcards.campaign)["shared"]
    return campaign_grouping.parameters(campaign_batch(wildcards), shared)


def campaign_batch_code(wildcards):
    """What the products that points share depend on, by product."""
    shared = campaign_plan(wildcards.campaign)["shared"]
    return {product: library("campaign_batch.py", product) for product in sorted({product for product, _ in shared})}


def campaign_batch_seconds(wildcards):
    """Processor seconds of a batch at the study's accuracy, with none of its points finished."""
    points = campaign_batch(wildcards)
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
