import numpy as np
import pytest

from t2l.design.collinearity import COLLINEAR, Responses

RNG = np.random.default_rng(0)
N = 400
A, B, C, BASE, NOISE = RNG.normal(size=(5, N))


def responses(base=None, excludes=None, **columns):
    blocks = [np.reshape(column, (-1, N)).T for column in columns.values()]
    names = [name for name, block in zip(columns, blocks, strict=True) for _ in block.T]
    base = np.zeros((N, 0)) if base is None else base[:, None]
    return Responses(np.concatenate(blocks, axis=1), names, base, excludes or {})


def rivals(found, part, most=np.inf, name="it"):
    return [rival.effects for rival in found.rivals(name, part, part, most)]


def test_what_nearly_lies_in_the_span_of_another_or_of_two_is_not_told_from_them():
    one = A + B
    found = responses(it=one, first=A, second=B, third=C)
    assert rivals(found, one) == [("first", "second")]
    found = responses(it=one, first=[A, B], second=B)
    # a pair with one that does it alone says nothing more
    assert rivals(found, one) == [("first",)]


@pytest.mark.parametrize(("times", "told"), [(0.9, False), (1.1, True)])
def test_the_collinearity_index_decides(times, told):
    apart = NOISE - A * (NOISE @ A) / (A @ A)
    apart *= np.linalg.norm(A) / np.linalg.norm(apart)
    other = A + times * apart / np.sqrt(COLLINEAR**2 - 1)
    found = responses(it=A, other=other)
    assert (rivals(found, A) == []) == told
    if not told:
        assert found.rivals("it", A, A, np.inf)[0].collinearity == pytest.approx(
            COLLINEAR / times, rel=0.01
        )


def test_what_the_model_can_do_itself_tells_nothing():
    # it and other share only what the model's own parameters do
    found = responses(BASE, it=BASE + 0.1 * A, other=BASE + 0.1 * B)
    assert rivals(found, BASE + 0.1 * A) == []
    found = responses(BASE, it=A, other=A + 5 * BASE)
    assert rivals(found, A) == [("other",)]


def test_what_leaves_more_or_contains_it_is_no_rival():
    assert rivals(responses(it=A, other=A), A, most=-1e-9 + 0.0) == []
    assert rivals(responses(it=A, other=A, excludes={"it": {"other"}}), A) == []


def test_the_nearest_part_of_a_target():
    found = responses(it=[A, B])
    part = found.part("it", 2 * A - B + 0.5 * C)
    expected = np.stack([A, B], 1) @ np.linalg.lstsq(np.stack([A, B], 1), 2 * A - B + 0.5 * C)[0]
    np.testing.assert_allclose(part, expected, atol=1e-6)
