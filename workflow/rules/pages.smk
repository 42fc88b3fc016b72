# Pages of what is made on demand, and the scripts of others that pages use.
PAGE_SCRIPTS = expand("results/study/scripts/{name}", name=["datatables.js", "datatables.css", "plotly.js"])
PAGES = {}  # of results made on demand, target -> the tables and figures that its page shows


def page(target):
    """What the page of a target is made of: its text, its numbers, and the tables and figures of PAGES."""
    return {
        "text": page_text(target),
        "numbers": f"results/study/{target}.json",
        "tables": expand("results/study/{name}.csv", name=PAGES[target]["tables"]),
        "pictures": expand("results/study/figures/{name}.png", name=PAGES[target]["figures"]),
        "bibliography": str(HERE / "config/references.bib"),
        "scripts": PAGE_SCRIPTS,
    }


def page_text(target):
    """The file that says what stands on a page."""
    return str(HERE / "workflow" / "report" / f"{target}.yaml")


def made_pages(wildcards):
    """The numbers, tables and figures of every page that has been made: the report shows them, too."""
    made = []
    for parts in map(page, PAGES):
        files = [parts["numbers"], *parts["tables"], *parts["pictures"]]
        made += files if all(Path(file).exists() for file in files) else []
    return made
