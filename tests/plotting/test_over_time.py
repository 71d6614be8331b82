from t2l.plotting.over_time import panels_over_time


def test_signals_share_their_range_and_all_share_time():
    _, axes = panels_over_time(["joint 1 [rad]", "joint 2 [rad]"], ["CO", "SU", "SO"], 2.0, 1.0)
    axes[0, 0].plot([0, 4], [-3, 3])
    assert axes[0, 2].get_ylim() == axes[0, 0].get_ylim() != axes[1, 0].get_ylim()
    assert axes[1, 2].get_xlim() == axes[0, 0].get_xlim()
    assert [panel.get_ylabel() for panel in axes.flat] == [
        *("joint 1 [rad]", "", "", "joint 2 [rad]", "", ""),
    ]
    assert [panel.get_title() for panel in axes[0]] == ["CO", "SU", "SO"]
    assert [panel.get_xlabel() for panel in axes[1]] == ["time [s]"] * 3
