"""Benchmarks are run by hand and seldom: that they begin at all is tested."""

from importlib import import_module
from pkgutil import iter_modules

import pytest

import benchmarks
from benchmarks import earlier
from benchmarks.scene import ROOT
from t2l.effects.registry import builtin

MODULES = [module.name for module in iter_modules(benchmarks.__path__) if not module.ispkg]


@pytest.mark.parametrize("name", sorted(set(MODULES) - {"__main__"}))
def test_a_benchmark_can_be_imported(name):
    import_module(f"benchmarks.{name}")


def test_a_checkout_says_which_effects_it_knows():
    assert earlier.names(ROOT) == list(builtin())
