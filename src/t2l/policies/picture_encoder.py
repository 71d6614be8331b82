"""Where in pictures things are: a small convolutional network, trained with the policy that asks.

Its maps become points by a spatial softmax (Levine, Finn, Darrell and Abbeel, End-to-end training
of deep visuomotor policies, 2016): few numbers that say where, finer than a pixel.
"""

import torch
from torch import Tensor, nn

from t2l.policies.chunk_policy import FEATURES

CHANNELS = FEATURES // 3
# of the softmax: with 1, maps of unit variance would weigh hundreds of places nearly alike at first
SHARPNESS = 4.0


class PictureEncoder(nn.Module):
    """A network a camera, which share nothing: their views have nothing in common."""

    def __init__(self, cameras: int):
        super().__init__()
        self.cameras = nn.ModuleList(_Maps() for _ in range(cameras))

    def forward(self, pictures: Tensor) -> Tensor:
        """(n, ncamera · FEATURES) of pictures (n, ncamera, height, width, 3) uint8."""
        # black is -2, white is 2
        scaled = pictures.movedim(-1, 2).float() * (4 / 255) - 2
        views = scaled.unbind(dim=1)
        return torch.cat(
            [_points(maps(view)) for maps, view in zip(self.cameras, views, strict=True)], dim=1
        )


class _Maps(nn.Sequential):
    """From (n, 3, height, width) to CHANNELS maps of a quarter of the side."""

    def __init__(self):
        layers = (
            nn.Conv2d(3, 16, 5, stride=2, padding=2),
            nn.Conv2d(16, 32, 3, stride=2, padding=1),
            nn.Conv2d(32, CHANNELS, 3, padding=1),
        )
        for layer in layers:
            nn.init.kaiming_normal_(layer.weight, nonlinearity="relu")
            nn.init.zeros_(layer.bias)
        first, second, last = layers
        super().__init__(first, nn.ReLU(), second, nn.ReLU(), last)


def _points(maps: Tensor) -> Tensor:
    """(n, 3 · channels): of each map the mean place, from -1 to 1, and the mean value there."""
    rows, columns = maps.shape[-2:]
    share = (SHARPNESS * maps.flatten(2)).softmax(dim=2)
    y = torch.linspace(-1, 1, rows, device=maps.device).repeat_interleave(columns)
    x = torch.linspace(-1, 1, columns, device=maps.device).repeat(rows)
    return torch.cat([(share * of).sum(dim=2) for of in (x, y, maps.flatten(2))], dim=1)


def shifted(pictures: Tensor, offsets: Tensor) -> Tensor:
    """Pictures (n, ncamera, height, width, 3) moved by offsets (n, ncamera, 2), down and right.

    What comes in at an edge repeats it.
    """
    n, cameras, rows, columns = pictures.shape[:4]
    device = pictures.device
    down, right = (offset[:, :, None] for offset in offsets.unbind(dim=2))
    row = (torch.arange(rows, device=device) - down).clamp(0, rows - 1)
    column = (torch.arange(columns, device=device) - right).clamp(0, columns - 1)
    which = torch.arange(n, device=device)[:, None, None, None]
    camera = torch.arange(cameras, device=device)[:, None, None]
    return pictures[which, camera, row[..., None], column[:, :, None]]
