import pytest
import torch

from t2l.policies.captured import Captured


def losses(device):
    """A function of two tensors that reads a third, and the third."""
    weight = torch.linspace(-1, 1, 12, device=device).view(4, 3).requires_grad_()

    def gradient(inputs, *, targets):
        loss = ((inputs @ weight).tanh() - targets).square().mean()
        return loss.detach(), *torch.autograd.grad(loss, [weight])

    return gradient, weight


@pytest.mark.parametrize(
    "device",
    [
        "cpu",
        pytest.param(
            "cuda", marks=pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU")
        ),
    ],
)
def test_it_computes_what_the_function_does_when_what_it_reads_has_changed(device):
    function, weight = losses(device)
    captured = Captured(function)
    for i in range(3):
        inputs = torch.randn(5, 4, generator=torch.Generator().manual_seed(i)).to(device)
        targets = inputs[:, :3].cos()
        found = [each.clone() for each in captured(inputs, targets=targets)]
        for one, other in zip(found, function(inputs, targets=targets), strict=True):
            torch.testing.assert_close(one, other)
        with torch.no_grad():
            weight += 0.1
