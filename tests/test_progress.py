"""Stages of work, and what they tell."""

from nmaptool.core.progress import Stages, part


def test_a_part_tells_its_share_of_the_whole():
    told = []
    rebuilding = part(lambda word, share: told.append((word, share)), 0.25, 0.75)
    for share in (0.0, 0.5, 1.0):
        rebuilding("rebuilding", share)
    assert told == [("rebuilding", 0.25), ("rebuilding", 0.5), ("rebuilding", 0.75)]
    assert part(None, 0.25, 0.75) is None


def test_stages_are_timed_in_order_and_add_up_when_entered_again():
    told = []
    stages = Stages(lambda word, share: told.append((word, share)))
    with stages.stage("clean"):
        pass
    first = stages.elapsed["clean"]
    with stages.stage("draw", 0.5):
        pass
    with stages.stage("clean"):
        pass
    stages.tell("drawing", 1.0)
    assert list(stages.elapsed) == list(stages.seconds()) == ["clean", "draw"]
    assert stages.elapsed["clean"] > first > 0
    assert told == [("draw", 0.5), ("drawing", 1.0)]
    stages.elapsed["clean"] = 1.23456789
    assert (stages.seconds()["clean"], stages.seconds(digits=2)["clean"]) == (1.2346, 1.23)


def test_nobody_needs_to_listen():
    stages = Stages()
    with stages.stage("clean", 0.0):
        stages.tell("cleaning", 0.5)
    assert list(stages.seconds()) == ["clean"]
