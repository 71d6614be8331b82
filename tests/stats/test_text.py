import re

import pandas as pd

from t2l.gains import Cell
from t2l.stats.identification import over_true, printable
from t2l.stats.text import latex, write_printed
from tests.stats.test_identification import TRUTH, found


def test_no_name_breaks_latex(tmp_path):
    """Names of joints have underscores, which LaTeX takes for an index."""
    table = over_true({Cell(16, 2): found(16, 2)}, TRUTH, ["fr3_joint1", "fr3_joint2"])
    paths = [tmp_path / f"table.{suffix}" for suffix in ("csv", "md", "tex")]
    write_printed(table, printable(table), paths)
    assert r"fr3\_joint1" in paths[2].read_text()
    assert "| fr3_joint1 |" in paths[1].read_text()


def test_signs_of_a_table_are_those_of_latex():
    text = latex(pd.DataFrame({"50 % of_it": ["a_b", "c & d", "± 5 %", "< 3", "+2.5"]}), {})
    for sign in "_&%":
        assert not re.search(rf"(?<!\\){sign}", text), text
    for part in (r"$\pm$ 5 \%", "$<$ 3", "$+$2.5", r"50 \% of\_it"):
        assert part in text
