import yaml

from t2l.registry import TRUST

BOMB = "a0: &a0 [x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 8)}]\n" for i in range(1, 40)
)

BLIND = """
from t2l.tasks.block_stack import BlockStack


class Blind(BlockStack):
    name = "blind"

    def spec(self, visual):
        spec = super().spec(visual)
        if visual:
            spec.worldbody.add_camera(name="sky", pos=(0, 0, 50), xyaxes=(1, 0, 0, 0, -1, 0))
        return spec
"""


def test_a_bad_configuration_stops_before_the_first_job(empty_project):
    config = empty_project.config
    config["grid"]["kp"], config["grid"]["kd"] = [0, 32], []
    config["training"]["epoch"] = 3
    config["demonstrations"]["count"] = 0
    config[1] = 2
    done = empty_project.run("--", "all")
    assert done.returncode == 1
    for message in (
        "config: grid.kp[0]: found 0; allowed: a number above 0",
        "config: grid.kd: found []; allowed: a list with at least 1 element",
        "config: training.epoch: found an unknown key (did you mean epochs?)",
        "config: demonstrations.count: found 0; allowed: a number from 2 up",
        "config: 1: found an unknown key; allowed: study, seed,",
    ):
        assert message in done.stdout
    assert "Traceback" not in done.stdout
    assert not empty_project.results.exists()


def test_a_file_that_is_no_configuration_is_named_once(empty_project):
    config = empty_project.folder / "config/config.yaml"
    config.write_text(config.read_text() + "study: x\n")
    bomb = empty_project.folder / "bomb.yaml"
    bomb.write_text(BOMB)
    for done, message in (
        (
            empty_project.run_default("--dry-run", "--", "all"),
            "config/config.yaml: the file: found what is not YAML (the key 'study' twice",
        ),
        (
            empty_project.run("--dry-run", "--configfile", str(bomb), "--", "all"),
            f"{bomb}: line 6: found more values, aliases written out",
        ),
    ):
        assert done.returncode == 1
        assert done.stdout.count(message) == 1
        assert done.stdout.count("found") == 1
        assert "Traceback" not in done.stdout


def test_a_study_inherits_nothing_from_the_default_one(empty_project):
    default = empty_project.folder / "config/config.yaml"
    default.write_text("study: mine\ngrid: {kp: [32]}\ndiagnosis: {recordings: [nowhere]}\n")
    assert "nowhere" in empty_project.run_default("--dry-run", "--", "all").stdout
    assert empty_project.planned("all")["train"] == 4


def test_the_target_of_a_diagnosis_names_the_section_that_it_needs(empty_project):
    done = empty_project.run("--dry-run", "--", "diagnosis")
    assert done.returncode == 1
    said = "config: diagnosis: found nothing; allowed: this section, with recordings to explain"
    assert done.stdout.splitlines()[-1] == said
    assert "Traceback" not in done.stdout
    assert "explain" not in empty_project.planned("all")


def test_an_expert_that_cannot_is_named_before_the_first_job(empty_project):
    path = empty_project.folder / "config/tasks/block_stack.yaml"
    task = yaml.safe_load(path.read_text())
    # nobody stacks to a micrometre
    path.write_text(yaml.safe_dump({**task, "placement_tolerance_m": 1e-6}))
    done = empty_project.run("--", "all")
    assert done.returncode != 0
    assert "config/tasks/block_stack.yaml: found a task that its expert fails at" in done.stdout
    assert not empty_project.results.exists()
    # what does not wait for demonstrations is not held up by it
    measured = "results/smoke/attenuation/held_noise.parquet"
    assert empty_project.run("--", measured).returncode == 0


def test_a_camera_that_sees_nothing_is_named_before_the_first_job(empty_project, monkeypatch):
    monkeypatch.setenv(TRUST, "1")
    extension = empty_project.folder / "sky.py"
    extension.write_text(BLIND)
    path = empty_project.folder / "config/tasks/block_stack.yaml"
    path.write_text(yaml.safe_dump({**yaml.safe_load(path.read_text()), "kind": "blind"}))
    config = empty_project.config
    config["extensions"] = [str(extension)]
    config["variants"] = {"seeing": {"observation": {"cameras": ["sky"], "size_px": 32}}}
    done = empty_project.run("--", "all")
    assert done.returncode != 0
    assert "camera sky: found pictures of one colour" in done.stdout
    assert not empty_project.results.exists()


def test_a_cell_where_the_operator_fails_is_named_and_leaves_nothing(empty_project):
    """And the other cell goes on."""
    config = empty_project.config
    config["grid"] = {"kp": [1, 2048], "kd": [1], "overdamped_from_kd": 1}
    config["demonstrations"] = {"count": 2, "max_attempts": 2}
    config["fidelity"]["replays"] = 2
    config["operator"] = {"motor_noise": 0, "crossover_rad_s": [3]}
    cells = empty_project.results / "block_stack" / "nominal"
    wanted = [f"results/smoke/block_stack/nominal/kp{kp}_kd1/episodes.parquet" for kp in (1, 2048)]
    done = empty_project.run("--", *wanted)
    assert done.returncode != 0
    assert "Kp 1, Kd 1: 0 of 2 attempts of the operator succeed" in done.stdout
    assert not list(cells.glob("kp1_kd1/*"))
    made = sorted(path.name for path in cells.glob("kp2048_kd1/*"))
    assert made == ["episodes.parquet", "replays.parquet"]
