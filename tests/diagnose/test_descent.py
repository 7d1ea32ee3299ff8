"""A fit is done once the noise that it leaves asks for no other figures."""

from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from rcc_sim.diagnose.fitting import descent


@dataclass(frozen=True)
class Fitted:
    """What a fit would be of one figure: how far it is off, and its score."""

    score: float
    off: float
    noise: float = 0.0
    values: tuple = ()
    knobs: tuple = ()
    signals: tuple = ()

    @property
    def residuals(self):
        return self.off


class Engine(SimpleNamespace):
    """Noise that takes up ``share`` of what a figure is off leaves it as much off."""

    def evaluate(self, values, knobs, noise):
        return Fitted(0.0, 100.0, 50.0 if noise is None else noise)

    def signals(self, values, knobs):
        return ()

    def learn_noise(self, residuals):
        return self.share * residuals

    def judged(self, fit, noise):
        return Fitted(fit.score, fit.off, noise)


def improved(engine, now, rounds, *, settled):
    """Gain what a figure is off by more than the noise hides."""
    return Fitted(now.score + now.off - now.noise, now.noise, now.noise)


@pytest.mark.parametrize("share", [0.1, 0.5])
def test_noise_is_learnt_until_that_leads_no_further(share, monkeypatch):
    monkeypatch.setattr(descent, "improved", improved)
    found = descent.fit(Engine(share=share), {}, [])
    assert found.off < 1.0


def test_a_fit_that_lacks_more_than_it_has_gained_is_given_up(monkeypatch):
    monkeypatch.setattr(descent, "improved", improved)
    found = {
        least: descent.fit(Engine(share=0.5), {}, [], least=least)
        for least in (99.0, 120.0)
    }
    assert found[99.0].score > 99.0
    assert (found[120.0].score, found[120.0].off) == (50.0, 50.0)
