"""Stages of work and their progress reports."""

from nmaptool.core.progress import Stages, part


def test_a_part_reports_its_share_of_the_whole():
    told = []
    rebuilding = part(lambda word, share: told.append((word, share)), 0.25, 0.75)
    for share in (0.0, 0.5, 1.0):
        rebuilding("rebuilding", share)
    assert told == [("rebuilding", 0.25), ("rebuilding", 0.5), ("rebuilding", 0.75)]
    assert part(None, 0.25, 0.75) is None


def test_stages_are_timed_in_order_and_add_up_when_entered_again(monkeypatch):
    clock = iter([0.0, 1.0, 5.0, 7.0, 10.0, 10.123456])
    monkeypatch.setattr("time.perf_counter", lambda: next(clock))
    told = []
    stages = Stages(lambda word, share: told.append((word, share)))
    with stages.stage("clean"):
        pass
    with stages.stage("draw", 0.5):
        pass
    with stages.stage("clean"):
        pass
    stages.tell("drawing", 1.0)
    assert list(stages.elapsed) == ["clean", "draw"]
    assert stages.seconds() == {"clean": 1.1235, "draw": 2.0}
    assert stages.seconds(digits=2) == {"clean": 1.12, "draw": 2.0}
    assert told == [("draw", 0.5), ("drawing", 1.0)]


def test_a_callback_is_optional():
    stages = Stages()
    with stages.stage("clean", 0.0):
        stages.tell("cleaning", 0.5)
    assert list(stages.seconds()) == ["clean"]
