import pytest

from snakemake_logger_plugin_t2l.progress import Progress, duration


def test_what_is_done_what_remains_and_how_long():
    progress = Progress({"train": 4, "plot": 1}, now=0.0)
    assert progress.plan() == "5 jobs: 4 train, 1 plot"
    progress.started(1, "train", {"cell": "kp16_kd2"}, now=0.0)
    progress.started(2, "train", {"cell": "kp16_kd24"}, now=0.0)
    assert progress.finished(1, now=10.0) == "1 of 5  train kp16_kd2  10 s; about 15 s left"
    # two side by side: three more of 10 s and the plot, guessed at 10 s, less 10 s under way
    assert progress.seconds_left(10.0) == pytest.approx((4 * 10 - 10) / 2)


def test_no_estimate_before_there_is_something_to_go_by():
    progress = Progress({"demonstrate": 1, "train": 9}, now=0.0)
    progress.started(1, "demonstrate", {}, now=0.0)
    assert progress.finished(1, now=100.0) == " 1 of 10  demonstrate  2 min"
    assert progress.seconds_left(100.0) is None


def test_a_quarter_of_the_jobs_is_enough_to_go_by():
    progress = Progress({"demonstrate": 1, "retarget": 1, "train": 6}, now=0.0)
    for job, rule in enumerate(("demonstrate", "retarget")):
        progress.started(job, rule, {}, now=10.0 * job)
        progress.finished(job, now=10.0 * (job + 1))
    assert progress.seconds_left(20.0) == pytest.approx(60.0)


def test_a_failed_job_is_not_done():
    progress = Progress({"train": 2}, now=0.0)
    progress.started(1, "train", {}, now=0.0)
    progress.failed(1)
    assert progress.finished(1, now=5.0) is None


def test_a_job_whose_start_was_not_seen_still_counts():
    progress = Progress({"train": 2, "plot": 1}, now=0.0)
    assert progress.finished(7, now=5.0, rule="train") == "1 of 3  train"
    assert progress.finished(8, now=6.0, rule="train") == "2 of 3  train"
    assert progress.finished(9, now=6.0, rule="unheard_of") is None


def test_durations_read_as_a_person_says_them():
    assert [duration(s) for s in (3.4, 89, 120, 5399, 7200)] == [
        "3 s",
        "89 s",
        "2 min",
        "90 min",
        "2.0 h",
    ]
