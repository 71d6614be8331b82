import re
from pathlib import Path

import numpy as np
import pytest

from t2l.advise.advice import Asked, advised
from t2l.advise.grid import of
from t2l.identify.model import Model
from t2l.report.advice import write_advice_page

# a name that is text in a page and nothing else
NAME = "<b>hinge</b>"
ROBOT = """<mujoco><worldbody><body><joint name="&lt;b&gt;hinge&lt;/b&gt;" axis="0 1 0"/>
<geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.3" mass="0.5"/></body></worldbody></mujoco>"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    (folder / "arm.xml").write_text(ROBOT)
    unlimited = np.full(1, np.inf)
    advice = advised(
        Asked(
            Model(str(folder / "arm.xml")), (NAME,), np.array([[0.3]]),
            of([2.0, 20.0], [0.05, 1.0]), np.ones((1, 2)), 1000.0, 50.0, True,
            np.array([[-np.inf, np.inf]]), unlimited, unlimited,
        )
    )  # fmt: skip
    picture = folder / "picture.png"
    picture.write_bytes(b"picture")
    write_advice_page(advice, {"maps": picture, "reasons": picture}, folder, measured=False)
    return Path(folder / "report.html").read_text()


def test_the_answer_comes_first(page):
    assert page.index("the best of what is left") < page.index("What is ruled out, and why")
    assert "What would change it" in page


def test_names_from_files_are_text(page):
    assert NAME not in page
    assert "&lt;b&gt;hinge&lt;/b&gt;" in page


def test_the_page_needs_nothing_else(page):
    assert not re.search(r"(src|href)=\"(?!data:|#)", page)
    assert "<script" not in page
