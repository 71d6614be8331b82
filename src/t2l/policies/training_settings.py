"""What every policy that learns from windows of episodes may be told."""

from pydantic import Field

from t2l.typed import Integer, Number, Typed


class TrainingSettings(Typed):
    """Of `t2l.policies.training`."""

    # a minute of 50 Hz is 3000 steps
    history: Integer = Field(
        10, ge=1, le=1_000, description="observations that the policy sees, in policy steps"
    )
    chunk: Integer = Field(10, ge=1, le=1_000, description="actions that it predicts at once")
    epochs: Integer = Field(50, ge=1, le=10_000, description="passes over the training episodes")
    # all windows of a thousand demonstrations of 8 s
    batch_size: Integer = Field(256, ge=1, le=400_000, description="windows per gradient step")
    learning_rate: Number = Field(
        1.0e-3, gt=0, le=10, description="peak of a one-cycle schedule of the learning rate"
    )
    weight_decay: Number = Field(1.0e-4, ge=0, le=10, description="weight decay of AdamW")
