"""A trained policy as a function of NumPy arrays."""

from collections.abc import Callable

import numpy as np
import torch

from t2l.policies.chunk_cvae import ChunkCVAE


def acting(policy: ChunkCVAE, threads: int = 1) -> Callable[[np.ndarray], np.ndarray]:
    """Map histories (n, history, nobs) to chunks (n, chunk, nact), where the weights are."""
    torch.set_num_threads(threads)
    device = policy.action_mean.device

    @torch.inference_mode()
    def act(history: np.ndarray) -> np.ndarray:
        observed = torch.as_tensor(history, dtype=torch.float32, device=device)
        return policy(observed).cpu().numpy()

    return act
