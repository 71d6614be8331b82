from t2l.identify.progress import forward, part, pieces


def told(wrap):
    fractions = []
    return wrap(lambda what, fraction: fractions.append(fraction)), fractions


def test_pieces_of_any_number_never_go_back_nor_reach_the_end():
    progress, fractions = told(lambda report: report)
    for _, piece in zip(range(6), pieces(progress), strict=False):
        for fraction in (0.0, 0.5, 1.0):
            piece("", fraction)
    assert fractions == sorted(fractions)
    assert fractions[:4] == [0.0, 0.25, 0.5, 0.5]
    assert fractions[-1] < 1


def test_a_part_covers_its_share():
    progress, fractions = told(lambda report: part(report, 0.5, 0.7))
    for fraction in (0.0, 0.5, 1.0):
        progress("", fraction)
    assert fractions == [0.5, 0.6, 0.7]


def test_a_fraction_that_begins_again_is_held():
    progress, fractions = told(forward)
    for fraction in (0.0, 0.8, 0.1, 0.9):
        progress("", fraction)
    assert fractions == [0.0, 0.8, 0.8, 0.9]
