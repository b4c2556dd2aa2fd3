"""The line that says what is proved: never more than is."""

import math
import re
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

import selfmotion as sm
from selfmotion.certificate.verdict import percent, proved_within, verdict


def test_the_seed_s_case():
    assert (
        verdict(4.8894466, 3e-12, 4.8890331, 5.2775112)
        == "5.2775 → 4.8894, proved within 0.0085 % of the best possible"
    )
    assert verdict(4.8894466, 3e-12, 4.8890331) == "4.8894, proved within 0.0085 % of the best possible"


def stated(text):
    return Fraction(re.search(r"within ([\d.]+) %", text)[1]) / 100


@given(st.floats(1e-3, 1e6), st.floats(0.0, 1.0), st.floats(0.0, 1e-3))
def test_the_percentage_never_overstates_and_hardly_understates(bound, above, error):
    cost = bound * (1 + above)
    said = stated(verdict(cost, error, bound))
    true = (Fraction(cost) + Fraction(error) - Fraction(bound)) / Fraction(bound)
    assert said >= true
    assert said <= max(true * Fraction("1.1001"), true + Fraction(2, 10**12))


@pytest.mark.parametrize(
    ("part", "text"),
    [(1e-4, "0.011 %"), (0.000095, "0.0096 %"), (0.0099001, "1 %"), (0.25, "25 %"), (1.0, "100 %"), (9.99, "1000 %")],
)
def test_percentages_are_rounded_up(part, text):
    """Also the rounding of the number itself counts: 1e-4 is a little more than that in binary."""
    assert percent(part) == text


def test_an_error_of_the_cost_counts():
    assert stated(verdict(1.0, 0.1, 1.0)) >= Fraction(1, 10)


@pytest.mark.parametrize(("cost", "error", "bound"), [(2.0, 0.0, 0.0), (2.0, math.inf, 1.0), (2.0, 0.0, -math.inf)])
def test_where_nothing_is_proved_it_says_so(cost, error, bound):
    assert verdict(cost, error, bound, 3.0) == "3.0000 → 2.0000, how far from the best possible is unknown"
    assert proved_within(cost, error, bound) == math.inf


def test_more_digits_where_more_is_proved():
    assert verdict(4.889446601, 0.0, 4.889446600, 5.2775112).startswith("5.2775 → 4.889446601, proved within 0.00000")


def test_equal_up_to_rounding_is_proved_and_a_contradiction_is_refused():
    assert stated(verdict(1.0, 0.0, 1.0 + 1e-12)) == Fraction(1, 10**12)
    with pytest.raises(sm.InvalidInputError, match="bound: is above the cost"):
        verdict(1.0, 0.0, 1.0 + 1e-6)
