import numpy as np

from t2l.bc.collections import collection, task_of
from t2l.seeds import generator


def test_the_first_collection_is_what_was_there_before():
    assert collection("block_stack", 0) == "block_stack"


def test_collections_are_drawn_anew():
    names = [collection("block_stack", number) for number in range(3)]
    assert [task_of(name) for name in names] == ["block_stack"] * 3
    drawn = [generator(0, "rollouts", name).random(4) for name in names]
    assert len(np.unique(np.concatenate(drawn))) == 12
