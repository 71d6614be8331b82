"""The policy `lerobot_diffusion`: lerobot's Diffusion Policy (Chi et al. 2023)."""

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from t2l.policies.lerobot_policy import Keys, LeRobotPolicy, LeRobotSettings
from t2l.typed import Integer, Number

GROUPS = 8  # of channels that are normalised together, lerobot's `n_groups`


class DiffusionKeys(Keys):
    """Of lerobot's `DiffusionConfig`, smaller than there: no images are seen."""

    n_obs_steps: Integer = Field(
        10, ge=1, le=1_000, description="observations that it sees, in policy steps"
    )
    horizon: Integer = Field(
        20,
        ge=1,
        le=1_000,
        description="actions that are denoised at once, from the first observation that is seen; "
        "a multiple of 2 to the power of the number of `down_dims`",
    )
    n_action_steps: Integer = Field(
        10,
        ge=1,
        le=1_000,
        description="those of them that it answers with, from the latest observation on",
    )
    down_dims: Annotated[
        list[Annotated[Integer, Field(ge=GROUPS, le=4_096, multiple_of=GROUPS)]],
        Field(min_length=1, max_length=8),
    ] = Field([64, 64], description="channels of each stage of the U-Net, multiples of 8")
    kernel_size: Integer = Field(5, ge=1, le=99, description="of its convolutions, odd")
    num_train_timesteps: Integer = Field(
        100, ge=1, le=10_000, description="levels of noise while training"
    )
    noise_scheduler_type: Literal["DDIM", "DDPM"] = Field(
        "DDIM", description="how noise is taken away when acting"
    )
    num_inference_steps: Integer = Field(
        10, ge=1, le=10_000, description="steps from noise to actions: it acts so much slower"
    )
    scheduler_warmup_steps: Integer = Field(
        500, ge=0, description="gradient steps until the learning rate is at its peak"
    )
    optimizer_lr: Number = Field(1.0e-3, gt=0, le=10, description="peak of the learning rate")
    optimizer_weight_decay: Number = Field(1.0e-6, ge=0, le=10, description="weight decay of Adam")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.horizon % 2 ** len(self.down_dims):
            raise ValueError(f"a horizon that is a multiple of {2 ** len(self.down_dims)}")
        if self.dropped < 0:
            raise ValueError("n_action_steps of at most horizon - n_obs_steps + 1")
        if not self.kernel_size % 2:
            raise ValueError("an odd kernel_size")
        if self.num_inference_steps > self.num_train_timesteps:
            raise ValueError("num_inference_steps of at most num_train_timesteps")
        return self

    @property
    def dropped(self) -> int:
        """Last steps of an episode that no window starts at, as lerobot counts them."""
        return self.horizon - self.n_action_steps - self.n_obs_steps + 1

    def configuration(self) -> dict[str, Any]:
        """See `Keys.configuration`."""
        return self.model_dump() | {
            "down_dims": tuple(self.down_dims),
            "n_groups": GROUPS,
            "drop_n_last_frames": self.dropped,
        }


class Settings(DiffusionKeys, LeRobotSettings):
    """Of training, and of acting."""


class LeRobotDiffusion(LeRobotPolicy):
    """Acts by a sample of what was demonstrated."""

    name, kind = "lerobot_diffusion", "diffusion"
    settings, keys = Settings, DiffusionKeys
    chunk_setting = "n_action_steps"
    packages = ("lerobot", "diffusers")
