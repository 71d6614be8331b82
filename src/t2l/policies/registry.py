"""Where the name of a policy becomes a class; a class of the user's may stand beside these."""

from t2l.policies.policy import Policy
from t2l.registry import Registry

POLICIES: Registry[Policy] = Registry(
    "policy",
    Policy,
    {
        "chunk_cvae": "t2l.policies.chunk_cvae:ChunkCVAE",
        "chunk_diffusion": "t2l.policies.chunk_diffusion:ChunkDiffusion",
        "chunk_regression": "t2l.policies.chunk_regression:ChunkRegression",
        "chunk_transformer": "t2l.policies.chunk_transformer:ChunkTransformer",
        "gaussian_mlp": "t2l.policies.gaussian_mlp:GaussianMLP",
        "lerobot_act": "t2l.policies.lerobot_act:LeRobotACT",
        "lerobot_diffusion": "t2l.policies.lerobot_diffusion:LeRobotDiffusion",
    },
)
