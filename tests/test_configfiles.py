import subprocess
import sys

import pytest
from snakemake.exceptions import CliException

from snakemake_logger_plugin_t2l import configfiles
from tests.conftest import ROOT

SMOKE = (ROOT / "config/studies/smoke.yaml").read_text()
BOMB = "a0: &a0 [x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 8)}]\n" for i in range(1, 40)
)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("twice.yaml", SMOKE + "study: x\n", "the key 'study' twice"),
        ("twice.json", '{"seed": 1, "seed": 2}', "the key 'seed' twice"),
        ("bomb.yaml", SMOKE + BOMB, "more values, aliases written out"),
        ("recursive.yaml", SMOKE + "x: &x [*x]\n", "*x within itself"),
        ("binary.yaml", bytes(range(256)), "what is not text in UTF-8"),
        ("utf_16.yaml", SMOKE.encode("utf-16"), "what is not text in UTF-8"),
        ("latin_1.yaml", f"{SMOKE}# é".encode("latin-1"), "what is not text in UTF-8"),
        ("deep.yaml", f"a: {'[' * 100_000}", "deeper nesting"),
        ("deep.json", f'{{"a": {"[" * 100_000}', "too many levels"),
        ("huge.yaml", SMOKE + "#" * 2_000_000, "more than 1000000 bytes"),
        ("digits.yaml", f"seed: {'9' * 5000}", "what is not YAML"),
        ("list.yaml", "- 1", "found a list; allowed: a configuration, keys with values"),
        ("empty.yaml", "", "found nothing; allowed: a configuration"),
    ],
)
def test_what_cannot_be_a_configuration_is_told_with_its_file(tmp_path, name, content, message):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(CliException) as error:
        configfiles.load(path)
    text = str(error.value)
    assert text.startswith(f"{path}: ")
    assert message in text
    assert len(text.splitlines()) == 1


def test_numbers_are_read_as_t2l_reads_them_everywhere(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("rate: 1e-3\nday: 2026-01-02\n1: 2\n")
    assert configfiles.load(path) == {"rate": 1e-3, "day": "2026-01-02", 1: 2}


def test_snakemake_uses_it_wherever_it_parses_arguments():
    code = (
        "from snakemake.cli import get_argument_parser; get_argument_parser();"
        "from snakemake.common import configfile; print(configfile._load_configfile.__module__)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "snakemake_logger_plugin_t2l.configfiles", done.stderr
