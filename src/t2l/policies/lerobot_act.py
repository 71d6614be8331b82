"""The policy `lerobot_act`: lerobot's ACT (Zhao et al. 2023).

lerobot's ACT sees one observation; the study's policies see ten. So what it takes for one holds the
latest few, side by side.
"""

from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from t2l.policies.lerobot_policy import Keys, LeRobotPolicy, LeRobotSettings
from t2l.typed import Integer, Number

Layers = Annotated[Integer, Field(ge=1, le=50)]
Width = Annotated[Integer, Field(ge=1, le=4_096)]


class ACTKeys(Keys):
    """Of lerobot's `ACTConfig`, smaller than there: no images are seen."""

    history: Integer = Field(
        10, ge=1, le=1_000, description="observations that it sees, in policy steps"
    )
    chunk_size: Integer = Field(10, ge=1, le=1_000, description="actions that it predicts at once")
    dim_model: Width = Field(64, description="numbers in a token, a multiple of `n_heads`")
    n_heads: Annotated[Integer, Field(ge=1, le=64)] = Field(4, description="heads of attention")
    dim_feedforward: Width = Field(256, description="width of the layers between attention")
    n_encoder_layers: Layers = Field(2, description="layers of the encoder")
    n_decoder_layers: Layers = Field(1, description="layers of the decoder")
    n_vae_encoder_layers: Layers = Field(2, description="layers of the latent's encoder")
    latent_dim: Integer = Field(8, ge=1, le=1_000, description="size of the latent")
    dropout: Number = Field(0.1, ge=0, lt=1, description="share of units left out while training")
    kl_weight: Number = Field(
        10, ge=0, description="weight of the latent's divergence from its prior"
    )
    optimizer_lr: Number = Field(3.0e-4, gt=0, le=10, description="learning rate")
    optimizer_weight_decay: Number = Field(1.0e-4, ge=0, le=10, description="weight decay of AdamW")

    @model_validator(mode="after")
    def _divides(self) -> Self:
        if self.dim_model % self.n_heads:
            raise ValueError("a dim_model that is a multiple of n_heads")
        return self

    @property
    def stacked(self) -> int:
        """See `Keys.stacked`."""
        return self.history

    def configuration(self) -> dict[str, Any]:
        """See `Keys.configuration`."""
        # how much of a chunk is carried out, whoever acts decides
        return self.model_dump(exclude={"history"}) | {"n_action_steps": self.chunk_size}


class Settings(ACTKeys, LeRobotSettings):
    """Of training."""


class LeRobotACT(LeRobotPolicy):
    """Acts by the mean of the latent's prior."""

    name, kind = "lerobot_act", "act"
    settings, keys = Settings, ACTKeys
    chunk_setting = "chunk_size"
