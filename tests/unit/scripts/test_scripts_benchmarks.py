"""What jobs took is read of every file that Snakemake may leave."""

import numpy as np
import pytest

HEAD = "s\th:m:s\tmax_rss\tcpu_time\n"


@pytest.fixture
def read(script, tmp_path):
    """read(**files): the jobs of these files of benchmarks, a rule each."""

    def jobs(**files: str):
        for rule, text in files.items():
            (tmp_path / rule).mkdir()
            (tmp_path / rule / "all.tsv").write_text(text)
        return script("_benchmarks").benchmarks(tmp_path)

    return jobs


def test_jobs_are_read_with_their_rules(read):
    found = read(mesh=HEAD + "2.0\t0:00:02\t300.5\t1.5\n", dose=HEAD + "9.0\t0:00:09\t800\t17\n")
    assert found[["rule", "s", "max_rss", "cpu_time"]].to_numpy().tolist() == [
        ["dose", 9.0, 800.0, 17.0],
        ["mesh", 2.0, 300.5, 1.5],
    ]


def test_a_job_too_short_to_be_measured_and_one_that_left_nothing_break_no_report(read):
    found = read(mesh=HEAD + "0.1\t0:00:00\tNA\tNA\n", dose=HEAD + "0.1\t0:00:00\t-\t-\n", field="")
    assert found.rule.tolist() == ["dose", "mesh"]
    assert found.s.sum() == pytest.approx(0.2)
    assert np.isnan(found[["max_rss", "cpu_time"]].to_numpy(float)).all()


def test_where_nothing_ran_there_is_no_job(read):
    assert read().empty
