from t2l.report.words import (
    estimate,
    gains,
    mrad,
    number,
    sentence,
    span,
    title_in,
)


def test_numbers_read_well():
    assert mrad(0.0121477) == "12.1 mrad"
    assert mrad(3.2e-5) == "0.032 mrad"
    assert mrad(None) == "–"
    assert number(1234.5) == "1230"
    assert number(0) == "0"
    assert number(-3e-7) == "−3.00 · 10⁻⁷"
    assert number(-0.45) == "−0.45"


def test_an_estimate_has_two_digits_of_its_interval():
    assert estimate(0.12003, (0.1199, 0.1201)) == ("0.12003", "0.1199 to 0.1201")
    assert estimate(0.0, None) == ("0", "–")


def test_several_values_are_one_phrase():
    assert span([16, 512, 64], "N") == "16 to 512 N"
    assert span([3, 3]) == "3"
    assert gains([5.0, 5.0]) == "5"
    assert gains([5.0, 7.5]) == "5/7.5"


def test_a_sentence_begins_and_ends():
    assert sentence("a < b") == "A < b."
    assert sentence(" why? ") == "Why?"
    assert sentence("") == ""
    assert sentence("from -0.45 to -.2 rad in log-3") == "From −0.45 to −.2 rad in log-3."


def test_an_effect_without_a_title_has_a_name():
    assert title_in("armature", {"armature": "Rotor inertia"}) == "Rotor inertia"
    assert title_in("my_own", {}) == "my own"
