"""Train one pairing of gains and behaviour from one seed, and push it on the way."""

from t2l.artefacts import write_table
from t2l.jobs import job
from t2l.policies import checkpoint
from t2l.rl.settings import Settings
from t2l.study.decoupling.pairing import Pairing
from t2l.study.decoupling.training import make_probe, train

with job(snakemake):
    params, section = snakemake.params, snakemake.params.decoupling
    seed = int(snakemake.wildcards.seed)
    table, policy = train(
        Pairing(**params.pairing),
        section["task"],
        params.task,
        make_probe(section, params.seed),
        Settings(**{**params.settings, "seed": seed}),
        params.horizon_s,
        section["torque_share"],
        snakemake.threads,
    )
    checkpoint.save(policy, snakemake.output.policy)
    write_table(table, snakemake.output.stiffness)
