"""What jobs took stands beside what they would ask a cluster for."""

import runpy


def written(folder, rule, seconds, cpu, mb):
    (folder / rule).mkdir(parents=True, exist_ok=True)
    text = f"s\tmax_rss\tcpu_time\n{seconds}\t{mb}\t{cpu}\n"
    (folder / rule / f"{seconds}.tsv").write_text(text)


def test_a_line_per_rule_says_what_was_taken_of_what(repository, tmp_path):
    table = runpy.run_path(str(repository / "tools/efficiency.py"))["main"]
    assert "has no benchmarks" in table(tmp_path)
    for seconds in (60.0, 120.0):
        written(tmp_path, "compress", seconds, seconds / 2, 600.0)
    written(tmp_path, "mesh", 60.0, 60.0, 9000.0)
    written(tmp_path, "rule_that_is_gone", 1.0, 1.0, 1.0)
    compress, mesh = table(tmp_path).splitlines()[1:]
    assert compress.split()[:4] == ["compress", "2", "50", "600"]
    assert int(compress.split()[4]) > 600
    assert compress.split()[5] == "2.0"
    assert "more than asked for" not in compress
    assert mesh.startswith("mesh ")
    assert mesh.endswith("more than asked for")
