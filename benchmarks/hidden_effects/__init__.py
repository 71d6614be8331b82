"""Recordings of robots that hide a physical effect from their model, to judge a diagnosis by.

Nothing here is shared with t2l: the physics, the controller and the log's format are written
anew from their definitions, so that a mistake made there is not made here too.

    python -m benchmarks.hidden_effects OUT           write every case
    python -m benchmarks.hidden_effects OUT NAME ...  some of them

Each case is a folder `OUT/NAME` with recordings in `train/` and `holdout/`; `truth.yaml` says what
is hidden, `visibility.csv` how far each effect moves the joints, in multiples of the encoder's
noise.
"""
